"""A server of scenes: SPARQL, graphs and JSON over HTTP; needs the extra ``server``."""

from deixis.server.settings import Limits, Settings

__all__ = ["Limits", "Settings"]
