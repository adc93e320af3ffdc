"""The rules as SPARQL: text for any triple store, and one in memory that runs it (the extra ``rdf``)."""

from typing import TYPE_CHECKING, Any

from deixis.rdf.sparql import constructs

if TYPE_CHECKING:
    from deixis.rdf.executor import SparqlExecutor

__all__ = ["SparqlExecutor", "constructs"]


def __getattr__(name: str) -> Any:
    # The text can be had without a triple store.
    if name == "SparqlExecutor":
        from deixis.rdf.executor import SparqlExecutor

        return SparqlExecutor
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
