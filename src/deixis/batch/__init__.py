"""Data sets: the relations of any number of scenes, from JSON lines, Parquet or folders to Parquet."""

from deixis.batch.relate import Relate
from deixis.batch.schema import ERRORS, RELATIONS, SCENES

__all__ = ["ERRORS", "RELATIONS", "SCENES", "Relate"]
