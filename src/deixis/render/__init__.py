"""Renderers: an explanation as HTML, as a graph for Graphviz, and the schema of its JSON."""

from deixis.render.dot import dot
from deixis.render.html import fragment, page
from deixis.render.schema import explanation_schema
from deixis.render.shown import Shown

__all__ = ["Shown", "dot", "explanation_schema", "fragment", "page"]
