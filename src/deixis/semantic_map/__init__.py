"""The semantic map (section 4.1 of the paper): frames kept in a database, and the scene of any time.

A map is one DuckDB file, or a PostgreSQL database that several robots share; both are used alike.
"""

from deixis.semantic_map.store import Frame, SemanticMap, Sighting, create_map, open_map

__all__ = ["Frame", "SemanticMap", "Sighting", "create_map", "open_map"]
