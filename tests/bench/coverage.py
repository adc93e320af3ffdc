"""Table 1 of the paper, operator by operator: ``make coverage`` writes what this finds to ``kb/coverage.md``.

    python -m bench.coverage [FILE]

Every number is found in this one run. All but the last column of the first table and the line on the server are the
same wherever PostGIS and GEOS are of the same version.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psycopg

from bench.coverage_cases import CASES
from bench.job import room
from bench.run import number, table, wrapped
from deixis.boxes import min_bound_box
from deixis.facts import Facts
from deixis.frames import Array, Mask
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.postgis import grounding as postgis
from deixis.scene import BoxRegion, Label, Scene, SpatialObject
from postgis_server import postgis as server

ROOMS, THINGS, NESTED = 20, 50, 5
"""Twenty rooms of fifty boxes are a thousand; five in each lie in, or stick out of, others."""

CLOUDS = 1_000


class Row(NamedTuple):
    """A line of Table 1(a): the paper's name, its operators, and what of ours it is compared with."""

    name: str
    operators: str
    ours: str


TABLE_1A = {
    "box": Row("Min Oriented BBox", "ST_OrientedEnvelope, ST_ZMin, ST_ZMax, ST_Extrude", "`Scene.boxes` of boxes"),
    "cloud": Row("", "the same", "`Scene.boxes` of point clouds"),
    "frame": Row("CBB", "ST_Rotate, ST_Angle, ST_Centroid", "`boxes.contextualise`"),
    "upright": Row("Top/Bottom Halfspaces", "ST_Extrude", "where they begin and end"),
    "side": Row("L/R/Front/Back Halfspaces", "ST_Extrude", "where they begin and end"),
    "order": Row("Reference object set", "ST_Volume", "`figure_reference/2`"),
    "close": Row("IsClose", "ST_3DDWithin, T", "`is_close/2`"),
    "touch": Row("Touches", "ST_3DDWithin, 0", "`touches/2`"),
    "meet": Row("Int", "ST_3DIntersects", "`intersects/2`"),
    "inter": Row("inter", "ST_3DIntersection, ST_Volume", "`intersection/3`"),
    "held": Row("ComplCont", "ST_3DIntersection, ST_Volume", "`compl_cont/2`"),
    "vertical": Row("Above, Below", "ST_3DIntersects", "`above_r/2`, `below_r/2`"),
    "horizontal": Row("LeftOf, RightOf, InFrontOf, Behind", "ST_3DIntersects", "`int_hs/4`"),
    "part": Row("adjSRCard", "ST_Scale, ST_Intersection, ST_Volume", "`adj_sr_card/3`: whose is less"),
}

COSTS = {
    "box": "minimum_box",
    "frame": "contextualised_box",
    "upright": "top_and_bottom",
    "side": "sides",
    "order": "reference_order",
    "close": "near",
    "meet": "overlap",
    "inter": "intersection",
    "held": "containment",
    "vertical": "above_and_below",
    "horizontal": "beside",
    "part": "frontier",
}
"""Which file does the work of a line; its time is by the rows it makes."""

MADE = {
    "reference_order": "size",
    "intersection": "inter",
    "above_and_below": "vertical",
    "beside": "aspect",
    **{name: name for name in ("minimum_box", "contextualised_box", "top_and_bottom", "sides", "near", "overlap")},
    **{name: name for name in ("containment", "frontier")},
}

TABLE_1B = {
    "beside": "RightOf, LeftOf",
    "on_top_of": "Touches, Above",
    "leans_on": "Touches, Above, Below",
    "affixed_on": "Touches, Above",
    "inside": "ComplCont",
    "part_in": "inter, adjSRCard",
    "near": "IsClose",
}

_PAIR = """
SELECT figure, reference, ST_3DDWithin(a.solid, b.solid, t), ST_3DDWithin(a.solid, b.solid, 0),
       ST_3DIntersects(a.solid, b.solid), coalesce(contained, false)
FROM threshold, containment JOIN minimum_box AS a ON a.thing = figure JOIN minimum_box AS b ON b.thing = reference
ORDER BY figure, reference
"""

_BEYOND = """
SELECT ST_3DDistance(ST_MakePoint(x, y, {z}), beyond), ST_3DMaxDistance(ST_MakePoint(x, y, {z}), ST_Force3D(beyond))
FROM {table}
"""


def random_room(seed: int) -> Scene:
    """Return a room of boxes, some of them within others, or all but."""
    rng = np.random.default_rng(seed)
    one = room(THINGS, seed)
    things = list(one.objects)
    for at in range(NESTED):
        host = things[3 + at].region
        assert isinstance(host, BoxRegion)
        size = host.size * rng.uniform(0.3, 0.9, 3)
        turn = host.yaw + float(rng.choice([0.0, 0.0, 0.3]))
        out = rng.choice([0.0, 0.0, 0.01, 0.3])
        offset = rng.uniform(-0.5, 0.5, 3) * (host.size - size) * (0.9 if turn == host.yaw else 0.2)
        offset[2] += out
        cos, sin = np.cos(host.yaw), np.sin(host.yaw)
        center = host.center + [cos * offset[0] - sin * offset[1], sin * offset[0] + cos * offset[1], offset[2]]
        things[-1 - at] = SpatialObject(f"n{at}", (Label("thing"),), "object", BoxRegion(center, size, turn))
    return Scene(f"room-{seed}", tuple(things), one.views, one.thresholds)


class Study:
    """What was compared and how it came out, summed over scenes."""

    def __init__(self, connection: psycopg.Connection[Any]) -> None:
        self.connection = connection
        self.compared: Counter[str] = Counter()
        self.agreed: Counter[str] = Counter()
        self.seconds: Counter[str] = Counter()
        self.made: Counter[str] = Counter()
        self.causes: dict[str, Counter[str]] = {key: Counter() for key in TABLE_1A}
        self.numbers: Counter[str] = Counter()
        self.other: Counter[str] = Counter()
        self.relations: Counter[str] = Counter()
        self.differing: Counter[str] = Counter()

    def compare(self, key: str, same: Mask, **causes: Mask) -> None:
        """Count what is the same, and of what is not the first cause that fits."""
        self.compared[key] += same.size
        self.agreed[key] += int(same.sum())
        left = ~same
        for cause, fits in causes.items():
            self.causes[key][cause] += int((left & fits).sum())
            left = left & ~fits
        self.causes[key]["nothing known"] += int(left.sum())

    def look(self, scene: Scene) -> None:
        """Ground a scene both ways and compare."""
        facts = ground(scene)
        with postgis.session(self.connection) as session:
            postgis.load(session, scene)
            for row in postgis.ROWS:
                start = time.perf_counter()
                postgis.run(session, row)
                self.seconds[row] += time.perf_counter() - start
                (self.made[row],) = np.add(self.made[row], *session.execute(_count(row)).fetchall()).tolist()
            other = postgis.facts(session, scene)
            self._boxes(session, scene)
            self._pairs(session, facts, other)
        self._facts(facts, other)
        self._relations(scene, facts, other)

    def _boxes(self, session: psycopg.Connection[Any], scene: Scene) -> None:
        ...
