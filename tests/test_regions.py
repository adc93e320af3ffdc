"""Region models: scenes that boxes cannot tell, and laws that hulls and meshes share with boxes."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import prepositions
from deixis.errors import QueryError
from deixis.facts import Facts
from deixis.grounding import ground, look
from deixis.knowledge import KnowledgeBase
from deixis.regrounding import reground
from deixis.scene import BoxRegion, Label, MeshRegion, PointRegion, Scene, SpatialObject, SurfaceRegion, View
from regions import meshes
from regions.golden import Golden, Row, golden

GOLDEN = {one.name: one for one in golden()}
TOLD_BY_BOXES = {
    "cube wholly in a bowl",
    "pear on a full bowl",
    "book leaning on a box",
    "balloon in the air between two tables",
}
"""Scenes that boxes get right too; of the others they are wrong."""

DATA = Path(__file__).resolve().parent.parent.parent / "shared" / "data"


def holding(scene: Scene, region: Any) -> set[Row]:
    """Return the relations of a scene, with what touches."""
    with KnowledgeBase(scene, region=region) as kb:
        found: set[Row] = {(one.relation, one.figure, one.reference) for one in kb.relations()}
        return found | {("touches", one.figure, one.reference) for one in kb.relations(relation=["touches"])}


def wrong(case: Golden, found: set[Row]) -> set[Row]:
    """Return what should hold and does not, and what should not and does."""
    either = set() if not case.either or found & set(case.either) else set(case.either)
    return (set(case.holds) - found) | (set(case.fails) & found) | either


@pytest.mark.parametrize("name", GOLDEN)
def test_meshes_tell_what_boxes_cannot(name: str) -> None:
    case = GOLDEN[name]
    scene = case.scene()
    assert wrong(case, holding(scene, "mesh")) == set()
    assert bool(wrong(case, holding(scene, "box"))) == (name not in TOLD_BY_BOXES)


@pytest.mark.parametrize("name", GOLDEN)
@pytest.mark.parametrize("turn", range(3))
def test_meshes_tell_it_turned_mirrored_and_moved_a_little(name: str, turn: int) -> None:
    rng = np.random.default_rng([turn, *name.encode()])
    case = GOLDEN[name]
    # Up to 3 mm aside, and none down, where it would be forced into what it stands on.
    noise = [*rng.uniform(-0.003, 0.003, 2), abs(float(rng.uniform(0.0, 0.003)))]
    moved = case.shifted(noise)
    scene = moved.scene(float(rng.uniform(-math.pi, math.pi)), rng.uniform(-50, 50, 3), mirror=turn == 1)
    assert wrong(moved, holding(scene, "mesh")) == set()


# Laws


def thing(name: str, region: Any, kind: Any = "object") -> SpatialObject:
    return SpatialObject(name, (Label(name),), kind, region)


def solid_room(seed: int, *, far: float = 0.0) -> Scene:
    """Return meshes, a cloud, a box and a floor, at random places."""
    rng = np.random.default_rng(seed)
    made = [meshes.mug(), meshes.bowl(), meshes.pear(), meshes.chair(), meshes.block((0.3, 0.2, 0.1))]
    origin = np.array([far, -far, 0.0])
    things = []
    for number, mesh in enumerate(made):
        place = [*rng.uniform(-0.5, 0.5, 2), rng.uniform(0.0, 0.3)]
        placed = meshes.moved(mesh, place, yaw=float(rng.uniform(-3, 3)))
        things.append(thing(f"m{number}", MeshRegion(np.asarray(placed.vertices) + origin, placed.faces)))
    cloud = rng.uniform(-0.1, 0.1, (300, 3)) + np.array([0.4, 0.4, 0.5])
    things.append(thing("cloud", PointRegion(cloud + origin)))
    things.append(thing("box", BoxRegion(origin + np.array([0.0, 0.7, 0.2]), [0.2, 0.3, 0.4], 0.4)))
    ring = np.array([[-2, -2, 0], [2, -2, 0], [2, 2, 0], [0, 2.5, 0], [-2, 2, 0.0]])
    things.append(thing("floor", SurfaceRegion(ring + origin), "surface"))
    return Scene("room", tuple(things), (View("v0", "robot", origin + np.array([-3.0, 0.4, 1.2])),))


def tables(facts: Facts) -> dict[str, Any]:
    """Return the truth values of a scene by name."""
    found: dict[str, Any] = {}
    for row in range(len(facts)):
        pair = facts.ids[facts.figure[row]], facts.ids[facts.reference[row]]
        found[" ".join(pair)] = (
            bool(facts.touches[row]), bool(facts.intersects[row]), bool(facts.is_close[row]),
            bool(facts.compl_cont[row]), bool(facts.ordered[row]), *(facts.vertical[row] >= 0.0).tolist(),
        )  # fmt: skip
    for view in facts.views:
        for row, margins in zip(view.rows.tolist(), view.int_hs, strict=True):
            pair = facts.ids[facts.figure[row]], facts.ids[facts.reference[row]]
            found[" ".join((view.view, *pair))] = tuple((margins >= 0.0).tolist())
    return found


def same(one: Facts, other: Facts) -> bool:
    """Return whether two tables of facts are equal to the last bit."""
    columns = all(
        np.array_equal(getattr(one.pairs, name), getattr(other.pairs, name)) for name in one.pairs.__slots__
    )
    views = all(
        a.view == b.view
        and np.array_equal(a.rows, b.rows)
        and np.array_equal(a.int_hs, b.int_hs)
        and np.array_equal(a.cont_hs, b.cont_hs)
        for a, b in zip(one.views, other.views, strict=True)
    )
    return columns and views and one.models == other.models


@pytest.mark.parametrize("region", ["hull", "mesh"])
@pytest.mark.parametrize("seed", range(8))
def test_what_holds_of_all_regions(seed: int, region: Any) -> None:
    scene = solid_room(seed)
    facts = ground(scene, region=region)
    boxes = ground(scene)
    of = {
        pair: row
        for row, pair in enumerate(zip(facts.figure.tolist(), facts.reference.tolist(), strict=True))
    }
    for (a, b), row in of.items():
        back = of.get((b, a))
        if back is not None:
            # Symmetric measures are the same number either way.
            assert facts.separation[row] == facts.separation[back]
            assert facts.intersection[row] == facts.intersection[back]
        if facts.compl_cont[row]:
            assert facts.intersects[row]
        assert not (facts.touches[row] and facts.intersects[row])
        before = boxes.row(facts.ids[a], facts.ids[b])
        assert before is not None
        # What is within a box is no nearer than the box, and no deeper in.
        assert facts.distance[row] >= boxes.distance[before] - 1e-6
    for view in facts.views:
        assert (view.cont_hs <= view.int_hs + 1e-9).all()
        # Strict implies relaxed; and no thing meets both halfspaces of an axis while apart and convex.
        assert ((view.cont_hs < 0.0) | (view.int_hs >= 0.0)).all()


@pytest.mark.parametrize("region", ["hull", "mesh"])
def test_nothing_changes_far_from_the_origin(region: Any) -> None:
    for seed in range(3):
        here, there = (
            ground(solid_room(seed), region=region),
            ground(solid_room(seed, far=2.0**20), region=region),
        )
        assert np.abs(here.separation - there.separation).max() < 1e-6
        assert tables(here) == tables(there)


@pytest.mark.parametrize("region", ["hull", "mesh"])
def test_moving_and_looking_again_equal_a_full_run(region: Any) -> None:
    before = solid_room(1)
    facts = ground(before, region=region)
    things = list(before.objects)
    mug = things[0].region
    assert isinstance(mug, MeshRegion)
    things[0] = thing("m0", MeshRegion(mug.vertices + np.array([0.05, -0.02, 0.0]), mug.faces))
    after = Scene("room", tuple(things), (View("v1", "robot", [2.0, 3.0, 1.0]), before.views[0]))
    assert same(reground(before, facts, after), ground(after, region=region))
    turned = Scene("room", before.objects, (View("v1", "robot", [2.0, 3.0, 1.0]),))
    assert same(reground(before, facts, turned), ground(turned, region=region))
    assert np.array_equal(
        look(turned, facts, turned.views[0]).int_hs, ground(turned, region=region).views[1].int_hs
    )


def test_a_mesh_turned_over_within_its_box_is_seen() -> None:
    mug, cube = meshes.mug(), meshes.block((0.03, 0.03, 0.03), (0.0, 0.0, 0.03))
    region = MeshRegion(np.asarray(mug.vertices), mug.faces)
    middle = 0.5 * (mug.vertices.min(axis=0) + mug.vertices.max(axis=0))
    over = MeshRegion((np.asarray(mug.vertices) - middle) * [1.0, -1.0, -1.0] + middle, mug.faces)
    inner = thing("cube", MeshRegion(np.asarray(cube.vertices), cube.faces))
    more = [thing(f"b{number}", BoxRegion([number, 5.0, 0.0], [0.1, 0.1, 0.1])) for number in range(9)]
    before = Scene("s", (thing("mug", region), inner, *more), ())
    after = Scene("s", (thing("mug", over), inner, *more), ())
    assert np.allclose(before.boxes.center, after.boxes.center)
    facts = ground(before, region="mesh")
    assert facts.compl_cont[facts.row("cube", "mug")]
    again = reground(before, facts, after)
    assert same(again, ground(after, region="mesh"))
    # Under a mug that is upside down there is nothing to lie on: it is not in it.
    assert not again.compl_cont[again.row("cube", "mug")]


@pytest.mark.parametrize("region", ["hull", "mesh"])
def test_boxes_given_as_meshes_are_as_boxes(region: Any) -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        boxes, solids = [], []
        for number in range(4):
            size, yaw = rng.uniform(0.1, 0.6, 3), float(rng.uniform(-3, 3))
            center = rng.uniform(-0.6, 0.6, 3)
            mesh = meshes.moved(meshes.block(size), center, yaw=yaw)
            boxes.append(thing(f"o{number}", BoxRegion(center, size, yaw)))
            solids.append(thing(f"o{number}", MeshRegion(np.asarray(mesh.vertices), mesh.faces)))
        one, other = (
            ground(Scene("s", tuple(boxes), ())),
            ground(Scene("s", tuple(solids), ()), region=region),
        )
        assert (one.figure == other.figure).all()
        assert np.abs(one.separation - other.separation).max() < 1e-5
        # Of things that are apart no more is known than a bound: that the one sticks out.
        near = one.separation <= 0.0
        assert np.abs(one.protrusion - other.protrusion)[near].max(initial=0.0) < 1e-5
        assert (other.protrusion[~near] > 0.0).all()


# What is said of the model


def test_what_has_only_a_box_is_told() -> None:
    scene = solid_room(0)
    with KnowledgeBase(scene, region="mesh") as kb:
        assert kb.box_only == ("box",)
        assert kb.measured_as == {
            **{f"m{number}": "mesh" for number in range(5)}, "cloud": "hull", "box": "box", "floor": "outline"
        }  # fmt: skip
        assert kb.facts.region == "mesh"
        answer = kb.why("near(box, floor)")
        assert answer.measured_as == {"box": "box", "floor": "outline"}
        assert {row["X"]: row["M"] for row in kb.ask("measured_as(X, M)").bindings}["cloud"] == "hull"
    assert KnowledgeBase(scene).box_only == ()
    hulls = KnowledgeBase(scene, region="hull").measured_as
    assert (hulls["m0"], hulls["cloud"], hulls["box"]) == ("hull", "hull", "box")


def test_an_unknown_model_is_refused() -> None:
    unknown: Any = "voxel"
    with pytest.raises(QueryError, match="no region model 'voxel': known are box, hull, mesh"):
        KnowledgeBase(solid_room(0), region=unknown)
    with pytest.raises(QueryError, match="no region model 'voxel'"):
        ground(solid_room(0), region=unknown)


def test_without_the_library_one_is_told_what_to_install() -> None:
    program = (
        "import sys; sys.modules['fcl'] = None\n"
        "from deixis.errors import MissingDependency\n"
        "from deixis.grounding import ground\n"
        "from test_regions import solid_room\n"
        "scene = solid_room(0)\n"
        "ground(scene)\n"
        "try: ground(scene, region='mesh')\n"
        "except MissingDependency as error: print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=Path(__file__).parent, check=True
    )
    assert "pip install 'deixis[mesh]'" in done.stdout


def test_a_scene_of_boxes_alone_needs_no_library() -> None:
    scene = solid_room(0)
    boxes = replace(scene, objects=tuple(one for one in scene.objects if isinstance(one.region, BoxRegion)))
    assert same(replace(ground(boxes), region="mesh"), ground(boxes, region="mesh"))


# Hostile meshes


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [0, 0, 0], [0, 0, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 2], [2, 1, 0]]),
        ([[0, 0, 0], [1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]], [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]),
        ([[0, 0, 0], [300, 0, 0], [0, 300, 0], [0, 0, 0.001]], [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]),
    ],
)
@pytest.mark.parametrize("region", ["hull", "mesh"])
def test_meshes_that_are_hardly_any(vertices: list[list[float]], faces: list[list[int]], region: Any) -> None:
    odd = thing("odd", MeshRegion(np.array(vertices, dtype=float), np.array(faces)))
    mug = meshes.mug()
    scene = Scene(
        "s",
        (odd, thing("mug", MeshRegion(np.asarray(mug.vertices), mug.faces))),
        (View("v0", "robot", [-2.0, 0.1, 1.0]),),
    )
    facts = ground(scene, region=region)
    for name in ("separation", "protrusion", "vertical", "vertical_strict", "intersection", "frontier"):
        assert np.isfinite(getattr(facts, name)).all(), name
    for view in facts.views:
        assert np.isfinite(view.int_hs).all()
        assert np.isfinite(view.cont_hs).all()


@pytest.mark.skipif(
    not (DATA / "prepositions").exists(),
    reason="the labelled scenes, ../shared/data/prepositions, are not here",
)
def test_meshes_are_nearer_to_what_people_say_than_boxes() -> None:
    tables = prepositions.scores(DATA, ("box", "mesh"))
    box, mesh = tables["box"], tables["mesh"]
    for word in prepositions.WORDS:
        assert mesh[word].f1 >= box[word].f1, word
    for word in ("in", "inside", "below", "against"):
        assert mesh[word].f1 > box[word].f1, word
    assert mesh["inside"].f1 == 1.0
    assert mesh["in"].f1 > 0.8
    assert mesh["on top of"].f1 == 1.0
    assert mesh["under"].f1 > 0.9
