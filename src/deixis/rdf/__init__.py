"""Scenes and rules as RDF: exported, imported, derived in a triple store; needs the extra ``rdf``."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

from deixis.rdf.sparql import constructs

if TYPE_CHECKING:
    from deixis.rdf.bridge import dataset
    from deixis.rdf.executor import SparqlExecutor

__all__ = ["SparqlExecutor", "constructs", "dataset"]

_HOMES: Final = {"SparqlExecutor": "deixis.rdf.executor", "dataset": "deixis.rdf.bridge"}


def __getattr__(name: str) -> object:
    # Loaded on first use: what only writes rules or the ontology needs no triple store.
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
