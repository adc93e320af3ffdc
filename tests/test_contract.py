"""The contract of cases: how the axioms are to be read, case by case, with noise and turned every way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from scenes import ROBOT, box, floor, scene, turned, wall

TURNS = (0.0, math.pi / 2, 0.3, -2.1)
Row = tuple[str, ...]
Reason = Callable[..., set[Row]]


@dataclass(frozen=True)
class Case:
    """Objects, and what must and must not hold of them."""

    name: str
    objects: tuple[dict[str, Any], ...]
    holds: tuple[Row, ...] = ()
    fails: tuple[Row, ...] = ()
    either: tuple[Row, ...] = ()


TABLE = box("table", (0, 0, 0.36), (1.2, 0.8, 0.72))
TABLE_TOP = 0.72


def cup(gap: float, x: float = 0.1, y: float = 0.1, yaw: float = 0.4) -> dict[str, Any]:
    return box("cup", (x, y, TABLE_TOP + gap + 0.05), (0.08, 0.08, 0.10), yaw)


def cases() -> Iterator[Case]:
    for gap in (0.0, 0.01, 0.019, -0.005, -0.03):
        yield Case(
            f"cup on table, gap {gap}",
            (TABLE, cup(gap)),
            holds=(("touches", "cup", "table"), ("above", "cup", "table"), ("on_top_of", "cup", "table")),
            fails=(("part_in", "cup", "table"), ("inside", "cup", "table"), ("leans_on", "cup", "table")),
        )
    for noise in (-0.01, 0.0, 0.01):
        yield Case(
            f"gap 6 cm, noise {noise}",
            (TABLE, cup(0.06 + noise)),
            holds=(("above", "cup", "table"), ("near", "cup", "table")),
            fails=(("touches", "cup", "table"), ("on_top_of", "cup", "table")),
        )
    for gap in (-0.005, 0.0, 0.005, 0.015):
        sheet = box("paper", (0.2, -0.1, TABLE_TOP + gap + 0.0005), (0.3, 0.21, 0.001), 0.2)
        yield Case(
            f"sheet of paper on a table, gap {gap}",
            (TABLE, sheet),
            holds=(("on_top_of", "paper", "table"),),
            fails=(("inside", "paper", "table"), ("part_in", "paper", "table")),
        )
    for dx in (-0.019, 0.0, 0.019):
        for dz in (-0.019, 0.0, 0.019):
            yield Case(
                f"two books side by side, noise {dx} {dz}",
                (
                    box("one", (0, 0, 0.12), (0.04, 0.17, 0.24)),
                    box("two", (0.04 + dx, 0, 0.12 + dz), (0.04, 0.17, 0.24)),
                ),
                either=(
                    ("beside", "one", "two", "v0"),
                    ("in_front_of", "one", "two", "v0"),
                    ("behind", "one", "two", "v0"),
                ),
                fails=(
                    ("above", "one", "two"),
                    ("above", "two", "one"),
                    ("on_top_of", "one", "two"),
                    ("on_top_of", "two", "one"),
                ),
            )
    for aside in (0.005, 0.015, -0.015):
        yield Case(
            f"cup hovering beside the table edge, {aside}",
            (TABLE, box("cup", (0.6 + aside + 0.04, 0, TABLE_TOP), (0.08, 0.08, 0.10))),
            fails=(("above", "cup", "table"), ("on_top_of", "cup", "table")),
        )
    yield Case(
        "cup over the empty corner of a turned table's axis-aligned box",
        (box("table", (0, 0, 0.36), (1.2, 0.8, 0.72), math.pi / 4), cup(0.0, 0.62, 0.62)),
        fails=(
            ("above", "cup", "table"),
            ("on_top_of", "cup", "table"),
            ("touches", "cup", "table"),
            ("below_r", "table", "cup"),
        ),
    )
    yield Case(
        "cup at the far end of a 6 m table",
        (box("table", (0, 0, 0.36), (6.0, 0.9, 0.72)), cup(0.0, 2.9, 0.2)),
        holds=(("on_top_of", "cup", "table"),),
    )
    yield Case(
        "box on a 2 m shelf",
        (box("shelf", (0, 0, 1.0), (0.8, 0.3, 2.0)), box("carton", (0.1, 0, 2.15), (0.3, 0.25, 0.3), 0.1)),
        holds=(("on_top_of", "carton", "shelf"),),
    )
    for gap in (-0.01, 0.0, 0.01):
        yield Case(
            f"cup on the floor inside the footprint of a table's box, {gap}",
            (floor(), TABLE, box("cup", (0.1, 0.1, 0.05 + gap), (0.08, 0.08, 0.10))),
            holds=(("on_top_of", "cup", "floor"),),
            fails=(("leans_on", "cup", "table"), ("on_top_of", "cup", "table")),
        )
    cabinet = box("cabinet", (0, 0, 0.5), (0.6, 0.5, 1.0))
    yield Case(
        "jar wholly inside a cabinet",
        (cabinet, box("jar", (0.0, 0.02, 0.25), (0.1, 0.1, 0.2))),
        holds=(("inside", "jar", "cabinet"), ("part_in", "jar", "cabinet")),
        fails=(
            ("affixed_on", "jar", "cabinet"),
            ("on_top_of", "jar", "cabinet"),
            ("leans_on", "jar", "cabinet"),
        ),
    )
    for bottom in (-0.005, 0.005, 0.02):
        yield Case(
            f"knife at the bottom of a drawer, {bottom} above it",
            (
                box("drawer", (0, 0, 0.8), (0.4, 0.4, 0.15)),
                box("knife", (0.05, 0, 0.725 + bottom + 0.01), (0.25, 0.03, 0.02), 0.2),
            ),
            holds=(("inside", "knife", "drawer"), ("part_in", "knife", "drawer")),
            fails=(("on_top_of", "knife", "drawer"), ("affixed_on", "knife", "drawer")),
        )
    for noise in (-0.02, 0.0, 0.02):
        yield Case(
            f"towel half inside a cabinet, {noise}",
            (cabinet, box("towel", (-0.3 + noise, 0, 0.4), (0.5, 0.3, 0.05))),
            holds=(("part_in", "towel", "cabinet"),),
            fails=(("inside", "towel", "cabinet"), ("affixed_on", "towel", "cabinet")),
        )
    for gap in (-0.015, 0.0, 0.015):
        yield Case(
            f"picture flush on a wall, gap {gap}",
            (floor(), wall(), box("picture", (1.985 - gap, 0.5, 1.5), (0.03, 0.5, 0.4))),
            holds=(("affixed_on", "picture", "wall"),),
            fails=(
                ("leans_on", "picture", "wall"),
                ("on_top_of", "picture", "wall"),
                ("part_in", "picture", "wall"),
            ),
        )
        yield Case(
            f"board standing on the floor against the wall, gap {gap}",
            (floor(), wall(), box("board", (1.98 - gap, 0.5, 0.6 + gap), (0.04, 0.8, 1.2))),
            holds=(("leans_on", "board", "wall"), ("on_top_of", "board", "floor")),
            fails=(("affixed_on", "board", "wall"), ("affixed_on", "board", "floor")),
        )
    for gap in (-0.005, 0.0, 0.005):
        yield Case(
            f"thin lamp under the ceiling, gap {gap}",
            (
                floor(),
                {**floor("ceiling", z=2.5), "label": "ceiling"},
                box("lamp", (0, 0, 2.4925 - gap), (0.2, 0.2, 0.015)),
            ),
            holds=(("affixed_on", "lamp", "ceiling"),),
            fails=(("on_top_of", "lamp", "ceiling"), ("above", "lamp", "ceiling")),
        )


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("case", list(cases()), ids=lambda case: case.name)
def test_case(case: Case, turn: float, reason: Reason) -> None:
    shift = (1.7, -3.2, 0.0) if turn else (0.0, 0.0, 0.0)
    found = reason(
        scene(
            *(turned(one, turn, shift) for one in case.objects),
            views=[turned(ROBOT, turn, shift)],
        ),
        "below_r",
        "touches",
    )
    assert set(case.holds) <= found
    assert not set(case.fails) & found
    assert not case.either or set(case.either) & found


@pytest.mark.parametrize("turn", TURNS)
def test_a_jar_in_a_cabinet_seen_squarely_is_not_beside_it(turn: float, reason: Reason) -> None:
    view = {"id": "v0", "position": [-3.0, 0.0, 1.0], "heading": 0.0}
    for x in (-0.2, 0.0, 0.2):
        found = reason(
            scene(
                turned(box("cabinet", (0, 0, 0.5), (0.6, 0.5, 1.0)), turn),
                turned(box("jar", (x, 0.1, 0.25), (0.1, 0.1, 0.2)), turn),
                views=[turned(view, turn)],
            )
        )
        assert not {row for row in found if row[0] in ("beside", "behind", "in_front_of")}


def test_no_relation_is_stated_from_within_a_reference(reason: Reason) -> None:
    for position in ([0.0, 0.0, 1.0], [0.3, 0.2, 0.0]):
        view = {"id": "v0", "position": position, "heading": 0.0}
        found = reason(scene(TABLE, box("chair", (0.75, 0, 0.3), (0.25, 0.4, 0.6)), views=[view]))
        assert not {row for row in found if row[2] == "table" and len(row) == 4}


def test_figure_3(reason: Reason, figure_3: Any) -> None:
    found = reason(figure_3)
    assert {
        ("affixed_on", "extinguisher1", "wall"),
        ("leans_on", "extinguisher2", "wall"),
        ("left_of", "extinguisher2", "radiator", "v0"),
        ("on_top_of", "sweater", "heater"),
        ("near", "sign", "extinguisher1"),
    } <= found
    assert not {row for row in found if row[1] in ("wall", "floor")}
    assert not {row for row in found if row[2] == "floor" and len(row) == 4}
