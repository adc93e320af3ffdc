"""Draw the picture of the README from the real scene and geometry.

    python tests/draw.py

writes ``kb/pictures/figure3.svg``, the plan view of ``kb/scenes/hans.json``; a test checks it is current.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from deixis.boxes import Boxes, contextualise
from deixis.scene import Scene, View

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "kb" / "scenes" / "hans.json"
PICTURE = ROOT / "kb" / "pictures" / "figure3.svg"

SCALE = 170.0
"""Pixels a metre."""

REFERENCE, FIGURE, VIEW = "radiator", "extinguisher2", "v0"
"""What the picture is about."""

LABELS = {
    "radiator": (("radiator",), 50.0, 40.0),
    "extinguisher1": (("extinguisher1", "and its sign,", "higher up"), 0.0, 40.0),
    "sign": ((), 0.0, 0.0),
    "extinguisher2": (("extinguisher2",), 0.0, 40.0),
    "heater": (("heater, and on top", "of it the sweater"), 0.0, 56.0),
    "sweater": ((), 0.0, 0.0),
}
"""The lines of text by a thing, and how many pixels right of and below its centre they begin."""

LEGEND = (
    "dashed: the radiator's box,",
    "turned to the robot's line of sight",
    "shaded: the space left of it",
)

LINE = 18.0
"""Pixels from one line of text to the next."""

STYLE = """\
text { font: 15px sans-serif; text-anchor: middle }
.label { fill: #222 }
.floor { fill: #f6f4ef }
.wall { stroke: #444; stroke-width: 7 }
.thing { fill: #c9ced6; stroke: #444; stroke-width: 1.2 }
.figure { fill: #d9472b; stroke: #7c1f0e }
.high { fill: #fff; fill-opacity: .65; stroke-dasharray: 2 2 }
.cbb { fill: none; stroke: #1763a6; stroke-width: 1.6; stroke-dasharray: 6 4 }
.left { fill: #1763a6; fill-opacity: .3; stroke: #1763a6; stroke-opacity: .5 }
.sight { stroke: #1763a6; stroke-width: 1.3; stroke-dasharray: 1 4; stroke-linecap: round }
.view { fill: #1763a6; stroke: #0e3c66 }
.other { fill: #9aa3ad; stroke: #5d6670 }
.says { fill: #1763a6 }"""

Point = Sequence[float]


class Plan:
    """A drawing seen from above: world metres in, pixels out, Y upwards."""

    def __init__(self, low: Point, high: Point) -> None:
        self.low, self.high = low, high
        self.lines: list[str] = []

    def place(self, point: Point) -> tuple[float, float]:
        return (point[0] - self.low[0]) * SCALE, (self.high[1] - point[1]) * SCALE

    def polygon(self, points: Iterable[Point], kind: str) -> None:
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.place, points))
        self.lines.append(f'<polygon class="{kind}" points="{corners}"/>')

    def line(self, start: Point, end: Point, kind: str) -> None:
        (x1, y1), (x2, y2) = self.place(start), self.place(end)
        self.lines.append(f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>')

    def text(
        self, point: Point, lines: Iterable[str], right: float, down: float, kind: str = "label"
    ) -> None:
        x, y = self.place(point)
        for number, words in enumerate(lines):
            line = y + down + number * LINE
            self.lines.append(
                f'<text class="{kind}" x="{x + right:.1f}" y="{line:.1f}">{escape(words)}</text>'
            )

    def view(self, view: View, words: str, kind: str) -> None:
        """Draw who looks, as an arrowhead along the heading."""
        x, y = view.position[:2]
        tip, back = 0.13, 0.11
        turns = (0.0, 2.5, math.pi, -2.5)
        reaches = (tip, back, 0.4 * back, back)
        corners = [
            (x + reach * math.cos(view.heading + turn), y + reach * math.sin(view.heading + turn))
            for turn, reach in zip(turns, reaches, strict=True)
        ]
        self.polygon(corners, kind)
        self.text(view.position, [words], 0.0, 36.0)

    def svg(self, title: str) -> str:
        width, height = ((high - low) * SCALE for low, high in zip(self.low, self.high, strict=True))
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
            f'width="{width:.0f}" height="{height:.0f}" role="img">'
        )
        background = f'<rect class="floor" width="{width:.0f}" height="{height:.0f}" rx="6"/>'
        parts = [head, f"<title>{escape(title)}</title>", f"<style>\n{STYLE}\n</style>", background]
        return "\n".join([*parts, *self.lines, "</svg>", ""])


def corners(boxes: Boxes, index: int, low: Point | None = None, high: Point | None = None) -> list[Point]:
    """Return the corners, in the world, of a box's base or of another rectangle in the box's frame."""
    half = boxes.half[index, :2]
    (x0, y0), (x1, y1) = (-half if low is None else low), (half if high is None else high)
    cos, sin = math.cos(boxes.yaw[index]), math.sin(boxes.yaw[index])
    x, y = boxes.center[index, :2]
    ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return [(x + cos * u - sin * v, y + sin * u + cos * v) for u, v in ring]


def figure_3(scene: Scene) -> str:
    """Return the picture: what the robot sees, and the space left of the radiator."""
    boxes, about = scene.boxes, scene.index(REFERENCE)
    views = {view.id: view for view in scene.views}
    things = [index for index, thing in enumerate(scene.objects) if thing.kind == "object"]
    around = np.array(
        [*(corner for index in things for corner in corners(boxes, index))]
        + [view.position[:2] for view in scene.views]
    )
    plan = Plan(around.min(axis=0) - np.array([0.45, 0.35]), around.max(axis=0) + np.array([0.4, 0.22]))

    seen = contextualise(boxes, views[VIEW].position)[0]
    x_half, y_half, _ = seen.half[about]
    depth = 2.0 * scene.thresholds.halfspace_scale * y_half
    plan.polygon(corners(seen, about, (-x_half, y_half), (x_half, y_half + depth)), "left")
    plan.line(views[VIEW].position, boxes.center[about], "sight")

    (wall,) = (index for index in range(len(boxes)) if boxes.normal[index] in (0, 1))
    y = boxes.center[wall, 1]
    plan.line((plan.low[0], y), (plan.high[0], y), "wall")
    plan.text((plan.high[0] - 0.2, y), ["wall"], 0.0, -12.0)

    top, bottom = (boxes.center[:, 2] + side * boxes.half[:, 2] for side in (1.0, -1.0))
    for index in things:
        name = scene.objects[index].id
        higher = bottom[index] > top[about]
        kind = "thing figure" if name == FIGURE else "thing high" if higher else "thing"
        plan.polygon(corners(boxes, index), kind)
        plan.text(boxes.center[index], *LABELS[name])
    plan.polygon(corners(seen, about), "cbb")

    for view in scene.views:
        who = view.label if view.label == "you" else f"the {view.label}"
        plan.view(view, f"{view.id}, {who}", "view" if view.id == VIEW else "other")
    left, front = boxes.center[scene.index(FIGURE), 0], (views[VIEW].position[1] + y) / 2.0
    plan.text((left - 0.4, front), LEGEND, 0.0, 0.0, "says")
    return plan.svg("The sample scene from above: extinguisher2 is left of the radiator as the robot sees it")


if __name__ == "__main__":
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.write_text(figure_3(Scene.load(SCENE)), encoding="utf-8")
