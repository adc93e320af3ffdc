"""What is in the tables of a map in tiles."""

from __future__ import annotations

import json
from typing import Final

import pyarrow as pa

LABELS: Final = pa.list_(pa.struct([("name", pa.string()), ("score", pa.float64())]))

_LENGTHS: Final = [
    pa.field(name, pa.float64(), metadata={"says": said})
    for name, said in (
        ("x", "of the centre of the box, metres, world frame"),
        ("y", ""),
        ("z", ""),
        ("size_x", "full extent along the box's own X, metres"),
        ("size_y", ""),
        ("size_z", ""),
        ("yaw", "radians, counter-clockwise, from the world's X axis to the box's; 0 where it is not given"),
    )
]

OBJECTS: Final = pa.schema(
    [
        pa.field("id", pa.string(), nullable=False, metadata={"says": "unique in the map"}),
        pa.field("label", pa.string(), metadata={"says": "what it is; may be missing"}),
        pa.field("labels", LABELS, metadata={"says": "ranked names with scores, instead of label"}),
        pa.field("kind", pa.string(), metadata={"says": "object or surface; object where it is not given"}),
        *_LENGTHS,
    ]
)
"""What goes in: a row for each thing and surface."""

_GEO: Final = {
    "version": "1.1.0",
    "primary_column": "geometry",
    "columns": {"geometry": {"encoding": "WKB", "geometry_types": ["Polygon"], "crs": None}},
}

THINGS: Final = pa.schema(
    [
        pa.field("id", pa.string(), nullable=False),
        pa.field("label", pa.string()),
        pa.field("kind", pa.string(), nullable=False),
        *_LENGTHS,
        pa.field("geometry", pa.binary(), metadata={"says": "the box in plan, a polygon in WKB"}),
    ],
    metadata={"geo": json.dumps(_GEO)},
)
"""What comes out of each thing, GeoParquet that other tools know as a map; it can go in again."""

RELATIONS: Final = pa.schema(
    [
        pa.field("source", pa.dictionary(pa.int32(), pa.string()), nullable=False),
        pa.field("scene", pa.dictionary(pa.int32(), pa.string()), nullable=False),
        pa.field("relation", pa.dictionary(pa.int32(), pa.string()), nullable=False),
        pa.field("figure", pa.string(), nullable=False),
        pa.field("reference", pa.string(), nullable=False),
        pa.field(
            "view",
            pa.dictionary(pa.int32(), pa.string()),
            metadata={"says": "null where the relation depends on no view"},
        ),
        pa.field("figure_label", pa.dictionary(pa.int32(), pa.string())),
        pa.field("reference_label", pa.dictionary(pa.int32(), pa.string())),
        pa.field("margin", pa.float64(), metadata={"says": "metres; null where no length decides"}),
        pa.field("uncertain", pa.bool_(), nullable=False, metadata={"says": "margin below the pose noise"}),
        pa.field("rule", pa.dictionary(pa.int32(), pa.string()), nullable=False),
    ]
)
"""What comes out: a row for each relation that holds. Readers see the dictionaries as text."""

BOXES: Final = pa.schema(
    [
        pa.field("id", pa.string()),
        pa.field("label", pa.string()),
        pa.field("labels", LABELS),
        *((name, pa.float64()) for name in ("x", "y", "z", "hx", "hy", "hz", "yaw")),
        ("normal", pa.int8()),
        ("ambiguous", pa.bool_()),
        *((name, pa.float64()) for name in ("low_x", "low_y", "high_x", "high_y", "reach")),
    ]
)
"""What is kept of each thing while a map is worked on: its box, and in plan what is around it."""
