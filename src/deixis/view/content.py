"""The data of the page: things, views, relations, their reasons, and what is drawn for each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from deixis.boxes import Boxes, align_with_world, contextualise
from deixis.facts import Facts
from deixis.frames import WORLD, Array, Mask
from deixis.proof import Proof
from deixis.scene import Scene
from deixis.thresholds import SNAP
from deixis.view.reasons import Reasons, short
from deixis.view.shapes import shapes


@dataclass(frozen=True, slots=True)
class Shown:
    """A relation on the page: its proof, with evidence, and its margin, which other proofs may widen."""

    proof: Proof
    margin: float | None


def page_data(
    scene: Scene, facts: Facts, found: Iterable[Shown], names: Mapping[str, str]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what the page needs at once, and what it needs when something is selected.

    Parameters
    ----------
    scene : Scene
    facts : Facts
        Of the scene.
    found : iterable of Shown
        What holds; arguments that are ids of things are linked to them.
    names : mapping of str to str
        What each thing is called, by its id.

    Returns
    -------
    dict
        Things with their boxes, views with contextualised boxes, relations in a row each.
    dict
        Tables of steps, and shapes other than boxes.
    """
    position = {name: index for index, name in enumerate(facts.ids)}
    views = {view.id: index for index, view in enumerate(scene.views)}
    reasons = Reasons()
    relations = []
    for one in found:
        args = one.proof.args
        last = args[-1] if len(args) == 3 and isinstance(args[-1], str) else None
        things = [position[arg] for arg in args if isinstance(arg, str) and arg in position]
        view = None if last is None or last in position else views.get(last)
        step = reasons.add(one.proof)
        relations.append([one.proof.predicate, things, view, one.margin, step, one.proof.text])
    boxes = scene.boxes
    now: dict[str, Any] = {
        "scene": scene.id,
        "region": facts.region,
        "thresholds": dict(facts.thresholds.items()),
        "notes": list(scene.diagnostics),
        "things": [
            [thing.id, names[thing.id], int(thing.kind == "surface"), model, *_box(boxes, index)]
            for index, (thing, model) in enumerate(zip(scene.objects, facts.models, strict=True))
        ],
        "views": [
            {"id": view.id, "label": view.label, "position": short(view.position), "heading": view.heading}
            for view in scene.views
        ],
        "frames": [_frame(scene, *_world(boxes))]
        + [_frame(scene, *_seen(boxes, view.position)) for view in scene.views],
        "withheld": [
            [views[view.view], index, reason]
            for view in facts.views
            if view.view != WORLD
            for index, reason in view.withheld
        ],
        "relations": relations,
    }
    return now, {**reasons.to_dict(), "shapes": shapes(scene.regions)}


def _box(boxes: Boxes, index: int) -> list[Any]:
    """Return centre, half extents and yaw of a box, and the axis along which its halfspace has no end."""
    normal = int(boxes.normal[index])
    return [short(boxes.center[index]), short(boxes.half[index]), round(float(boxes.yaw[index]), 6), normal]


def _world(boxes: Boxes) -> tuple[Boxes, Mask]:
    return align_with_world(boxes)[0], np.ones(len(boxes), dtype=np.bool_)


def _seen(boxes: Boxes, position: Array) -> tuple[Boxes, Mask]:
    framed, clearance, _ = contextualise(boxes, position)
    return framed, clearance > SNAP


def _frame(scene: Scene, framed: Boxes, seen: Mask) -> list[Any]:
    """Return half extents, yaw and how far each halfspace reaches, of the boxes turned to a view.

    None where the view says nothing of a thing's sides. What has no end reaches across the scene.
    """
    limits = scene.thresholds
    reach = 2.0 * limits.halfspace_scale * framed.effective_half(limits.granularity)
    across = float(np.linalg.norm(np.ptp(scene.boxes.center, axis=0))) + 1.0 if len(framed) else 0.0
    endless = np.arange(3) == framed.normal[:, None]
    reach = np.where(endless, across, reach)
    return [
        [*short(half), round(float(yaw), 6), *short(far)] if known else None
        for half, yaw, far, known in zip(framed.half, framed.yaw, reach, seen, strict=True)
    ]
