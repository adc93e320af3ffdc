"""The things of a map on disk, sorted by tile, so that those of one and around it are soon found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from deixis.boxes import Boxes
from deixis.errors import GeometryError, ReaderError, SceneError
from deixis.frames import Array, Mask
from deixis.scene import Scene
from deixis.strict_json import quoted
from deixis.tiles.database import database
from deixis.tiles.schema import BOXES
from deixis.tiles.sources import batches

Tile = tuple[int, int]
"""East and north, counted from the world's origin in sizes of a tile."""

TARGET: Final = 20_000
"""Things in the fullest tile, where no size is given."""

MOST: Final = 1_000_000
"""Things in a tile and around it: some 10 GiB of facts where each has a dozen neighbours."""

_GROUP: Final = 8_192
"""Rows of a file that are found or left out together."""

_SURFACES: Final = 20_000
"""Surfaces of a map. Every tile measures all of them against each other."""

FILES: Final = ("things", "wide", "surfaces")
"""Things smaller than a tile, larger ones, and surfaces, which are near everything."""


_SORTED_BOXES: Final = pa.schema([*BOXES, ("tx", pa.int64()), ("ty", pa.int64())])


@dataclass(frozen=True)
class Loaded:
    """Things of a tile and around it, surfaces among them.

    Attributes
    ----------
    table : pa.Table
        With the schema :data:`~deixis.tiles.schema.BOXES`, and more columns.
    own : (n,) bool
        Which are the tile's own.
    """

    table: pa.Table
    own: Mask

    def boxes(self) -> Boxes:
        """Return their boxes."""

        def numbers(*names: str) -> Array:
            return np.stack([self.table.column(name).to_numpy() for name in names], axis=1)

        return Boxes(
            numbers("x", "y", "z"),
            numbers("hx", "hy", "hz"),
            np.ascontiguousarray(self.table.column("yaw").to_numpy()),
            self.table.column("normal").to_numpy().astype(np.int64),
            np.asarray(self.table.column("ambiguous").to_numpy(), dtype=np.bool_),
        )


def collect(places: Sequence[Path], head: Scene, folder: Path) -> int:
    """Write the things of some files as one table of boxes into a folder; return how many there are."""
    told = folder / "told.parquet"
    count = 0
    with pq.ParquetWriter(told, BOXES, compression="zstd") as writer:
        for batch in batches(places, head):
            count += len(batch)
            writer.write_batch(batch)
    return count


def cut(folder: Path, size: float | None, memory: int) -> tuple[float, list[Tile]]:
    """Sort the collected things by tile; return the size of a tile, metres, and the tiles that own any.

    Parameters
    ----------
    folder : Path
        Of :func:`collect`.
    size : float or None
        Metres; by default such that no tile has more than some 20,000 things.
    memory : int
        Bytes that sorting may take.

    Raises
    ------
    SceneError
        An id is given twice, or there are more surfaces than a map may have.
    """
    with database(folder, memory, "the map cannot be sorted into tiles") as base:
        base.read_parquet(str(folder / "told.parquet")).create_view("told")
        twice = base.execute(_TWICE).fetchall()
        if twice:
            raise SceneError(f"object {quoted(twice[0][0])} is given more than once: rename all but one")
        _few_surfaces(base)
        metres = _size(base) if size is None else size
        places = [str(folder / f"{name}.parquet") for name in FILES]
        for place, condition in zip(places, _CONDITIONS, strict=True):
            sql = (_SORTED + condition + " ORDER BY ty, tx, id").replace("$size", f"{metres!r}::DOUBLE")
            base.sql(sql).write_parquet(place, compression="zstd", row_group_size=_GROUP)
        base.read_parquet(places).create_view("sorted")
        found = base.execute("SELECT DISTINCT tx, ty FROM sorted ORDER BY ty, tx").fetchall()
    # A map of nothing has a tile with nothing in it.
    return metres, [(int(tx), int(ty)) for tx, ty in found] or [(0, 0)]


_TWICE: Final = "SELECT id FROM told GROUP BY id HAVING count(*) > 1 ORDER BY id LIMIT 1"

_SORTED: Final = "SELECT *, floor(x / $size)::BIGINT AS tx, floor(y / $size)::BIGINT AS ty FROM told WHERE "

_WIDE: Final = "greatest(high_x - low_x, high_y - low_y) + 2 * reach > 2 * $size"
"""What it and its reach take up is more than the tiles beside its own."""

_CONDITIONS: Final = (f"normal < 0 AND NOT {_WIDE}", f"normal < 0 AND {_WIDE}", "normal >= 0")


def _few_surfaces(base: Any) -> None:
    count = base.execute("SELECT count(*) FROM told WHERE normal >= 0").fetchall()[0][0]
    if count > _SURFACES:
        raise SceneError(
            f"{count:,} surfaces: everything is measured against each of them, so a map may have "
            f"{_SURFACES:,}; give small ones as objects, or cut the map by hand"
        )


def _size(base: Any) -> float:
    """Return the side of a tile, metres: the largest with which no tile has more things than wanted."""
    widest, usual = base.execute(_SPREAD).fetchall()[0]
    if widest is None:
        return 1.0
    # With tiles smaller than what is around a thing every tile is mostly the others'.
    size = 4.0 * float(usual)
    base.execute(_CELLS.replace("$size", f"{size!r}::DOUBLE"))
    scale = 1.0
    while size * scale < widest:
        wider = base.execute(_FULLEST.replace("$scale", f"{2.0 * scale!r}::DOUBLE")).fetchall()[0][0]
        if wider > TARGET:
            break
        scale *= 2.0
    return size * scale


_SPREAD: Final = (
    "SELECT greatest(max(x) - min(x), max(y) - min(y)), quantile_cont(high_x - low_x + reach, 0.99) "
    "FROM told WHERE normal < 0"
)

_CELLS: Final = (
    "CREATE TEMP TABLE cell AS SELECT floor(x / $size) AS cx, floor(y / $size) AS cy, count(*) AS n "
    "FROM told WHERE normal < 0 GROUP BY ALL"
)

_FULLEST: Final = (
    "SELECT max(n) FROM (SELECT sum(n) AS n FROM cell GROUP BY floor(cx / $scale), floor(cy / $scale))"
)


class Store:
    """What :func:`cut` has written, for reading tile by tile.

    Parameters
    ----------
    folder : Path
    size : float
        Metres.
    """

    def __init__(self, folder: Path, size: float) -> None:
        self._size = size
        self._files = {
            name: ds.dataset(folder / f"{name}.parquet", schema=_SORTED_BOXES, format="parquet")
            for name in FILES
        }
        self._surfaces: pa.Table | None = None

    def load(self, tile: Tile, links: int) -> Loaded:
        """Return the things of a tile, all surfaces, and all that is so many links from its own.

        Raises
        ------
        GeometryError
            That is too much for the memory.
        """
        if self._surfaces is None:
            self._surfaces = self._files["surfaces"].to_table()
        here = (pc.field("tx") == tile[0]) & (pc.field("ty") == tile[1])
        level = [self._files[name].to_table(filter=here) for name in ("things", "wide")]
        found = pa.concat_tables(level)
        own = [len(found)]
        seen = found.column("id").combine_chunks()
        for _ in range(links):
            around = [self._around(name, *level) for name in ("things", "wide")]
            level = [part.filter(pc.invert(pc.is_in(part.column("id"), seen))) for part in around]
            found = pa.concat_tables([found, *level])
            if len(found) > MOST:
                raise GeometryError(
                    f"tile {name_of(tile)}: {len(found):,} things in it and around it: choose smaller tiles"
                )
            seen = found.column("id").combine_chunks()
        surfaces = self._surfaces
        local = np.asarray(
            pc.and_(pc.equal(surfaces.column("tx"), tile[0]), pc.equal(surfaces.column("ty"), tile[1])),
            dtype=np.bool_,
        )
        mine = np.zeros(len(found), dtype=np.bool_)
        mine[: own[0]] = True
        return Loaded(pa.concat_tables([found, surfaces]), np.concatenate([mine, local]))

    def _around(self, name: str, things: pa.Table, wide: pa.Table) -> pa.Table:
        """Return what may be linked with some things; more than that does no harm."""
        rectangles = _rectangles(things, wide)
        if not len(rectangles):
            return self._files[name].schema.empty_table()
        # As far as any of them and what is around it goes.
        hull = np.concatenate([rectangles[:, :2].min(axis=0), rectangles[:, 2:4].max(axis=0)])
        reach = float(rectangles[:, 4].max())
        low_x, low_y, high_x, high_y = (float(one) for one in hull)
        own = pc.field("reach")

        def apart(one: Any, other: Any) -> Any:
            return ((one - other) <= reach) | ((one - other) <= own)

        near = (
            apart(pc.field("low_x"), pc.scalar(high_x)) & apart(pc.scalar(low_x), pc.field("high_x"))
            & apart(pc.field("low_y"), pc.scalar(high_y)) & apart(pc.scalar(low_y), pc.field("high_y"))
        )  # fmt: skip
        if name == "things":
            # None of these goes further than to the tile beside its own.
            ends = [low_x - reach, high_x + reach, low_y - reach, high_y + reach]
            west, east, south, north = (int(np.floor(one / self._size)) for one in ends)
            near = near & (pc.field("tx") >= west - 1) & (pc.field("tx") <= east + 1)
            near = near & (pc.field("ty") >= south - 1) & (pc.field("ty") <= north + 1)
        found = self._files[name].to_batches(filter=near)
        parts = [batch.filter(pa.array(_meets(batch, rectangles))) for batch in found if len(batch)]
        return pa.Table.from_batches(parts, schema=self._files[name].schema)


def _rectangles(things: pa.Table, wide: pa.Table) -> Array:
    """Return rectangles in plan that hold some things, with their reach: one for all small, one a wide."""
    names = ("low_x", "low_y", "high_x", "high_y", "reach")
    small, large = (
        np.stack([part.column(name).to_numpy() for name in names], axis=1) for part in (things, wide)
    )
    if not len(small):
        return large
    hull = [*small[:, :2].min(axis=0), *small[:, 2:4].max(axis=0), small[:, 4].max()]
    return np.concatenate([[hull], large])


def _meets(batch: pa.RecordBatch, rectangles: Array) -> Mask:
    """Return which rows are within reach of a rectangle, theirs or its own."""
    low_x, low_y, high_x, high_y, own = (
        batch.column(name).to_numpy() for name in ("low_x", "low_y", "high_x", "high_y", "reach")
    )
    found = np.zeros(len(batch), dtype=np.bool_)
    for left, bottom, right, top, reach in rectangles.tolist():
        far = np.maximum(own, reach)
        found |= (
            (low_x - right <= far) & (left - high_x <= far) & (low_y - top <= far) & (bottom - high_y <= far)
        )
    return found


def name_of(tile: Tile) -> str:
    """Return the name of a tile.

    >>> name_of((-3, 12))
    '-3_12'
    """
    return f"{tile[0]}_{tile[1]}"


def check_size(size: float | None) -> None:
    """Raise ReaderError unless this can be the side of a tile."""
    if size is not None and not (np.isfinite(size) and 0.01 <= size <= 1.0e7):
        raise ReaderError(f"a tile of {size:g} m: give its side in metres, from 0.01 to 10,000,000")
