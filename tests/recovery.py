"""How well a room is recovered from what was seen of it: boxes, surfaces and relations against the truth."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import trimesh
from scipy.optimize import linear_sum_assignment

from deixis._files import rules_dir
from deixis.boxes import NO_NORMAL, Boxes, min_bound_box
from deixis.grounding import ground
from deixis.measures import intersection_volume, place
from deixis.perception import perceive
from deixis.ruleset import load
from deixis.scene import Scene, SurfaceRegion
from deixis.sql import SqlExecutor
from deixis.vocabulary import RELATIONS
from render import Picture
from rooms import SHELL, Observed, Room, Thing, furnished, observe

ENOUGH = 150
"""Pixels in some frame that a visible thing has."""

WHOLE = 0.95
"""Share of its pixels seen, in at least two frames: a fully visible thing."""


@dataclass
class Score:
    """Figures of one room, or of several added up."""

    visible: int = 0
    recovered: int = 0
    whole: int = 0
    spurious: int = 0
    ious: list[float] = field(default_factory=list)
    tilts: list[float] = field(default_factory=list)
    offsets: list[float] = field(default_factory=list)
    missed_surfaces: int = 0
    both: int = 0
    found: int = 0
    true: int = 0
    wrong: Counter[str] = field(default_factory=Counter)
    worst: list[str] = field(default_factory=list)

    @property
    def f1(self) -> float:
        return 2.0 * self.both / max(self.found + self.true, 1)

    def add(self, other: Score) -> None:
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)

    def text(self) -> str:
        tilt, off = max(self.tilts, default=0.0), 100.0 * max(self.offsets, default=0.0)
        share = self.recovered / max(self.visible, 1)
        precision, recall = self.both / max(self.found, 1), self.both / max(self.true, 1)
        return (
            f"{self.visible} visible things, {self.recovered} recovered ({share:.1%}), "
            f"median IoU {np.median(self.ious):.3f}, {self.spurious} spurious; "
            f"surfaces within {tilt:.2f} degrees and {off:.2f} cm, {self.missed_surfaces} missed; "
            f"relations of {self.whole} whole things: F1 {self.f1:.3f} "
            f"(P {precision:.3f}, R {recall:.3f}, {self.true})"
        )


def boxes(room: Room) -> Boxes:
    rows = [min_bound_box(one.vertices) for one in room.things]
    return Boxes(
        np.array([r[0] for r in rows]),
        np.array([r[1] for r in rows]),
        np.array([r[2] for r in rows]),
        np.full(len(rows), NO_NORMAL),
        np.zeros(len(rows), dtype=bool),
    )


def ious(true: Boxes, turning: np.ndarray, found: Boxes) -> np.ndarray:
    """Return intersection over union, (true, found); what is round has a box for every yaw."""
    one, other = (axis.ravel() for axis in np.indices((len(true), len(found))))
    a, b = true.take(one), found.take(other)
    yaw = np.where(turning[one], b.yaw, a.yaw)
    a = Boxes(a.center, a.half, yaw, a.normal, a.ambiguous)
    common = intersection_volume(place(a, b), a.half, b.half)
    union = 8.0 * a.half.prod(axis=1) + 8.0 * b.half.prod(axis=1) - common
    return (common / union).reshape(len(true), len(found))


def visibility(room: Room, seen: Observed) -> tuple[set[int], set[int]]:
    """Return the visible and the fully visible things, by position.

    Visible: a frame has enough pixels of it, and all together show half of its surface, what it stands on
    left aside. Fully visible: besides, in two frames nothing is before it and it is not cut off.
    """
    visible, whole = set(), set()
    for position, thing in enumerate(room.things):
        number = position + 1
        pixels = [(one.seen[number], one.alone[number]) for one in seen.pictures]
        if max(s for s, _ in pixels) < ENOUGH or surface_seen(thing, number, seen) < 0.5:
            continue
        visible.add(position)
        clear = [
            s >= ENOUGH and s >= WHOLE * a and not _cut(picture, number)
            for picture, (s, a) in zip(seen.pictures, pixels, strict=True)
        ]
        if sum(clear) >= 2:
            whole.add(position)
    return visible, whole


def surface_seen(thing: Thing, number: int, seen: Observed) -> float:
    """Return the share of a thing's surface that is in some picture, what looks down left aside."""
    mesh = trimesh.Trimesh(thing.vertices, thing.faces, process=False)
    points, face = trimesh.sample.sample_surface(mesh, 1500, seed=0)
    normals = mesh.face_normals[face]
    points = points[normals[:, 2] > -0.5]
    shown = np.zeros(len(points), dtype=bool)
    for frame, picture in zip(seen.frames, seen.pictures, strict=True):
        camera = frame.camera
        own = (points - camera.position) @ camera.camera2world[:3, :3]
        ahead = own[:, 2] > 0.1
        z = np.where(ahead, own[:, 2], 1.0)
        u = np.rint(camera.fx * own[:, 0] / z + camera.cx).astype(int)
        v = np.rint(camera.fy * own[:, 1] / z + camera.cy).astype(int)
        inside = ahead & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
        at = np.flatnonzero(inside)
        there = picture.instances[v[at], u[at]] == number
        shown[at] |= there & (np.abs(picture.depth[v[at], u[at]] - z[at]) < 0.015)
    return float(shown.mean())


def _cut(picture: Picture, number: int) -> bool:
    """Return whether a thing goes beyond the picture."""
    border = np.concatenate([picture.instances[[0, -1]].ravel(), picture.instances[:, [0, -1]].ravel()])
    return bool((border == number).any())


@cache
def _engine() -> SqlExecutor:
    names = ("facts", "topology", "direction", "commonsense")
    return SqlExecutor(load([rules_dir() / f"{name}.pl" for name in names]), threads=1)


def relations(scene: Scene) -> set[tuple[object, ...]]:
    wanted = [(term.name, term.arity) for term in RELATIONS]
    labels = [(view.id, view.label) for view in scene.views]
    tables = _engine().run(ground(scene), wanted, view_labels=labels, margins=False)
    return {(name, *row) for (name, _), table in tables.items() for row in table.rows()}


def score(room: Room, seen: Observed, scene: Scene) -> Score:
    result = Score()
    visible, whole = visibility(room, seen)
    things = [i for i, one in enumerate(scene.objects) if one.kind == "object"]
    found = scene.boxes.take(np.array(things))
    overlap = ious(boxes(room), np.array([one.round for one in room.things]), found)
    rows, columns = linear_sum_assignment(overlap, maximize=True)
    match = {int(r): int(c) for r, c in zip(rows, columns, strict=True) if overlap[r, c] > 0.05}
    result.visible, result.whole = len(visible), len(whole)
    result.spurious = len(things) - len(match)
    for position in visible:
        value = float(overlap[position, match[position]]) if position in match else 0.0
        result.ious.append(value)
        result.recovered += value >= 0.7
        if value < 0.7:
            result.worst.append(f"{room.things[position].name} {value:.2f}")
    names = {scene.objects[things[c]].id: room.things[r].name for r, c in match.items() if r in whole}
    names |= _surfaces(scene, result)
    keep = {room.things[r].name for r in whole} | set(names.values())
    views = [
        {"id": view.id, "label": view.label, "position": view.position.tolist(), "heading": view.heading}
        for view in scene.views
    ]
    views_ids = {view.id for view in scene.views}
    true = {row for row in relations(room.scene(views)) if _about(row, keep | views_ids)}
    said = {
        (row[0], *(names.get(str(one), one) for one in row[1:]))
        for row in relations(scene)
        if _about(row, set(names) | views_ids)
    }
    result.both, result.found, result.true = len(true & said), len(said), len(true)
    result.wrong = Counter(f"-{row[0]}" for row in true - said) + Counter(f"+{row[0]}" for row in said - true)
    return result


def _about(row: tuple[object, ...], names: set[str]) -> bool:
    return all(one in names or one == "world" for one in row[1:])


def _surfaces(scene: Scene, result: Score) -> dict[str, str]:
    """Return the true name of each found surface; note how far each is off."""
    names: dict[str, str] = {}
    for name, ring in SHELL.items():
        corners = np.array(ring, dtype=float)
        normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
        normal /= np.linalg.norm(normal)
        best = None
        for thing in scene.objects:
            if not isinstance(thing.region, SurfaceRegion) or thing.id in names:
                continue
            polygon = thing.region.polygon
            spread = polygon - polygon.mean(axis=0)
            plane = np.linalg.svd(spread)[2][2]
            tilt = float(np.degrees(np.arccos(min(1.0, abs(plane @ normal)))))
            off = float(np.abs((polygon - corners[0]) @ normal).max())
            if tilt < 10.0 and off < 0.15 and thing.label == name.rstrip("1234"):
                best = thing.id, tilt, abs(float((polygon.mean(axis=0) - corners[0]) @ normal))
        if best is None:
            result.missed_surfaces += name != "ceiling"
            continue
        names[best[0]] = name
        result.tilts.append(best[1])
        result.offsets.append(best[2])
    return names


def room_score(seed: int, **options: object) -> Score:
    room = furnished(seed)
    seen = observe(room, seed, **options)  # type: ignore[arg-type]
    return score(room, seen, perceive(seen.frames))


def main() -> None:
    """Print the figures of some rooms: `python tests/recovery.py 0 10`."""
    first, last = (int(one) for one in (sys.argv[1:3] or (0, 5)))
    total = Score()
    for seed in range(first, last):
        one = room_score(seed)
        print(f"room {seed}: {one.text()}", flush=True)
        print("   ", one.worst, dict(one.wrong), flush=True)
        total.add(one)
    print(f"{last - first} rooms: {total.text()}")


if __name__ == "__main__":
    main()
