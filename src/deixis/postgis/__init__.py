"""Grounding in PostgreSQL with PostGIS and SFCGAL, by the operators that section 4.2 of the paper names.

The same Facts as :func:`deixis.grounding.ground` returns for boxes, so that every rule runs on them. It is
slower by orders of magnitude, and there to show that Table 1 of the paper holds (``kb/coverage.md``).
"""

from deixis.postgis.grounding import ground

__all__ = ["ground"]
