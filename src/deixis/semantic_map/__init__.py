"""The semantic map (section 4.1 of the paper): frames in a database, the scene of any time, what held when.

A map is one DuckDB file, or a PostgreSQL database that several robots share; both are used alike.
"""

from deixis.semantic_map.doors import create_map, open_map
from deixis.semantic_map.history import SemanticMap, ruleset_of
from deixis.semantic_map.intervals import Between, Interval
from deixis.semantic_map.store import Frame, Sighting

__all__ = [
    "Between",
    "Frame",
    "Interval",
    "SemanticMap",
    "Sighting",
    "create_map",
    "open_map",
    "ruleset_of",
]
