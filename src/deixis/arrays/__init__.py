"""All that follows from facts, derived set at a time in memory, by array operations alone."""

from deixis.arrays.executor import ArrayExecutor
from deixis.arrays.rows import TooMany

__all__ = ["ArrayExecutor", "TooMany"]
