"""Solids: things measured as their convex hull or mesh, where a box is not enough (decision 0017)."""

from deixis.solids.narrowphase import measure_regions
from deixis.solids.sides import meet_regions
from deixis.solids.solid import Solids
from deixis.solids.touching import touching_points

__all__ = ["Solids", "measure_regions", "meet_regions", "touching_points"]
