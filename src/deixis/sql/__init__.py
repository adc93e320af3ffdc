"""The rules as SQL on DuckDB: all relations of a scene at once, with their margins."""

from deixis.ruleset.tables import Table
from deixis.sql.executor import SqlExecutor, silence
from deixis.sql.script import script

__all__ = ["SqlExecutor", "Table", "script", "silence"]
