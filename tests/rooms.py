"""Random furnished rooms with all that is true of them, and what a robot in them sees."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import trimesh

from deixis.frames import Array
from deixis.perception import Camera, Frame
from deixis.scene import Label, Scene
from render import Body, Picture, looking, noisy, placed, render

WIDTH, DEPTH, HEIGHT = 4.4, 4.0, 2.6
STAMP = 1_583_236_000.0

OTHERS = ("lamp", "toy", "box", "tin", "vase", "radio", "clock", "basket")


@dataclass
class Thing:
    """A thing of the true room."""

    name: str
    label: str
    vertices: Array
    faces: np.ndarray
    round: bool = False


@dataclass
class Room:
    """A furnished room: things, and four walls, floor and ceiling."""

    things: list[Thing] = field(default_factory=list)

    def bodies(self) -> list[Body]:
        bodies = [Body(i + 1, thing.vertices, thing.faces) for i, thing in enumerate(self.things)]
        for name, ring in SHELL.items():
            faces = np.array([[0, 1, 2], [0, 2, 3]])
            bodies.append(Body(1000 + list(SHELL).index(name), np.array(ring), faces))
        return bodies

    def scene(self, views: list[dict[str, object]]) -> Scene:
        """Return the true scene: meshes as they are, walls and floor whole."""
        objects: list[dict[str, object]] = [
            {"id": one.name, "label": one.label, "mesh": {"vertices": one.vertices, "faces": one.faces}}
            for one in self.things
        ]
        objects += [
            {"id": name, "kind": "surface", "label": name.rstrip("1234"), "polygon": ring}
            for name, ring in SHELL.items()
        ]
        return Scene.from_dict({"deixis": 1, "id": "truth", "objects": objects, "views": views})


X, Y, Z = WIDTH, DEPTH, HEIGHT
SHELL = {
    "floor": [[0, 0, 0.0], [X, 0, 0], [X, Y, 0], [0, Y, 0]],
    "ceiling": [[0, 0, Z], [X, 0, Z], [X, Y, Z], [0, Y, Z]],
    "wall1": [[0, 0, 0.0], [X, 0, 0], [X, 0, Z], [0, 0, Z]],
    "wall2": [[X, 0, 0.0], [X, Y, 0], [X, Y, Z], [X, 0, Z]],
    "wall3": [[X, Y, 0.0], [0, Y, 0], [0, Y, Z], [X, Y, Z]],
    "wall4": [[0, Y, 0.0], [0, 0, 0], [0, 0, Z], [0, Y, Z]],
}


def _slabs(*parts: tuple[tuple[float, float, float], tuple[float, float, float]]) -> trimesh.Trimesh:
    """Return boxes given by size and centre as one mesh."""
    return trimesh.util.concatenate(
        [trimesh.creation.box(size, trimesh.transformations.translation_matrix(at)) for size, at in parts]
    )


def table(w: float, d: float, h: float) -> trimesh.Trimesh:
    legs = [
        ((0.05, 0.05, h - 0.03), (sx * (w / 2 - 0.05), sy * (d / 2 - 0.05), (h - 0.03) / 2))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    return _slabs(((w, d, 0.03), (0, 0, h - 0.015)), *legs)


def shelf(w: float, d: float, heights: tuple[float, ...]) -> trimesh.Trimesh:
    top = heights[-1]
    boards = [((w, d, 0.02), (0, 0, h - 0.01)) for h in heights]
    sides = [((0.02, d, top), (s * (w / 2 - 0.01), 0, top / 2)) for s in (-1, 1)]
    return _slabs(*boards, *sides, ((w, 0.01, top), (0, d / 2 - 0.005, top / 2)))


def chair() -> trimesh.Trimesh:
    legs = [((0.04, 0.04, 0.43), (sx * 0.19, sy * 0.19, 0.215)) for sx in (-1, 1) for sy in (-1, 1)]
    return _slabs(((0.44, 0.44, 0.03), (0, 0, 0.445)), ((0.44, 0.03, 0.42), (0, 0.205, 0.67)), *legs)


def _small(rng: np.random.Generator, tallest: float) -> tuple[str, trimesh.Trimesh, bool]:
    kind = rng.choice(["book", "box", "cup", "bottle", "bowl", "ball", "cone", "books"])
    match kind:
        case "book":
            return (
                kind,
                trimesh.creation.box(
                    [rng.uniform(0.14, 0.2), rng.uniform(0.2, 0.27), rng.uniform(0.03, 0.06)]
                ),
                False,
            )
        case "books":
            return (
                kind,
                trimesh.creation.box([rng.uniform(0.15, 0.3), 0.16, min(rng.uniform(0.2, 0.27), tallest)]),
                False,
            )
        case "box":
            return (
                str(rng.choice(OTHERS)),
                trimesh.creation.box([*rng.uniform(0.1, 0.3, 2), min(rng.uniform(0.08, 0.3), tallest)]),
                False,
            )
        case "cup":
            return (
                kind,
                trimesh.creation.cylinder(rng.uniform(0.04, 0.05), rng.uniform(0.08, 0.11), sections=48),
                True,
            )
        case "bottle":
            return (
                kind,
                trimesh.creation.cylinder(
                    rng.uniform(0.04, 0.05), min(rng.uniform(0.2, 0.3), tallest), sections=48
                ),
                True,
            )
        case "bowl":
            return (
                kind,
                trimesh.creation.cylinder(rng.uniform(0.08, 0.13), rng.uniform(0.06, 0.1), sections=48),
                True,
            )
        case "ball":
            return kind, trimesh.creation.icosphere(3, min(rng.uniform(0.06, 0.12), tallest / 2)), True
    return (
        "cone",
        trimesh.creation.cone(rng.uniform(0.08, 0.12), min(rng.uniform(0.18, 0.3), tallest), sections=48),
        True,
    )


def furnished(seed: int, number: int = 30) -> Room:
    """Return a random room: two tables, a shelf, a cabinet, two chairs, and small things on all of them."""
    rng = np.random.default_rng(seed)
    room = Room()

    def stand(name: str, label: str, mesh: trimesh.Trimesh, x: float, y: float, yaw: float) -> Thing:
        thing = Thing(name, label, *placed(mesh, (x, y, 0.0), yaw))
        room.things.append(thing)
        return thing

    side = rng.permutation(2)
    t1 = rng.uniform(1.0, 1.5), rng.uniform(0.6, 0.8), rng.uniform(0.68, 0.78)
    t2 = rng.uniform(0.8, 1.1), rng.uniform(0.5, 0.7), rng.uniform(0.42, 0.55)
    s_heights = (0.1, 0.48, 0.86, 1.24)
    places = {}
    places["shelf1"] = (WIDTH - 0.19, rng.uniform(1.2, DEPTH - 1.2), -np.pi / 2)
    places["cabinet1"] = (rng.uniform(2.7, 3.3), DEPTH - 0.26, 0.0)
    places["table1"] = (rng.uniform(1.8, 2.3), rng.uniform(1.7, 2.3), rng.uniform(-0.6, 0.6))
    places["table2"] = (rng.uniform(1.0, 1.5), 0.55 if side[0] else DEPTH - 0.5, rng.uniform(-0.15, 0.15))
    shelf1 = stand("shelf1", "shelf", shelf(1.2, 0.36, s_heights), *places["shelf1"])
    cab = rng.uniform(0.8, 1.0), 0.45, rng.uniform(0.8, 1.0)
    cabinet = stand("cabinet1", "cabinet", trimesh.creation.box(cab), *places["cabinet1"])
    table1 = stand("table1", "table", table(*t1), *places["table1"])
    table2 = stand("table2", "coffee table", table(*t2), *places["table2"])
    stand("chair1", "chair", chair(), 3.2, rng.uniform(0.5, 0.9), rng.uniform(-3, 3))
    stand("chair2", "chair", chair(), 0.6, rng.uniform(2.0, 2.6), rng.uniform(-3, 3))
    supports = [
        (table1, places["table1"], t1[0], t1[1], t1[2], 0.3),
        (table2, places["table2"], t2[0], t2[1], t2[2], 0.3),
        (cabinet, places["cabinet1"], cab[0], cab[1], cab[2], 0.3),
        *((shelf1, places["shelf1"], 1.12, 0.32, h, 0.3) for h in s_heights),
        (None, (WIDTH / 2, DEPTH / 2, 0.0), WIDTH - 0.4, DEPTH - 0.4, 0.0, 0.35),
    ]
    weights = np.array([7, 4, 3, 1, 2, 2, 2, 2.0])
    occupied: list[list[tuple[Array, float]]] = [[] for _ in supports]
    for thing in room.things:
        occupied[-1].append(_circle(thing.vertices))
    count: dict[str, int] = {}
    while len(room.things) < number:
        where = int(rng.choice(len(supports), p=weights / weights.sum()))
        _, (px, py, yaw), w, d, h, tallest = supports[where]
        label, mesh, is_round = _small(rng, tallest)
        radius = 0.5 * float(np.hypot(*np.ptp(mesh.vertices, axis=0)[:2]))
        turn = rng.uniform(-np.pi, np.pi)
        for _ in range(30):
            if w / 2 <= radius or d / 2 <= radius:
                turn, room_x, room_y = yaw, 0.4 * (w - np.ptp(mesh.vertices[:, 0])), 0.02
            else:
                room_x, room_y = w / 2 - radius, d / 2 - radius
            a, b = rng.uniform(-1, 1) * room_x, rng.uniform(-1, 1) * room_y
            x = px + np.cos(yaw) * a - np.sin(yaw) * b
            y = py + np.sin(yaw) * a + np.cos(yaw) * b
            if all(np.hypot(x - c[0], y - c[1]) > radius + r + 0.03 for c, r in occupied[where]):
                break
        else:
            continue
        count[label] = count.get(label, 0) + 1
        thing = Thing(f"{label}{count[label]}", label, *placed(mesh, (x, y, h), turn), is_round)
        occupied[where].append(_circle(thing.vertices))
        room.things.append(thing)
    return room


def _circle(vertices: Array) -> tuple[Array, float]:
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))[:2]
    return middle, float(np.hypot(*(vertices[:, :2] - middle).T).max())


def poses(seed: int) -> list[tuple[Array, Array]]:
    """Return five places in the room to look from, and where to look."""
    rng = np.random.default_rng(seed + 10_000)
    eyes = [(0.3, 0.3), (WIDTH - 0.3, 0.3), (WIDTH - 0.3, DEPTH - 0.3), (0.3, DEPTH - 0.3), (2.3, 0.85)]
    targets = [(2.5, 2.3), (1.9, 2.2), (1.8, 1.6), (2.2, 1.8), (3.6, 2.6)]
    result = []
    for (x, y), (tx, ty) in zip(eyes, targets, strict=True):
        dx, dy = rng.uniform(-0.1, 0.1, 2)
        eye = np.array([x + dx, y + dy, rng.uniform(1.35, 1.6)])
        result.append((eye, np.array([tx, ty, 0.55])))
    return result


@dataclass
class Observed:
    """A room as seen: frames, and of each the picture without noise and the number each thing has in it."""

    frames: list[Frame]
    pictures: list[Picture]
    numbers: list[dict[int, int]]


def observe(
    room: Room, seed: int, noise: float = 0.01, flying: float = 0.3, count: int = 5, known_noise: bool = True
) -> Observed:
    """Return what a robot sees from its poses; what it calls a thing is right two times of three, or near."""
    rng = np.random.default_rng(seed + 20_000)
    result = Observed([], [], [])
    labels = sorted({thing.label for thing in room.things})
    for step, (eye, target) in enumerate(poses(seed)[:count]):
        camera = Camera(640, 480, 525.0, 525.0, 319.5, 239.5, looking(eye, target))
        picture = render(camera, room.bodies())
        depth = noisy(picture, noise, rng, flying, dropped=0.01)
        mixed = dict(
            zip(range(1, len(room.things) + 1), (1 + rng.permutation(len(room.things))).tolist(), strict=True)
        )
        table = np.zeros(2000, dtype=np.int64)
        for number, shown in mixed.items():
            table[number] = shown
        ranked = {}
        for number, shown in mixed.items():
            names = [room.things[number - 1].label, *rng.choice(labels, 4, replace=False).tolist()]
            scores = sorted(rng.dirichlet([6, 3, 1, 1, 1]).tolist(), reverse=True)
            if rng.random() < 0.15:
                names[0], names[1] = names[1], names[0]
            ranked[shown] = tuple(Label(n, s) for n, s in zip(dict.fromkeys(names), scores, strict=False))
        result.frames.append(
            Frame(
                STAMP + 7.5 * step,
                camera,
                depth,
                table[picture.instances],
                ranked,
                np.array([eye[0], eye[1], 0.0]),
                float(np.arctan2(target[1] - eye[1], target[0] - eye[0])),
                noise=noise if known_noise else None,
            )
        )
        result.pictures.append(picture)
        result.numbers.append(mixed)
    return result
