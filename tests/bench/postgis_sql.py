"""The job as one set-based statement for PostGIS and SFCGAL, in the manner of the paper's program.

Things are solids (polyhedral surfaces), halfspaces are extruded solids, and what meets what is asked of
solids. The plan views of two boxes that overlap are parted by the least translation to the outline of their
Minkowski sum. Numbers go in by COPY and as parameters; nothing is spliced into the statement but the names
of the functions, which PostGIS 3.5 changed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from psycopg import Connection
from psycopg.sql import SQL, Composed, Identifier

from bench.job import Answers, frames, ordered, solid_things
from deixis.frames import WORLD
from deixis.scene import Scene
from deixis.thresholds import SNAP

FAR = 1.0e3
"""Metres: a halfspace without end reaches this far."""

TABLES = """
CREATE TEMPORARY TABLE thing (
    id int, x float8, y float8, z float8, hx float8, hy float8, hz float8, yaw float8, normal int,
    reach float8, volume float8);
CREATE TEMPORARY TABLE frame (view text, reference int, yaw float8, hx float8, hy float8, normal int);
CREATE TEMPORARY TABLE spoken (figure int, reference int);
"""

STATEMENT = """
WITH
-- A rectangle is turned about the origin, then shifted; a solid is a rectangle raised by its height.
solid AS MATERIALIZED (
    SELECT thing.*, normal >= 0 AS surface, z - hz AS bottom, z + hz AS top, own.plan, own.grown, shape,
           ST_Expand(shape, least(greatest(reach, %(closeness)s), %(far)s)) AS around
    FROM thing
    CROSS JOIN LATERAL (SELECT
        ST_Translate(ST_Rotate(ST_MakeEnvelope(-hx, -hy, hx, hy), yaw), x, y) AS plan,
        ST_Translate(ST_Rotate(ST_MakeEnvelope(-hx - %(d)s, -hy - %(d)s, hx + %(d)s, hy + %(d)s), yaw),
                     x, y) AS grown) AS own
    CROSS JOIN LATERAL (SELECT
        {solid}({extrude}(ST_Force3D(plan, z - hz), 0, 0, 2 * hz)) AS shape) AS raised),
-- The halfspaces of axioms 20 and 30-34, in the four directions of each frame, no wider than leaves D/2:
-- beyond the face by D; from D before the face; and all that lies farther back.
side AS MATERIALIZED (
    SELECT view, reference, number, cos(turn) AS east, sin(turn) AS north,
           {solid}({extrude}(ST_Translate(ST_Rotate(ST_Force3D(ST_MakeEnvelope(
               face + %(d)s, -width, face + depth, width)), turn), x, y, low), 0, 0, height)) AS beyond,
           {solid}({extrude}(ST_Translate(ST_Rotate(ST_Force3D(ST_MakeEnvelope(
               face - %(d)s, -width, face + depth, width)), turn), x, y, low), 0, 0, height)) AS flush,
           {solid}({extrude}(ST_Translate(ST_Rotate(ST_Force3D(ST_MakeEnvelope(
               -%(far)s, -width, face - %(d)s, width)), turn), x, y, low), 0, 0, height)) AS back
    FROM (
        SELECT view, reference, number, thing.x, thing.y, thing.z - thing.hz + %(d)s / 2 AS low,
               2 * thing.hz - %(d)s AS height,
               frame.yaw + axis * pi() / 2 + CASE WHEN number %% 2 = 1 THEN pi() ELSE 0 END AS turn,
               CASE axis WHEN 0 THEN frame.hx ELSE frame.hy END AS face,
               CASE axis WHEN 0 THEN frame.hy ELSE frame.hx END - %(d)s / 2 AS width,
               CASE WHEN frame.normal = axis THEN %(far)s
                    ELSE 2 * %(scale)s * CASE axis WHEN 0 THEN frame.hx ELSE frame.hy END END AS depth
        FROM frame JOIN thing ON thing.id = reference
        CROSS JOIN (VALUES (0, 0), (1, 0), (2, 1), (3, 1)) AS direction (number, axis)) AS placed),
near AS MATERIALIZED (
    SELECT a.id AS figure, b.id AS reference, spoken.figure IS NOT NULL AS ordered,
           ST_3DDistance(a.shape, b.shape) AS distance
    FROM solid AS a
    JOIN solid AS b ON a.id <> b.id AND a.shape &&& b.around
    LEFT JOIN spoken ON spoken.figure = a.id AND spoken.reference = b.id
    WHERE ST_3DDWithin(a.shape, b.shape,
                       CASE WHEN spoken.figure IS NULL THEN %(closeness)s
                            ELSE least(greatest(b.reach, %(closeness)s), %(far)s) END)),
-- Overlapping plan views: how far to the outline of their Minkowski sum; boxes are their own reflection.
parting AS MATERIALIZED (
    SELECT figure, reference, ordered, distance, coalesce(sideways, 0) AS sideways,
           CASE WHEN container AND NOT content THEN 'infinity' ELSE b.top - a.bottom END AS up,
           CASE WHEN content AND NOT container THEN 'infinity' ELSE a.top - b.bottom END AS down,
           within
    FROM near
    JOIN solid AS a ON a.id = figure
    JOIN solid AS b ON b.id = reference
    LEFT JOIN LATERAL (
        SELECT ST_Distance(ST_Boundary({minkowski}(ST_Translate(b.plan, -b.x, -b.y),
                                                   ST_Translate(a.plan, -a.x, -a.y))),
                           ST_MakePoint(a.x - b.x, a.y - b.y)) AS sideways
        WHERE ST_Intersects(a.plan, b.plan)) AS overlap ON true
    CROSS JOIN LATERAL (SELECT
        ST_Covers(b.grown, a.plan) AND greatest(a.top - b.top, b.bottom - a.bottom) <= %(d)s AS within,
        ST_Covers(a.grown, b.plan) AND greatest(b.top - a.top, a.bottom - b.bottom) <= %(d)s AS holds) AS held
    CROSS JOIN LATERAL (SELECT
        within AND NOT b.surface AND a.z > b.bottom + 1e-9 AND a.z < b.top - 1e-9 AS content,
        holds AND NOT a.surface AND b.z > a.bottom + 1e-9 AND b.z < a.top - 1e-9 AS container) AS holding),
pair AS MATERIALIZED (
    SELECT *, CASE WHEN distance > 0 THEN distance ELSE -least(sideways, up, down) END AS separation
    FROM parting),
-- The same for both orders of a pair, so asked once.
shared AS MATERIALIZED (
    SELECT figure, reference, {volume}({intersection}(a.shape, b.shape)) AS volume
    FROM pair JOIN solid AS a ON a.id = figure JOIN solid AS b ON b.id = reference
    WHERE figure < reference AND separation < %(asked)s),
met AS MATERIALIZED (
    SELECT figure, reference, array_agg(view || number) AS sides
    FROM pair
    JOIN solid AS a ON a.id = figure
    JOIN solid AS b ON b.id = reference
    JOIN side USING (reference)
    WHERE ordered
      AND ((a.shape &&& side.beyond AND ST_3DIntersects(a.shape, side.beyond))
           OR (separation >= -%(p)s
               AND (a.x - b.x) * east + (a.y - b.y) * north >= 0
               AND a.shape &&& side.flush AND ST_3DIntersects(a.shape, side.flush)
               AND NOT (a.shape &&& side.back AND ST_3DIntersects(a.shape, side.back))))
    GROUP BY figure, reference)
SELECT pair.figure, pair.reference, separation, coalesce(shared.volume, 0),
       separation BETWEEN -%(p)s AND %(d)s,
       separation < -%(p)s AND within,
       sideways >= %(d)s / 2 AND a.bottom <= b.top + deep_b AND CASE
           WHEN separation BETWEEN -%(p)s AND %(d)s AND up = 'infinity' THEN a.bottom >= b.top
           WHEN separation BETWEEN -%(p)s AND %(d)s THEN up - %(snap)s <= least(sideways, %(p)s, down)
           ELSE a.top >= b.top + %(d)s OR (separation >= -%(p)s AND a.bottom >= b.top - %(d)s) END,
       sideways >= %(d)s / 2 AND a.top >= b.bottom - deep_b AND CASE
           WHEN separation BETWEEN -%(p)s AND %(d)s AND down = 'infinity' THEN a.top <= b.bottom
           WHEN separation BETWEEN -%(p)s AND %(d)s THEN down - %(snap)s <= least(sideways, %(p)s, up)
           ELSE a.bottom <= b.bottom - %(d)s OR (separation >= -%(p)s AND a.top <= b.bottom + %(d)s) END,
       sides
FROM pair
JOIN solid AS a ON a.id = pair.figure
JOIN solid AS b ON b.id = pair.reference
CROSS JOIN LATERAL (SELECT
    CASE b.normal WHEN 2 THEN %(far)s ELSE 2 * %(scale)s * b.hz END AS deep_b) AS depth
LEFT JOIN shared ON shared.figure = least(pair.figure, pair.reference)
                AND shared.reference = greatest(pair.figure, pair.reference)
LEFT JOIN met ON met.figure = pair.figure AND met.reference = pair.reference
ORDER BY pair.figure, pair.reference
"""


def names(connection: Connection[Any]) -> dict[str, Identifier]:
    """Return what the functions of SFCGAL are called here: CG_ from PostGIS 3.5 on, ST_ before."""
    wanted = {
        "solid": "makesolid",
        "extrude": "extrude",
        "minkowski": "minkowskisum",
        "volume": "volume",
        "intersection": "3dintersection",
    }
    known = {row[0] for row in connection.execute("SELECT proname FROM pg_proc").fetchall()}
    prefix = {key: "cg_" if f"cg_{name}" in known else "st_" for key, name in wanted.items()}
    return {key: Identifier(prefix[key] + name) for key, name in wanted.items()}


def load(connection: Connection[Any], scene: Scene) -> None:
    """Bring a scene into fresh tables of this session."""
    listed = solid_things(scene)
    connection.execute("DROP TABLE IF EXISTS thing, frame, spoken")
    connection.execute(TABLES)
    rows = {
        "thing": [(index, *thing, thing.volume) for index, thing in enumerate(listed)],
        "frame": [(view, index, *frame) for view, index, frame in frames(scene)],
        "spoken": [
            (i, j) for i, a in enumerate(listed) for j, b in enumerate(listed) if i != j and ordered(a, b)
        ],
    }
    with connection.cursor() as cursor:
        for table, content in rows.items():
            with cursor.copy(SQL("COPY {} FROM STDIN").format(Identifier(table))) as copy:
                for row in content:
                    copy.write_row(row)
        cursor.execute("ANALYZE thing, frame, spoken")


def statement(connection: Connection[Any]) -> Composed:
    """Return the statement, with the names of the functions in it."""
    return SQL(STATEMENT).format(**names(connection))


def answers(connection: Connection[Any], scene: Scene, every_volume: bool = False) -> Answers:
    """Return the answers to the job for a scene that is loaded.

    Volumes are asked of solids that overlap, or of every pair within reach, as the paper's program does.
    """
    limits = scene.thresholds
    numbers = {
        "d": limits.granularity,
        "p": limits.penetration,
        "closeness": limits.closeness,
        "scale": limits.halfspace_scale,
        "snap": SNAP,
        "asked": math.inf if every_volume else -SNAP,
        "far": FAR,
    }
    rows = connection.execute(statement(connection), numbers).fetchall()
    views = (WORLD, *(view.id for view in scene.views))
    figure, reference, separation, volume, touches, contained, above, below, met = zip(*rows, strict=True)
    sides = {
        view: np.array([[f"{view}{n}" in (held or ()) for n in range(4)] for held in met]) for view in views
    }
    return Answers(
        np.column_stack([figure, reference]),
        np.array(separation),
        np.array(volume, dtype=np.float64),
        np.array(touches),
        np.array(contained),
        np.column_stack([above, below]),
        sides,
    )
