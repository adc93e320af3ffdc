"""The rules as SPARQL in a triple store; needs the extra ``rdf``."""

from deixis.rdf.sparql import constructs

__all__ = ["SparqlExecutor", "constructs"]

try:
    from deixis.rdf.executor import SparqlExecutor
except ModuleNotFoundError as error:
    if error.name != "pyoxigraph":
        raise
    from deixis.errors import MissingDependency

    raise MissingDependency("SPARQL needs pyoxigraph: pip install 'deixis[rdf]'") from None
