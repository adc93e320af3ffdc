"""Words of the layout that are written and read: the relations' own are in :mod:`deixis.vocabulary`."""

from __future__ import annotations

from typing import Final

from deixis.rdf.namespaces import DCTERMS, RDFS

IDENTIFIER: Final = DCTERMS + "identifier"
LABEL: Final = RDFS + "label"

BOX_NUMBERS: Final = ("centerX", "centerY", "centerZ", "sizeX", "sizeY", "sizeZ")
"""The numbers of a box, metres, in the order of center and size in a scene file."""

POSITION_NUMBERS: Final = ("positionX", "positionY", "positionZ")

THRESHOLDS: Final = {
    "granularity": "granularity",
    "penetration": "penetration",
    "closeness": "closeness",
    "halfspace_scale": "halfspaceScale",
    "pose_noise": "poseNoise",
    "piece_gap": "pieceGap",
}
"""Threshold to its property."""
