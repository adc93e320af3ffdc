"""Mapping: frames become one scene, with a view for each frame (section 4.1 of the paper)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from deixis.errors import SceneError
from deixis.frames import Array
from deixis.perception.association import associate, boxes_of, doubles, fused
from deixis.perception.carving import Backdrop
from deixis.perception.frame import CloudFrame, Frame
from deixis.perception.shapes import region_of
from deixis.perception.surfaces import find_surfaces
from deixis.perception.views import Sighting, show, show_cloud
from deixis.scene import Label, Scene, SpatialObject, SurfaceRegion, View
from deixis.strict_json import quoted
from deixis.thresholds import Thresholds

DECIMALS: Final = 4
"""Tenths of a millimetre: finer than any camera sees."""

FEW: Final = 200
"""Points by which sightings of one thing are known."""

KEPT: Final = 16
"""Latest frames whose images are kept, to look through points of others with."""


@dataclass
class _Thing:
    """A thing of the map as far as it is known."""

    id: str
    clouds: list[tuple[Array, Array]] = field(default_factory=list)
    seen: list[tuple[tuple[Label, ...], float]] = field(default_factory=list)
    views: list[str] = field(default_factory=list)
    outer: Array = field(default_factory=lambda: np.empty((0, 3)))

    def add(self, sighting: Sighting, view: str) -> None:
        self.clouds.append((sighting.points, sighting.wobble))
        self.outer = _some(np.concatenate([self.outer, _some(sighting.points)]))
        self.seen.append((sighting.labels, float(len(sighting.points))))
        self.views.append(view)

    def join(self, other: _Thing) -> None:
        """Take over what was seen of another, which is the same."""
        self.clouds += other.clouds
        self.seen += other.seen
        self.views += other.views
        self.outer = _some(np.concatenate([self.outer, other.outer]))

    @property
    def labels(self) -> tuple[Label, ...]:
        return fused(self.seen)


class Map:
    """A map that grows frame by frame.

    Parameters
    ----------
    name : str
        Id of the scene.
    thresholds : Thresholds, optional
    """

    def __init__(self, name: str, thresholds: Thresholds | None = None) -> None:
        self.name = name
        self.thresholds = thresholds or Thresholds()
        self._things: list[_Thing] = []
        self._views: list[View] = []
        self._rest: list[tuple[Array, Array]] = []
        self._noise = 0.0
        self._notes: list[str] = []
        self._backdrops: list[Backdrop] = []

    def add(self, frame: Frame | CloudFrame, advance: Callable[[int], None] | None = None) -> None:
        """Add what a frame shows.

        Parameters
        ----------
        frame : Frame or CloudFrame
        advance : function, optional
            Told how many points of a cloud were read, again and again.

        Raises
        ------
        SceneError
            Another frame has the same stamp.
        """
        moment = f"t{round(frame.stamp * 1000.0)}"
        view = View(moment, frame.robot, frame.position, frame.heading, frame.stamp)
        if any(one.id == moment for one in self._views):
            raise SceneError(f"two frames have the stamp {frame.stamp:.3f}: give each its own")
        shown = show(frame) if isinstance(frame, Frame) else show_cloud(frame, advance)
        self._views.append(view)
        self._notes += [f"frame {moment}: {note}" for note in shown.notes]
        self._rest.append((shown.rest, shown.eye))
        self._noise = max(self._noise, shown.noise)
        match = self._match(shown.things)
        new, numbers = 0, dict[int, int]()
        for position, sighting in enumerate(shown.things):
            if position in match:
                self._things[match[position]].add(sighting, moment)
                numbers[sighting.number] = match[position] + 1
                continue
            new += 1
            thing = _Thing(f"{moment}_{new}")
            thing.add(sighting, moment)
            self._things.append(thing)
            numbers[sighting.number] = len(self._things)
        if isinstance(frame, Frame):
            backdrop = Backdrop.of(frame, moment, shown.noise, numbers)
            self._backdrops = [*self._backdrops, backdrop][-KEPT:]

    def _match(self, sightings: Sequence[Sighting]) -> dict[int, int]:
        """Return for sightings of one frame which known thing each is of; those that are left out are new."""
        if not self._things:
            return {}
        return associate(
            boxes_of([thing.outer for thing in self._things]),
            [thing.labels for thing in self._things],
            boxes_of([_some(one.points) for one in sightings]),
            [one.labels for one in sightings],
            self.thresholds.granularity,
        )

    def _settle(self) -> None:
        """Let things that turned out to be one be one; the older keeps its id."""
        while len(self._views) > 1:
            found = doubles(
                boxes_of([thing.outer for thing in self._things]),
                [thing.labels for thing in self._things],
                [set(thing.views) for thing in self._things],
                self.thresholds.granularity,
            )
            if not found:
                return
            for later, earlier in found.items():
                self._things[earlier].join(self._things[later])
            left = [number for number in range(len(self._things)) if number not in found]
            renumbered = {number + 1: place for place, number in enumerate(left, 1)}
            renumbered |= {later + 1: renumbered[earlier + 1] for later, earlier in found.items()}
            for backdrop in self._backdrops:
                for number, thing in backdrop.things.items():
                    backdrop.things[number] = renumbered[thing]
            self._things = [self._things[number] for number in left]

    def _kept(self, number: int, thing: _Thing) -> tuple[Array, Array]:
        """Return a thing's points without those that some frame looks through, and their errors."""
        points, wobbles = [], []
        for (cloud, wobble), view in zip(thing.clouds, thing.views, strict=True):
            keep = np.ones(len(cloud), dtype=np.bool_)
            for backdrop in self._backdrops:
                if backdrop.view != view:
                    keep &= ~backdrop.looks_through(cloud, number)
            points.append(cloud[keep])
            wobbles.append(wobble[keep])
        return np.concatenate(points), np.concatenate(wobbles)

    def scene(self) -> Scene:
        """Return the scene of all that was added."""
        self._settle()
        objects, notes = [], list(self._notes)
        for number, thing in enumerate(self._things, 1):
            region, note = region_of(*self._kept(number, thing), self.thresholds)
            if note:
                notes.append(f"object {quoted(thing.id)}: {note}")
            objects.append(
                SpatialObject(thing.id, thing.labels, "object", region, tuple(sorted(thing.views)))
            )
        if self._rest:
            points = np.concatenate([rest for rest, _ in self._rest])
            eyes = np.concatenate([np.broadcast_to(eye, rest.shape) for rest, eye in self._rest])
            by = np.repeat(np.arange(len(self._rest)), [len(rest) for rest, _ in self._rest])
            views = [view.id for view in self._views]
            surfaces, more = find_surfaces(points, eyes, self._noise)
            notes += more
            moment = self._views[-1].id
            for number, surface in enumerate(surfaces, 1):
                region = SurfaceRegion(np.round(surface.polygon, DECIMALS))
                name = f"{moment}_s{number}"
                seen = tuple(views[index] for index in np.unique(by[surface.members]))
                objects.append(SpatialObject(name, (Label(surface.name),), "surface", region, seen))
        return Scene(self.name, tuple(objects), tuple(self._views), self.thresholds, tuple(notes))


def _some(points: Array) -> Array:
    """Return as many points as it takes to see where a thing is."""
    return points[:: -(-len(points) // FEW)]


def perceive(
    frames: Iterable[Frame | CloudFrame], name: str = "map", thresholds: Thresholds | None = None
) -> Scene:
    """Return the scene that frames show together."""
    result = Map(name, thresholds)
    for frame in sorted(frames, key=lambda one: one.stamp):
        result.add(frame)
    return result.scene()
