"""Two readings of the same facts: truth columns in numpy, and what the rules derive from the numbers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from deixis.facts import Facts
from deixis.frames import HORIZONTAL, WORLD
from deixis.grounding import ground
from deixis.knowledge import KnowledgeBase
from deixis.prolog import PrologEngine
from deixis.scene import Scene
from deixis.vocabulary import BASE, RELATIONS
from scenes import box, scene, turned
from worlds import World, worlds

Row = tuple[str, ...]
Point = tuple[float, float, float]
Table = dict[str, set[Row]]

SCENES = sorted(path.stem for path in (Path(__file__).parent.parent / "kb" / "scenes").glob("*.json"))
PREDICATES = [(term.name, term.arity) for term in (*BASE, *RELATIONS)] + [("int_hs", 4), ("cont_hs", 4)]
COMPASS = {"X+": "east", "X-": "west", "Y+": "north", "Y-": "south"}
SIDES = {"X+": "behind", "X-": "in_front_of", "Y+": "left_of", "Y-": "right_of"}


def by_rules(engine: PrologEngine, scene: Scene) -> Table:
    """Return what holds by the rules."""
    engine.load(KnowledgeBase(scene).facts_text(readable=False))
    return {
        name: {tuple(map(str, row)) for row in rows} for name, rows in engine.relations(PREDICATES).items()
    }


def by_columns(facts: Facts) -> Table:
    """Return what holds by the truth columns, and by the words of the axioms as operations on sets."""
    ids = np.array(facts.ids, dtype=object)

    def pairs(truth: np.ndarray, rows: np.ndarray | None = None) -> set[Row]:
        at = np.flatnonzero(truth) if rows is None else rows[truth]
        return set(zip(ids[facts.figure[at]], ids[facts.reference[at]], strict=True))

    of: Table = {name: pairs(getattr(facts, name)) for name in ("is_close", "touches", "intersects")}
    of["compl_cont"] = {(container, content) for content, container in pairs(facts.compl_cont)}
    of["int_hs"], of["cont_hs"] = set(), set()
    for column, axis in enumerate(("Z+", "Z-")):
        side = "above" if axis == "Z+" else "below"
        meets = facts.vertical[:, column] >= 0.0
        of[f"{side}_r"] = pairs(meets)
        of[f"{side}_s"] = pairs(meets & (facts.vertical_strict[:, column] >= 0.0))
        of["int_hs"] |= {(*pair, axis, WORLD) for pair in of[f"{side}_r"]}
        of["cont_hs"] |= {(*pair, axis, WORLD) for pair in of[f"{side}_s"]}
    ordered = pairs(facts.ordered)
    spoken: Table = {side: set() for side in SIDES.values()}
    for view in facts.views:
        for column, axis in enumerate(HORIZONTAL):
            meets = view.int_hs[:, column] >= 0.0
            found, within = (
                pairs(meets, view.rows),
                pairs(meets & (view.cont_hs[:, column] >= 0.0), view.rows),
            )
            of["int_hs"] |= {(*pair, axis, view.view) for pair in found}
            of["cont_hs"] |= {(*pair, axis, view.view) for pair in within}
            if view.view == WORLD:
                of[f"{COMPASS[axis]}_r"], of[f"{COMPASS[axis]}_s"] = found, within
            else:
                spoken[SIDES[axis]] |= {(*pair, view.view) for pair in found & ordered}
    return of | spoken | commonsense(of, spoken, ordered, facts)


def commonsense(of: Table, sides: Table, ordered: set[Row], facts: Facts) -> Table:
    above, below = of["above_r"] & ordered, of["below_r"] & ordered
    touching = of["touches"] & ordered
    touched: dict[str, set[str]] = {}
    for one, other in of["touches"]:
        touched.setdefault(one, set()).add(other)
    frontier = {
        (facts.ids[i], facts.ids[j]): measure
        for i, j, measure in zip(facts.figure, facts.reference, facts.frontier, strict=True)
    }
    standing = {figure for figure in touched if any((on, figure) in of["below_r"] for on in touched[figure])}
    return {
        "above": above,
        "below": below,
        "near": of["is_close"] & ordered,
        "inside": {(content, container) for container, content in of["compl_cont"]} & ordered,
        "beside": sides["left_of"] | sides["right_of"],
        "on_top_of": above & of["touches"],
        "leans_on": {row for row in touching - above - below if row[0] in standing},
        "affixed_on": {row for row in touching - above if touched[row[0]] == {row[1]}},
        "part_in": {(a, b) for a, b in of["intersects"] & ordered if frontier[a, b] < frontier[b, a]},
    }


def differences(one: Table, other: Table) -> dict[str, set[Row]]:
    return {name: one[name] ^ other[name] for name in one.keys() | other.keys() if one[name] != other[name]}


@given(world=worlds(most=6))
def test_rules_and_columns_agree_on_random_worlds(engine: PrologEngine, world: World) -> None:
    it = world.scene()
    assert not differences(by_rules(engine, it), by_columns(ground(it)))


# A block one metre wide and a small cube of 20 cm, at D = 2 cm, P = 4 cm, T = 1 m, s = 1.2.
BOUNDS = [
    ("touches", (0.1, 0.2, 1.0 + 0.02 + 0.1), (0.0, 0.0, 1.0)),
    ("touches", (0.1, 0.2, 1.0 - 0.04 + 0.1), (0.0, 0.0, -1.0)),
    ("is_close", (0.5 + 1.0 + 0.1, 0.2, 0.5), (1.0, 0.0, 0.0)),
    ("compl_cont", (0.5 + 0.02 - 0.1, 0.2, 0.5), (1.0, 0.0, 0.0)),
    ("above", (0.1, 0.2, 1.0 + 2.4 * 0.5 + 0.1), (0.0, 0.0, 1.0)),
    ("above", (0.5 + 0.1 - 0.01, 0.2, 1.4), (1.0, 0.0, 0.0)),
    ("behind", (0.5 + 2.4 * 0.5 + 0.1, 0.2, 0.5), (1.0, 0.0, 0.0)),
    ("left_of", (0.5 + 0.1 - 0.01, 0.9, 0.5), (1.0, 0.0, 0.0)),
]
"""A relation, where the cube just satisfies it, and the direction in which it no longer does."""


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, -2.1])
@pytest.mark.parametrize(("relation", "center", "out"), BOUNDS)
def test_bounds_are_closed(
    engine: PrologEngine, relation: str, center: Point, out: Point, angle: float
) -> None:
    view = {"id": "v0", "position": [-7.0, 0.0, 0.5], "heading": 0.0}
    for step, holds in ((0.0, True), (-1.0e-6, True), (1.0e-6, False)):
        cube = box("cube", [c + step * o for c, o in zip(center, out, strict=True)], (0.2, 0.2, 0.2))
        parts = (box("block", (0, 0, 0.5), (1, 1, 1)), cube, view)
        block, cube, view_ = (turned(part, angle, (3.7, -1.2, 0.4)) for part in parts)
        it = scene(block, cube, views=[view_])
        found, same = by_rules(engine, it), by_columns(ground(it))
        assert not differences(found, same)
        names = ("block", "cube") if relation == "compl_cont" else ("cube", "block")
        viewed = ("v0",) if relation in ("behind", "left_of") else ()
        assert ((*names, *viewed) in found[relation]) == holds


@pytest.mark.parametrize("name", SCENES)
def test_rules_and_columns_agree_on_the_samples(engine: PrologEngine, root: Path, name: str) -> None:
    it = Scene.load(root / "kb" / "scenes" / f"{name}.json")
    found = by_columns(ground(it))
    assert not differences(by_rules(engine, it), found)
    assert all(found[relation] for relation in ("on_top_of", "near"))
