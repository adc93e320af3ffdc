"""Data sets: the relations of any number of scenes, from JSON lines, Parquet or folders to Parquet."""

from deixis.errors import MissingDependency

try:
    import pyarrow as pa  # noqa: F401 - all modules here need it
except ModuleNotFoundError:
    raise MissingDependency("data sets need pyarrow: pip install 'deixis[batch]'") from None

from deixis.batch.relate import Relate
from deixis.batch.schema import ERRORS, RELATIONS, SCENES

__all__ = ["ERRORS", "RELATIONS", "SCENES", "Relate"]
