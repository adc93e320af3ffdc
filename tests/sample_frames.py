"""The sample frames of kb/frames, a desk seen from two sides: `python tests/sample_frames.py` writes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from deixis.perception import Camera, Frame
from deixis.scene import Label
from frames_written import write_frame
from render import Body, looking, noisy, placed, render
from rooms import table

FRAMES = Path(__file__).resolve().parent.parent / "kb" / "frames"

THINGS = (
    ("desk", table(1.3, 0.65, 0.72), (0.0, 0.0, 0.0), 0.1),
    ("mug", trimesh.creation.cylinder(0.045, 0.1), (0.35, -0.1, 0.72), 0.0),
    ("book", trimesh.creation.box([0.17, 0.24, 0.05]), (-0.1, -0.05, 0.72), 0.4),
    ("glasses case", trimesh.creation.box([0.16, 0.07, 0.05]), (-0.1, -0.05, 0.77), 0.6),
    ("bin", trimesh.creation.cylinder(0.14, 0.32), (0.95, -0.25, 0.0), 0.0),
)
NOISE = 0.004


def frames() -> list[Frame]:
    wall = np.array([[-1.8, 0.6, 0.0], [1.8, 0.6, 0.0], [1.8, 0.6, 2.2], [-1.8, 0.6, 2.2]])
    floor = np.array([[-1.8, -2.5, 0.0], [1.8, -2.5, 0.0], [1.8, 0.6, 0.0], [-1.8, 0.6, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    bodies = [Body(1 + i, *placed(mesh, at, yaw)) for i, (_, mesh, at, yaw) in enumerate(THINGS)]
    bodies += [Body(101, wall, faces), Body(102, floor, faces)]
    labels = {1 + i: (Label(name, 0.9), Label("thing", 0.1)) for i, (name, *_) in enumerate(THINGS)}
    result = []
    for step, eye in enumerate(((-0.9, -1.5, 1.45), (1.3, -1.35, 1.45))):
        camera = Camera(224, 168, 180.0, 180.0, 111.5, 83.5, looking(eye, (0.1, 0.0, 0.55)))
        seen = render(camera, bodies)
        numbers = np.where(seen.instances > 100, 0, seen.instances)
        depth = noisy(seen, NOISE, np.random.default_rng(step), 0.2)
        facing = float(np.arctan2(-eye[1], 0.1 - eye[0]))
        result.append(
            Frame(
                1_700_000_000.0 + 4 * step, camera, depth, numbers, labels, np.array([*eye[:2], 0.0]), facing,
                noise=NOISE,
            )
        )  # fmt: skip
    return result


if __name__ == "__main__":
    for number, frame in enumerate(frames(), 1):
        write_frame(frame, FRAMES / f"desk{number}.json")
