"""How long facts of meshes take: 1,000 things with about 5,000 faces each, one to a square metre.

    python tests/bench/mesh_bench.py [things]

A third are convex, the others are not: mugs, bowls, tables, rings, stars; each has a mesh of its own. Some
stand on tables or in bowls. First is with everything to be prepared, warm the best of three runs after it.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
import trimesh

from deixis.facts import REGION_MODELS
from deixis.grounding import ground, look
from deixis.scene import Label, MeshRegion, Scene, SpatialObject, SurfaceRegion, View

FACES = 5000


def finer(mesh: trimesh.Trimesh, faces: int = FACES) -> trimesh.Trimesh:
    """Halve the longest sides until there are about so many faces."""
    length = float(mesh.extents.max())
    while len(mesh.faces) < 0.7 * faces:
        length *= 0.8
        vertices, found = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, length)
        if len(found) > 1.6 * faces:
            break
        mesh = trimesh.Trimesh(vertices, found, process=True)
    return mesh


def mug() -> trimesh.Trimesh:
    profile = [(0, 0), (0.04, 0), (0.04, 0.1), (0.035, 0.1), (0.035, 0.006), (0, 0.006)]
    return finer(trimesh.creation.revolve(profile, sections=48))


def bowl() -> trimesh.Trimesh:
    angle = np.linspace(0, np.pi / 2, 12)
    outer = np.column_stack([0.15 * np.sin(angle), 0.15 - 0.15 * np.cos(angle)])
    inner = np.column_stack([0.14 * np.sin(angle), 0.15 - 0.14 * np.cos(angle)])[::-1]
    return finer(trimesh.creation.revolve(np.concatenate([outer, inner]), sections=96))


def table() -> trimesh.Trimesh:
    def part(size: tuple[float, float, float], center: tuple[float, float, float]) -> trimesh.Trimesh:
        return trimesh.creation.box(size, trimesh.transformations.translation_matrix(center))

    parts = [part((0.9, 0.6, 0.03), (0, 0, 0.705))]
    parts += [part((0.05, 0.05, 0.69), (x, y, 0.345)) for x in (-0.4, 0.4) for y in (-0.25, 0.25)]
    return finer(trimesh.util.concatenate(parts))


def ring() -> trimesh.Trimesh:
    return trimesh.creation.torus(0.15, 0.04, 80, 32)


def star() -> trimesh.Trimesh:
    mesh = trimesh.creation.icosphere(4, 1.0)
    swell = 1.0 + 0.35 * np.sin(5 * mesh.vertices[:, 0]) * np.cos(6 * mesh.vertices[:, 1])
    mesh.vertices = mesh.vertices * swell[:, None] * 0.2
    return mesh


def ball() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(4, 0.12)


def carton() -> trimesh.Trimesh:
    return finer(trimesh.creation.box((0.4, 0.3, 0.3)))


KINDS: tuple[Callable[[], trimesh.Trimesh], ...] = (mug, bowl, table, ring, star, ball, carton, ball, carton)


def room(things: int, seed: int = 0) -> Scene:
    """Return things on a floor, every third on or in another; nothing stands in another's way."""
    rng = np.random.default_rng(seed)
    models = {kind: kind() for kind in dict.fromkeys(KINDS)}
    side = int(np.ceil(np.sqrt(2 * things / 3)))
    pitch = float(np.sqrt(things)) / side
    width = side * pitch
    ring = [[-1, -1, 0], [width + 1, -1, 0], [width + 1, width + 1, 0], [-1, width + 1, 0]]
    objects = [SpatialObject("floor", (Label("floor"),), "surface", SurfaceRegion(ring))]
    places = rng.permutation(side * side)
    place, below = np.zeros(3), 0
    for number in range(things):
        kind = KINDS[int(rng.integers(len(KINDS)))]
        if number % 3 == 2:
            # On a table, in a bowl, on a carton: what is small enough.
            kind = (mug, ball)[int(rng.integers(2))]
            place[:2] += rng.uniform(-0.03, 0.03, 2)
        else:
            row, column = divmod(int(places[below]), side)
            below += 1
            place = np.array([*(np.array([row, column]) + rng.uniform(0.3, 0.7, 2)) * pitch, 0.0])
        low, high = models[kind].bounds
        turn = trimesh.transformations.rotation_matrix(rng.uniform(-np.pi, np.pi), [0, 0, 1])[:3, :3]
        vertices = models[kind].vertices @ turn.T + place - [0, 0, low[2]]
        region = MeshRegion(vertices, models[kind].faces)
        objects.append(SpatialObject(f"{kind.__name__}{number}", (Label(kind.__name__),), "object", region))
        # A mug or a ball in a bowl stands on its bottom.
        place[2] += 0.06 if kind is bowl else high[2] - low[2]
    return Scene("room", tuple(objects), (View("v0", "robot", [-3.0, 0.4, 1.2]),))


def main(things: int) -> None:
    """Print the times."""
    scene = room(things)
    faces = [len(one.region.faces) for one in scene.objects if isinstance(one.region, MeshRegion)]
    print(f"{things} things, {np.mean(faces):,.0f} faces each ({min(faces):,} to {max(faces):,})")
    kinds = Counter(one.label for one in scene.objects)
    print(", ".join(f"{count} {kind}" for kind, count in kinds.most_common()))
    start = time.perf_counter()
    len(scene.boxes)
    print(f"boxes of the meshes: {time.perf_counter() - start:.2f} s")
    for region in REGION_MODELS:
        times = []
        for _ in range(4):
            start = time.perf_counter()
            facts = ground(scene, region=region)
            times.append(time.perf_counter() - start)
        start = time.perf_counter()
        look(scene, facts, View("v1", "", [5.0, -2.0, 1.0]))
        view = time.perf_counter() - start
        print(
            f"{region:<5} first {times[0]:7.3f} s   warm {min(times[1:]):7.3f} s   new view {view:7.3f} s   "
            f"{len(facts)} pairs, {int(facts.touches.sum())} touch, {int(facts.intersects.sum())} intersect"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
