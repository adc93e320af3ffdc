"""Scenes that boxes cannot tell: what must hold of the meshes, what must not, and what else may be said."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh, transformations

from deixis.scene import Label, MeshRegion, Region, Scene, SpatialObject, SurfaceRegion, View
from regions import meshes
from regions.meshes import block, moved

Row = tuple[str, ...]
ROBOT = (-4.0, 0.5, 1.2)
FLOOR = ((-3.0, -3.0, 0.0), (3.0, -3.0, 0.0), (3.0, 3.0, 0.0), (-3.0, 3.0, 0.0))


@dataclass(frozen=True)
class Golden:
    """Things, of which one is moved about a little, and the relations asked for.

    ``either`` names relations of which at least one must hold.
    """

    name: str
    things: dict[str, Trimesh]
    moving: str
    holds: tuple[Row, ...] = ()
    fails: tuple[Row, ...] = ()
    either: tuple[Row, ...] = ()
    floor: Sequence[Sequence[float]] = FLOOR

    def shifted(self, offset: Sequence[float]) -> Golden:
        """Move one thing."""
        return replace(self, things={**self.things, self.moving: moved(self.things[self.moving], offset)})

    def scene(
        self, yaw: float = 0.0, shift: Sequence[float] = (0.0, 0.0, 0.0), mirror: bool = False
    ) -> Scene:
        """Return the scene turned, shifted, and mirrored in the XZ plane before both."""
        matrix = transformations.rotation_matrix(yaw, [0, 0, 1])
        matrix[:3, 3] = shift
        if mirror:
            matrix = matrix @ np.diag([1.0, -1.0, 1.0, 1.0])

        def place(points: Any) -> NDArray[np.float64]:
            return np.asarray(transformations.transform_points(np.asarray(points, dtype=np.float64), matrix))

        regions: dict[str, Region] = {"floor": SurfaceRegion(place(self.floor))}
        for name, mesh in self.things.items():
            faces = mesh.faces[:, ::-1] if mirror else mesh.faces
            regions[name] = MeshRegion(place(mesh.vertices), np.array(faces))
        objects = [
            SpatialObject(name, (Label(name),), "surface" if name == "floor" else "object", region)
            for name, region in regions.items()
        ]
        return Scene(self.name, tuple(objects), (View("v0", "robot", place([ROBOT])[0]),))


def nothing(figure: str, reference: str, *relations: str) -> tuple[Row, ...]:
    return tuple((relation, figure, reference) for relation in relations)


def golden() -> list[Golden]:
    """Return the scenes."""
    table, mug, bowl, chair = meshes.table(), meshes.mug(), meshes.bowl(), meshes.chair()
    lean = math.radians(20)
    book = moved(block((0.03, 0.17, 0.25), (-0.015, 0, 0.125)), (0, 0, 0), tilt=lean)
    # Its face, which is upright through the origin before, touches the carton's edge.
    book = moved(book, (-0.15 - 0.2 * math.tan(lean), 0, 0.03 * math.sin(lean)))
    tilt = math.radians(10)
    board = moved(block((0.03, 0.8, 1.2), (-0.015, 0, 0.6)), (0, 0, 0.03 * math.sin(tilt)), tilt=tilt)
    clock = moved(moved(meshes.clock(), (-0.03, 0.1, 0.85)), (0, 0, 0.03 * math.sin(tilt)), tilt=tilt)
    fruits = {
        f"fruit{number}": moved(meshes.fruit(), place)
        for number, place in enumerate(
            [(0, 0, 0.01)]
            + [
                (0.068 * math.cos(turn), 0.068 * math.sin(turn), 0.062)
                for turn in np.arange(5) * 0.4 * math.pi
            ]
        )
    }
    return [
        Golden(
            "box under a table",
            {"table": table, "carton": block((0.4, 0.3, 0.3), (0.1, 0.05, 0.15))},
            "carton",
            holds=(("below", "carton", "table"), ("on_top_of", "carton", "floor")),
            fails=nothing(
                "carton",
                "table",
                "inside",
                "part_in",
                "on_top_of",
                "above",
                "touches",
                "leans_on",
                "affixed_on",
            ),
        ),
        Golden(
            "pencil standing in a mug",
            {"mug": mug, "pencil": moved(meshes.pencil(), (-0.024, 0, 0.008), tilt=math.radians(15))},
            "pencil",
            holds=(("part_in", "pencil", "mug"), ("on_top_of", "mug", "floor")),
            fails=nothing(
                "pencil", "mug", "inside", "affixed_on", "leans_on", "on_top_of", "touches", "above"
            ),
        ),
        Golden(
            "cube wholly in a bowl",
            {"bowl": bowl, "cube": block((0.08, 0.08, 0.08), (0.0, 0.0, 0.065))},
            "cube",
            holds=(("inside", "cube", "bowl"), ("part_in", "cube", "bowl")),
            fails=nothing("cube", "bowl", "on_top_of", "affixed_on", "leans_on", "above"),
        ),
        Golden(
            "pear on a full bowl",
            {"bowl": bowl, **fruits, "pear": moved(meshes.pear(), (0.0, 0.0, 0.157))},
            "pear",
            either=(("on_top_of", "pear", "bowl"), ("part_in", "pear", "bowl")),
            fails=nothing("pear", "bowl", "inside", "leans_on", "affixed_on"),
        ),
        Golden(
            "book leaning on a box",
            {"carton": block((0.3, 0.3, 0.2), (0, 0, 0.1)), "book": book},
            "book",
            holds=(("leans_on", "book", "carton"), ("on_top_of", "book", "floor")),
            fails=nothing("book", "carton", "on_top_of", "above", "part_in", "inside", "affixed_on"),
        ),
        Golden(
            "clock on an upright board",
            {"board": board, "clock": clock},
            "clock",
            holds=(("affixed_on", "clock", "board"), ("on_top_of", "board", "floor")),
            fails=nothing("clock", "board", "on_top_of", "leans_on", "part_in", "inside"),
        ),
        Golden(
            "coat over a chair back",
            {"chair": chair, "coat": moved(meshes.coat(), (-0.205, 0, 0.903))},
            "coat",
            holds=(("touches", "coat", "chair"), ("on_top_of", "chair", "floor")),
            fails=nothing("coat", "chair", "inside", "part_in"),
        ),
        Golden(
            "chair pushed to a table",
            {"table": table, "chair": moved(meshes.chair(), (-0.41, 0, 0))},
            "chair",
            holds=(
                ("below", "chair", "table"),
                ("touches", "chair", "table"),
                ("on_top_of", "chair", "floor"),
            ),
            fails=nothing(
                "chair", "table", "on_top_of", "above", "inside", "part_in", "leans_on", "affixed_on"
            ),
        ),
        Golden(
            "balloon in the air between two tables",
            {
                "left": moved(table, (0, 0.65, 0)),
                "right": moved(table, (0, -0.65, 0)),
                "balloon": moved(meshes.balloon(), (0, 0, 0.95)),
            },
            "balloon",
            fails=tuple(
                row
                for side in ("left", "right")
                for row in nothing(
                    "balloon", side, "on_top_of", "inside", "part_in", "leans_on", "affixed_on"
                )
            ),
        ),
    ]
