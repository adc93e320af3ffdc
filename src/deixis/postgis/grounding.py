"""Facts measured by PostGIS: Table 1(a) of the paper, row by row, as SQL (decision 0048)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from deixis.addresses import REMEDY, well_formed
from deixis.errors import GeometryError, MissingDependency
from deixis.facts import Facts, PairColumns, ViewFacts, withheld_reason
from deixis.frames import WORLD, Array, Index
from deixis.polyhedra import hulls
from deixis.scene import Scene
from deixis.thresholds import SNAP_DECIMALS

try:
    import psycopg
    from psycopg.sql import SQL
except ImportError as cause:
    raise MissingDependency("--grounding postgis needs psycopg: pip install 'deixis[postgis]'") from cause

from deixis.postgis.functions import names, search_path

ROWS: Final = (
    "minimum_box",
    "contextualised_box",
    "top_and_bottom",
    "sides",
    "reference_order",
    "near",
    "overlap",
    "intersection",
    "containment",
    "above_and_below",
    "beside",
    "frontier",
)
"""The rows of Table 1(a), in its order; the one on directions in two parts."""

_TABLES: Final = "tables"

_PAIRS: Final = """
SELECT figure, reference, separation, normal[1], normal[2], normal[3], coalesce(intersection, 0), protrusion,
       coalesce(frontier.frontier, 0), up.relaxed, down.relaxed, up.strict, down.strict, ordered
FROM overlap
JOIN containment USING (figure, reference)
LEFT JOIN frontier USING (figure, reference)
JOIN vertical AS up USING (figure, reference)
JOIN vertical AS down USING (figure, reference)
WHERE up.direction = 0 AND down.direction = 1
ORDER BY figure, reference
"""

_ASPECTS: Final = """
SELECT figure, reference, array_agg(relaxed ORDER BY direction), array_agg(strict ORDER BY direction)
FROM aspect WHERE view = %(view)s GROUP BY figure, reference ORDER BY figure, reference
"""

_SILENT: Final = "SELECT thing FROM contextualised_box WHERE view = %(view)s AND NOT spoken_of ORDER BY thing"

_TIES: Final = "SELECT thing FROM contextualised_box WHERE view = %(view)s AND ambiguous ORDER BY thing"

_VOLUMES: Final = "SELECT thing, volume FROM size ORDER BY thing"


def ground(where: str | psycopg.Connection[Any], scene: Scene) -> Facts:
    """Return the facts of a scene, measured as boxes by PostGIS and SFCGAL instead of by the kernel.

    Truth values are the operators' of Table 1(a); how far each is from changing is measured on the same
    geometry (decision 0048). The tables are temporary: nothing of the scene stays in the database.

    Parameters
    ----------
    where : str or Connection
        ``postgresql://...``, or a session, in which one transaction is made.
    scene : Scene

    Raises
    ------
    GeometryError
        The server cannot be reached, or refuses what it was asked to measure.
    MissingDependency
        PostGIS or SFCGAL is not in the database.
    """
    with session(where) as connection:
        load(connection, scene)
        for row in ROWS:
            run(connection, row)
        return facts(connection, scene)


@contextmanager
def session(where: str | psycopg.Connection[Any]) -> Iterator[psycopg.Connection[Any]]:
    """Open one transaction in which Table 1(a) can be worked through, and leave nothing of it behind."""
    try:
        if isinstance(where, str):
            if not well_formed(where):
                raise GeometryError(f"the address of the database is not well formed: {REMEDY}")
            with psycopg.connect(where, autocommit=True) as connection, session(connection):
                yield connection
            return
        with where.transaction(force_rollback=True):
            where.execute(search_path(where))
            yield where
    except psycopg.Error as error:
        raise GeometryError(f"PostGIS cannot ground the scene: {error}") from error


def load(connection: psycopg.Connection[Any], scene: Scene) -> None:
    """Make the tables of a session and bring a scene into them."""
    run(connection, _TABLES)
    limits, boxes = scene.thresholds, scene.boxes
    # Near the origin float64 is finest.
    origin = np.round(boxes.center.mean(axis=0), 3) if len(boxes) else np.zeros(3)
    places = [view.position - origin for view in scene.views]
    spread = np.abs(boxes.center - origin).sum(axis=1) + boxes.half.sum(axis=1)
    far = 10.0 + 4.0 * limits.halfspace_scale * float(spread.max(initial=0.0)) + limits.closeness
    connection.execute(
        "INSERT INTO threshold VALUES (%(d)s, %(p)s, %(t)s, %(s)s, %(far)s)",
        {
            "d": limits.granularity,
            "p": limits.penetration,
            "t": limits.closeness,
            "s": limits.halfspace_scale,
            "far": far,
        },
    )
    kinds = ["thing" if at < 0 else "level" if at == 2 else "upright" for at in boxes.normal.tolist()]
    with connection.cursor() as cursor:
        with cursor.copy("COPY hull FROM STDIN") as copy:
            for at, (kind, region) in enumerate(zip(kinds, hulls(scene, origin), strict=True)):
                copy.write_row((at, kind, region))
        cursor.execute("INSERT INTO viewpoint VALUES (0, NULL)")
        cursor.executemany(
            "INSERT INTO viewpoint VALUES (%s, ST_MakePoint(%s, %s))",
            [(at, *place[:2].tolist()) for at, place in enumerate(places, 1)],
        )
        cursor.execute("ANALYZE hull, viewpoint")


def run(connection: psycopg.Connection[Any], row: str) -> None:
    """Work through one row of Table 1(a), after those before it."""
    connection.execute(SQL(text(row)).format(**names(connection)))


@cache
def text(row: str) -> str:
    """Return the SQL of a row of Table 1(a), with the functions that PostGIS 3.5 renamed in braces."""
    return (Path(__file__).resolve().parent / "sql" / f"{row}.sql").read_text(encoding="utf-8")


def facts(connection: psycopg.Connection[Any], scene: Scene) -> Facts:
    """Return what the tables of a session hold, after all rows of Table 1(a)."""
    columns = _columns(connection.execute(_PAIRS).fetchall(), 14)
    figure, reference = columns[0].astype(np.int64), columns[1].astype(np.int64)
    normal = columns[3:6].T
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    pairs = PairColumns(
        figure,
        reference,
        _snapped(columns[2]),
        (normal / np.where(length > 0.0, length, 1.0)).astype(np.float32),
        np.round(columns[6], 12),
        _snapped(columns[7]),
        np.round(columns[8], 12),
        _snapped(columns[9:11].T),
        _snapped(columns[11:13].T),
        columns[13].astype(np.bool_),
    )
    views = [WORLD, *(view.id for view in scene.views)]
    return Facts(
        scene=scene.id,
        ids=tuple(thing.id for thing in scene.objects),
        labels=tuple(tuple((label.name, label.score) for label in thing.labels) for thing in scene.objects),
        surface=scene.boxes.surface,
        volume=_columns(connection.execute(_VOLUMES).fetchall(), 2)[1],
        thresholds=scene.thresholds,
        pairs=pairs,
        views=tuple(_view(connection, scene, pairs, at, name) for at, name in enumerate(views)),
        region="box",
        models=tuple("box" for _ in scene.objects),
    )


def _view(
    connection: psycopg.Connection[Any], scene: Scene, pairs: PairColumns, at: int, name: str
) -> ViewFacts:
    told = connection.execute(_ASPECTS, {"view": at}).fetchall()
    silent = [thing for (thing,) in connection.execute(_SILENT, {"view": at}).fetchall()]
    ties = [thing for (thing,) in connection.execute(_TIES, {"view": at}).fetchall()]
    upright = np.isin(scene.boxes.normal, (0, 1))
    rows: Index = np.flatnonzero(pairs.ordered & ~np.isin(pairs.reference, silent))
    relaxed, strict = (np.array([row[column] for row in told]).reshape(-1, 4) for column in (2, 3))
    return ViewFacts(
        name,
        rows,
        _snapped(relaxed),
        _snapped(strict),
        tuple((thing, withheld_reason(bool(upright[thing]))) for thing in silent),
        tuple(ties),
    )


def _columns(rows: list[tuple[Any, ...]], count: int) -> Array:
    return np.array(rows, dtype=np.float64).reshape(-1, count).T


def _snapped(values: Array) -> Array:
    """Round to a nanometre, without negative zeros, as the kernel does."""
    return np.round(values, SNAP_DECIMALS) + 0.0
