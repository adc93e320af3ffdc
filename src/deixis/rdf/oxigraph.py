"""pyoxigraph, or a message that says how to get it: the one place it is imported."""

from __future__ import annotations

from deixis.errors import MissingDependency

__all__ = ["ox"]

try:
    import pyoxigraph as ox
except ModuleNotFoundError as error:
    if error.name != "pyoxigraph":
        raise
    raise MissingDependency("RDF needs pyoxigraph: pip install 'deixis[rdf]'") from None
