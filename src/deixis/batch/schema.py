"""The tables of data sets as Arrow schemas: what goes in, what comes out, and what was refused.

``kb/datasets.md`` shows them; each field says what it holds.
"""

from __future__ import annotations

from typing import Final

import pyarrow as pa


def _field(name: str, kind: pa.DataType, says: str, *, null: bool = False) -> pa.Field:
    return pa.field(name, kind, nullable=null, metadata={"says": says})


_WORD: Final = pa.dictionary(pa.int32(), pa.string())
"""Text of which there are few different ones."""

SCENES: Final = pa.schema(
    [
        _field("source", pa.string(), "where the scene comes from, as errors and relations call it"),
        _field("scene", pa.large_binary(), "the scene, format v1; null: it is in the file", null=True),
        _field("file", pa.string(), "its file, beside which are point and mesh files it names", null=True),
    ]
)
"""What goes in: a row for each scene, or for each file of another format that a reader knows."""

RELATIONS: Final = pa.schema(
    [
        _field("source", pa.string(), "where the scene comes from: a file, with line or row"),
        _field("scene", pa.string(), "id of the scene"),
        _field("relation", _WORD, "what holds, as in `deixis relations`"),
        _field("figure", pa.string(), "id of the first thing"),
        _field("reference", pa.string(), "id of the second thing"),
        _field("view", pa.string(), "id of the view; null where it depends on none", null=True),
        _field("figure_label", pa.string(), "best label of the figure; null where it has none", null=True),
        _field("reference_label", pa.string(), "the same of the reference", null=True),
        _field(
            "margin",
            pa.float64(),
            "metres by which a length would have to change for it to cease; null where none decides",
            null=True,
        ),
        _field("uncertain", pa.bool_(), "whether the margin is less than the scene's pose noise"),
        _field("rule", _WORD, "rule file and line where the relation is stated"),
    ]
)
"""What comes out: a row for each relation that holds."""

ERRORS: Final = pa.schema(
    [
        _field("source", pa.string(), "where the scene comes from"),
        _field("kind", pa.string(), "name of the error: SceneError, QueryTimeout, ..."),
        _field("reason", pa.string(), "what is wrong, and with which thing"),
    ]
)
"""What comes out of scenes that are refused: a row for each."""
