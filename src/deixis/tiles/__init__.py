"""Maps larger than memory: cut into tiles, each done with what is around it, and put together."""

from deixis.tiles.run import Summary, run
from deixis.tiles.schema import OBJECTS, RELATIONS, THINGS

__all__ = ["OBJECTS", "RELATIONS", "THINGS", "Summary", "run"]
