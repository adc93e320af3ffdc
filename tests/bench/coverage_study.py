"""Table 1(a) of the paper, operator by operator, beside our own kernel: what was compared, what came out."""

from __future__ import annotations

import time
from collections import Counter
from typing import Any

import numpy as np
import psycopg
from psycopg.sql import SQL, Composed, Identifier

from bench.job import room
from deixis.boxes import align_with_world, contextualise
from deixis.facts import Facts
from deixis.frames import Array, Mask
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.postgis import grounding as postgis
from deixis.scene import BoxRegion, Label, PointRegion, Scene, SpatialObject
from deixis.thresholds import SNAP

NESTED = 5
"""Boxes in each room that lie within others, or stick out of them."""

SPOKEN = ("beside", "on_top_of", "leans_on", "affixed_on", "inside", "part_in", "near")
"""The relations of Table 1(b)."""

MADE = {
    "reference_order": "size",
    "intersection": "inter",
    "above_and_below": "vertical",
    "beside": "aspect",
}
"""The tables that files make where their names differ: a file's time is told by the row of its table."""

_PAIRS = """
SELECT a.thing, b.thing, ordered, ST_3DDWithin(a.solid, b.solid, t), ST_3DDWithin(a.solid, b.solid, 0),
       ST_3DIntersects(a.solid, b.solid)
FROM threshold, minimum_box AS a JOIN minimum_box AS b ON a.thing <> b.thing
JOIN reference_order ON figure = a.thing AND reference = b.thing
"""

_UPRIGHT = """
SELECT thing, direction, ST_ZMin(beyond) - z, ST_ZMax(beyond) - z
FROM top_and_bottom JOIN minimum_box USING (thing) WHERE kind <> 'level' ORDER BY thing, direction
"""

_SIDES = """
SELECT thing, direction, ST_XMin(here) - x, ST_XMax(here) - x, ST_YMax(here) - y
FROM sides CROSS JOIN LATERAL (SELECT ST_Rotate(beyond, -turn, x, y) AS here OFFSET 0) AS placed
WHERE view = %(view)s AND depth < (SELECT far FROM threshold) ORDER BY thing, direction
"""

_FRAMES = """
SELECT thing, cos(yaw), sin(yaw), fx, fy FROM contextualised_box
WHERE view = %(view)s AND spoken_of ORDER BY thing
"""


def random_room(things: int, seed: int) -> Scene:
    """Return a room of boxes, some of them within others, or all but."""
    rng = np.random.default_rng(seed)
    one = room(things, seed)
    objects = list(one.objects)
    for at in range(NESTED):
        host = objects[3 + at].region
        assert isinstance(host, BoxRegion)
        size = host.size * rng.uniform(0.3, 0.9, 3)
        turned = float(rng.choice([0.0, 0.0, 0.3]))
        offset = rng.uniform(-0.5, 0.5, 3) * (host.size - size) * (0.2 if turned else 0.9)
        offset[2] += float(rng.choice([0.0, 0.0, 0.01, 0.3]))
        cos, sin = np.cos(host.yaw), np.sin(host.yaw)
        moved = [cos * offset[0] - sin * offset[1], sin * offset[0] + cos * offset[1], offset[2]]
        region = BoxRegion(host.center + moved, size, host.yaw + turned)
        objects[-1 - at] = SpatialObject(f"n{at}", (Label("thing"),), "object", region)
    return Scene(f"room-{seed}", tuple(objects), one.views, one.thresholds)


def random_clouds(count: int) -> Scene:
    """Return small point clouds, all in one place."""
    rng = np.random.default_rng(7)
    clouds = [rng.uniform(-0.5, 0.5, (int(rng.integers(4, 16)), 3)) for _ in range(count)]
    things = [SpatialObject(f"c{at}", (), "object", PointRegion(cloud)) for at, cloud in enumerate(clouds)]
    return Scene("clouds", tuple(things))


class Study:
    """What was compared and how it came out, summed over scenes.

    Attributes
    ----------
    compared, agreed : Counter
        By the line of Table 1(a).
    causes : dict of Counter
        Why what differs does, by the line.
    seconds, made : Counter
        How long each file took, and how many rows it made.
    numbers, other : Counter
        By the column of the facts: how many numbers, and how many not the same to a nanometre.
    relations, differing : Counter
        By the relation of Table 1(b): how many hold by our kernel, and how many by one of the two only.
    """

    def __init__(self, connection: psycopg.Connection[Any]) -> None:
        self.connection = connection
        self.compared: Counter[str] = Counter()
        self.agreed: Counter[str] = Counter()
        self.causes: dict[str, Counter[str]] = {}
        self.seconds: Counter[str] = Counter()
        self.made: Counter[str] = Counter()
        self.numbers: Counter[str] = Counter()
        self.other: Counter[str] = Counter()
        self.relations: Counter[str] = Counter()
        self.differing: Counter[str] = Counter()

    def look(self, scene: Scene) -> None:
        """Ground a scene both ways and compare."""
        mine = ground(scene)
        with postgis.session(self.connection) as session:
            postgis.load(session, scene)
            for row in postgis.ROWS:
                start = time.perf_counter()
                postgis.run(session, row)
                self.seconds[row] += time.perf_counter() - start
                made = SQL("SELECT count(*) FROM {}").format(Identifier(MADE.get(row, row)))
                self.made[row] += int(_ask(session, made)[0, 0])
            theirs = postgis.facts(session, scene)
            self._boxes(session, scene)
            self._halfspaces(session, scene)
            self._metric(session, mine)
            self._topology(session, mine)
            self._direction(session, mine)
        self._facts(mine, theirs)
        by_mine, by_theirs = _spoken(scene, mine), _spoken(scene, theirs)
        self.relations.update(one[0] for one in by_mine)
        self.differing.update(one[0] for one in by_mine ^ by_theirs)

    def look_at_clouds(self, scene: Scene) -> None:
        """Compare the minimum boxes of point clouds."""
        with postgis.session(self.connection) as session:
            postgis.load(session, scene)
            postgis.run(session, "minimum_box")
            told = _ask(session, "SELECT hx, hy FROM minimum_box ORDER BY thing")
        same = np.abs(told - np.sort(scene.boxes.half[:, :2])[:, ::-1]).max(axis=1) <= SNAP
        wider = told.prod(axis=1) > scene.boxes.half[:, :2].prod(axis=1)
        several, least = (
            "two rectangles are equally small",
            "the rectangle of least width is not that of least area",
        )
        self._count("cloud", same, {several: scene.boxes.ambiguous, least: wider})

    def _count(self, key: str, same: Mask, causes: dict[str, Mask] | None = None) -> None:
        """Count what is the same, and what is not by the first cause that fits."""
        self.compared[key] += same.size
        self.agreed[key] += int(same.sum())
        counted, left = self.causes.setdefault(key, Counter()), ~same
        for cause, fits in (causes or {}).items():
            counted[cause] += int((left & fits).sum())
            left = left & ~fits
        counted["no known cause"] += int(left.sum())

    def _boxes(self, session: psycopg.Connection[Any], scene: Scene) -> None:
        boxes, limits = scene.boxes, scene.thresholds
        told = _ask(session, "SELECT hx, hy, hz, cos(4 * yaw), sin(4 * yaw) FROM minimum_box ORDER BY thing")
        mine = np.column_stack(
            [
                np.sort(boxes.half[:, :2])[:, ::-1],
                boxes.half[:, 2],
                np.cos(4.0 * boxes.yaw),
                np.sin(4.0 * boxes.yaw),
            ]
        )
        self._count("box", np.abs(told - mine).max(axis=1) <= SNAP)
        told = _ask(session, "SELECT volume FROM size ORDER BY thing")[:, 0]
        mine = boxes.volume(limits.granularity)
        self._count("volume", np.abs(told - mine) <= SNAP * mine)
        for view, framed in enumerate(_framed(scene)):
            told = _ask(session, _FRAMES, view=view)
            at = told[:, 0].astype(int)
            mine = np.column_stack([np.cos(framed.yaw), np.sin(framed.yaw), framed.half[:, :2]])[at]
            self._count("frame", np.abs(told[:, 1:] - mine).max(axis=1) <= SNAP)

    def _halfspaces(self, session: psycopg.Connection[Any], scene: Scene) -> None:
        limits = scene.thresholds
        d, swept = limits.granularity, 2.0 * limits.halfspace_scale
        half = scene.boxes.half[:, 2]
        begins, ends = half + d, half + swept * np.maximum(half, 0.5 * d)
        told = _ask(session, _UPRIGHT)
        at = told[:, 0].astype(int)
        low, high = np.where(told[:, 1] == 0, told[:, 2:].T, -told[:, :1:-1].T)
        self._count("upright", np.maximum(np.abs(low - begins[at]), np.abs(high - ends[at])) <= SNAP)
        for view, framed in enumerate(_framed(scene)):
            told = _ask(session, _SIDES, view=view)
            at, axis = told[:, 0].astype(int), told[:, 1].astype(int) // 2
            face, thick = framed.half[at, axis], np.maximum(framed.half[:, :2], 0.5 * d)
            mine = [face + d, face + swept * thick[at, axis], thick[at, 1 - axis] - 0.5 * d]
            self._count("side", np.abs(told[:, 2:] - np.column_stack(mine)).max(axis=1) <= SNAP)

    def _metric(self, session: psycopg.Connection[Any], mine: Facts) -> None:
        """Compare what is asked of all pairs: the order, closeness, contact, overlap."""
        told = _ask(session, _PAIRS)
        place = told[:, 0].astype(int), told[:, 1].astype(int)
        ordered, close, contact, meets = (told[:, 2:] > 0.0).T
        limits, size = mine.thresholds, (len(mine.ids), len(mine.ids))
        apart = np.full(size, np.inf)
        apart[mine.figure, mine.reference] = mine.separation
        apart = apart[place]
        volume = mine.volume
        mine_ordered = ~mine.surface[place[0]] & (
            mine.surface[place[1]] | (volume[place[1]] >= volume[place[0]] * (1.0 - 1.0e-6))
        )
        band = (apart >= -limits.penetration) & (apart <= limits.granularity)
        self._count("order", ordered == mine_ordered)
        self._count("close", close == (apart <= limits.closeness))
        gap, deep = (apart > 0.0) & band, apart < -limits.penetration
        self._count(
            "touch",
            contact == band,
            {"a gap up to D is contact to us": gap, "an overlap of more than P is no contact to us": deep},
        )
        self._count("meet", meets == deep, {"an overlap up to P is contact to us": band & (apart <= 0.0)})

    def _topology(self, session: psycopg.Connection[Any], mine: Facts) -> None:
        row = {
            pair: at
            for at, pair in enumerate(zip(mine.figure.tolist(), mine.reference.tolist(), strict=True))
        }
        told = _ask(session, "SELECT one, other, volume, refused FROM inter")
        at = np.array([row[int(one), int(other)] for one, other in told[:, :2]], dtype=int)
        close = np.abs(told[:, 2] - mine.intersection[at]) <= SNAP * mine.intersection[at] + 1.0e-12
        self._count(
            "inter", close & (told[:, 3] == 0), {"SFCGAL refuses what it has made itself": told[:, 3] > 0}
        )
        told = _ask(
            session, "SELECT figure, reference, contained FROM containment WHERE contained IS NOT NULL"
        )
        at = np.array([row[int(one), int(other)] for one, other in told[:, :2]], dtype=int)
        held, sticks = told[:, 2] > 0, mine.protrusion[at]
        self._count(
            "held",
            held == mine.compl_cont[at],
            {
                "sticking out by up to D is within to us": ~held & (sticks > 0.0),
                "what is within by up to P only is in contact to us": held & ~mine.intersects[at],
            },
        )
        told = _ask(
            session,
            "SELECT a.figure, a.reference, a.frontier < b.frontier FROM frontier AS a JOIN frontier AS b "
            "ON b.figure = a.reference AND b.reference = a.figure",
        )
        at = np.array([row[int(one), int(other)] for one, other in told[:, :2]], dtype=int)
        back = np.array([row[int(other), int(one)] for one, other in told[:, :2]], dtype=int)
        less = mine.frontier[at] < mine.frontier[back]
        every = np.ones(len(at), dtype=bool)
        deep = mine.intersects[at]
        same = (told[:, 2] > 0) == less
        cause = {"scaled by its extents, inter is not D larger on each side": every[deep]}
        self._count("part", same[deep], cause)

    def _direction(self, session: psycopg.Connection[Any], mine: Facts) -> None:
        told = _ask(session, "SELECT meets FROM vertical ORDER BY figure, reference, direction")
        contact = np.repeat(mine.touches, 2)
        cause = {"in contact, the shortest way out decides to us": contact}
        self._count("vertical", (told[:, 0] > 0) == (mine.vertical.ravel() >= 0.0), cause)
        for at, view in enumerate(mine.views):
            told = _ask(
                session,
                "SELECT meets FROM aspect WHERE view = %(view)s ORDER BY figure, reference, direction",
                view=at,
            )
            near = np.abs(view.int_hs.ravel()) <= SNAP
            cause = {"within a nanometre of a bound rounding decides": near}
            self._count("horizontal", (told[:, 0] > 0) == (view.int_hs.ravel() >= 0.0), cause)

    def _facts(self, mine: Facts, theirs: Facts) -> None:
        assert np.array_equal(mine.figure, theirs.figure)
        assert np.array_equal(mine.reference, theirs.reference)
        names = (
            "separation",
            "normal",
            "intersection",
            "protrusion",
            "frontier",
            "vertical",
            "vertical_strict",
        )
        columns = [(name, getattr(mine, name), getattr(theirs, name)) for name in (*names, "ordered")]
        for one, other in zip(mine.views, theirs.views, strict=True):
            assert (one.withheld, one.ambiguous) == (other.withheld, other.ambiguous)
            for name in ("int_hs", "cont_hs"):
                ours, told = getattr(one, name), getattr(other, name)
                holds = (ours >= 0.0) | (told >= 0.0)
                columns.append((f"{name}, where it holds", ours[holds], told[holds]))
                columns.append((f"{name}, where it does not", ours[~holds], told[~holds]))
        for name, ours, told in columns:
            self.numbers[name] += ours.size
            self.other[name] += int((np.abs(ours.astype(float) - told) > 2.0 * SNAP).sum())


def _spoken(scene: Scene, facts: Facts) -> set[tuple[str, ...]]:
    """Return the relations of Table 1(b) that follow."""
    with KnowledgeBase(scene, facts=facts) as kb:
        return {
            (one.relation, one.figure, one.reference, one.view or "") for one in kb.relations(relation=SPOKEN)
        }


def _framed(scene: Scene) -> list[Any]:
    """Return the contextualised boxes of the world, then of each view."""
    views = [contextualise(scene.boxes, view.position)[0] for view in scene.views]
    return [align_with_world(scene.boxes)[0], *views]


def _ask(session: psycopg.Connection[Any], statement: str | Composed, **values: object) -> Array:
    """Return rows of numbers."""
    cursor = session.execute(statement, values)
    width = len(cursor.description or ())
    return np.array(cursor.fetchall(), dtype=np.float64).reshape(-1, width)
