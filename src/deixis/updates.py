"""Updates: what is told of a scene that changes, and what that changes in what holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any, Final

from deixis.consequences import Consequence, Consequences
from deixis.counterfactual import moved_things
from deixis.errors import QueryError, SceneError
from deixis.relations import Relation
from deixis.scene import Scene, SpatialObject, View
from deixis.strict_json import quoted
from deixis.things import view_values

_KEYS: Final = ("stamp", "objects", "moves", "removed", "views", "removed_views")


@dataclass(frozen=True)
class Update:
    """What is told of a scene at once.

    Attributes
    ----------
    objects : tuple of SpatialObject
        They replace those with their ids, or are new.
    removed : tuple of str
        Ids of objects that are there no more.
    views : tuple of View
        They replace those with their ids, or are new.
    removed_views : tuple of str
        Ids of views from which nobody looks any more.
    stamp : float or None
        Seconds since the epoch, or any other count; given back with the changes.

    Raises
    ------
    SceneError
        The stamp is not a finite number.
    """

    objects: tuple[SpatialObject, ...] = ()
    removed: tuple[str, ...] = ()
    views: tuple[View, ...] = ()
    removed_views: tuple[str, ...] = ()
    stamp: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamp", _stamp(self.stamp))

    @classmethod
    def from_dict(cls, data: object, scene: Scene) -> Update:
        """Return the update described by JSON values.

        Parameters
        ----------
        data : dict
            ``objects`` and ``views`` as in scene format v1; ``moves``, from ids to x, y, z in metres by
            which things are shifted; ``removed`` and ``removed_views``, lists of ids; ``stamp``.
        scene : Scene
            What is updated.

        Raises
        ------
        SceneError
            Anything is unknown or of the wrong kind; the message names it.

        Examples
        --------
        >>> cup = {"id": "cup", "box": {"center": [0, 0, 1], "size": [0.1, 0.1, 0.1]}}
        >>> scene = Scene.from_dict({"deixis": 1, "id": "s", "objects": [cup]})
        >>> Update.from_dict({"moves": {"cup": [0, 0, -1]}}, scene).objects[0].region.center.tolist()
        [0.0, 0.0, 0.0]
        """
        if not isinstance(data, Mapping):
            raise SceneError("an update is a JSON object: give objects, moves, removed, views, removed_views")
        unknown = next((key for key in data if key not in _KEYS), None)
        if unknown is not None:
            raise SceneError(f"an update has no key {quoted(unknown)}: known are {', '.join(_KEYS)}")
        views: tuple[View, ...] = ()
        if "views" in data:
            views = Scene.from_dict({"deixis": 1, "id": scene.id, "views": data["views"]}).views
        objects: tuple[SpatialObject, ...] = ()
        if "objects" in data:
            # An object may have been seen in any view, the new ones and those there were.
            seen = [*views, *(view for view in scene.views if view.id not in {one.id for one in views})]
            told = {"objects": data["objects"], "views": list(map(view_values, seen))}
            objects = Scene.from_dict({"deixis": 1, "id": scene.id, **told}).objects
        moves = data.get("moves", {})
        if not isinstance(moves, Mapping):
            raise SceneError("moves is no JSON object: give x, y, z in metres for each id")
        return cls(
            (*objects, *moved_things(scene, moves)),
            _ids(data, "removed"),
            views,
            _ids(data, "removed_views"),
            data.get("stamp"),
        )

    def applied(self, scene: Scene) -> Scene:
        """Return the scene as it is then.

        Raises
        ------
        SceneError
            What is to be removed is not there, or something is told twice.
        """
        views = {view.id: view for view in scene.views}
        missing = next((name for name in self.removed_views if name not in views), None)
        if missing is not None:
            raise SceneError(f"scene {quoted(scene.id)} has no view {quoted(missing)}: give one it has")
        both = next((view.id for view in self.views if view.id in self.removed_views), None)
        if both is not None:
            raise SceneError(f"view {quoted(both)} is both given and removed: leave out one")
        views |= {view.id: view for view in self.views}
        kept = [view for view in views.values() if view.id not in self.removed_views]
        return scene.changed(objects=self._seen(scene), removed=self.removed, views=kept)

    def _seen(self, scene: Scene) -> list[SpatialObject]:
        """Return the objects given, and those that were seen in a view that is removed, without that view."""
        gone = set(self.removed_views)
        if not gone:
            return list(self.objects)
        told = self.things
        others = [one for one in scene.objects if one.id not in told and not gone.isdisjoint(one.seen_in)]
        return [
            replace(one, seen_in=tuple(view for view in one.seen_in if view not in gone))
            for one in (*self.objects, *others)
        ]

    @property
    def things(self) -> frozenset[str]:
        """Return the ids of all objects that it tells of."""
        return frozenset([*(thing.id for thing in self.objects), *self.removed])


Reasons = Callable[[Sequence[Relation], float], list[str]]
"""Gives the reason of each of some relations, each in so many seconds at most."""


@dataclass(frozen=True)
class Changes:
    """What an update changed.

    Attributes
    ----------
    stamp : float or None
        Of the update.
    gained, lost : tuple of Relation
        What holds now and did not, and what held and does not now, with the margin that it has or had.
    """

    stamp: float | None
    gained: tuple[Relation, ...]
    lost: tuple[Relation, ...]
    _reasons: Reasons | None = field(default=None, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        """Return what another process is given: reasons are asked of engines, which stay in this one."""
        return {**self.__dict__, "_reasons": None}

    def because(self, one: Relation, *, timeout: float = 10.0) -> str:
        """Return why a relation holds from this update on, or what it lacks, in a sentence.

        The answer is that of the scene just after the update, whenever it is asked for: soon after, by the
        knowledge base's own engine; when the scene has changed again, by another one, which takes longer.

        Raises
        ------
        QueryError
            The relation is none of these, or the changes are a copy, perhaps from another process.
        QueryTimeout
            It took longer than ``timeout`` seconds.
        """
        if one not in self.gained and one not in self.lost:
            raise QueryError(f"{one.to_prolog()} is not among these changes: ask for one gained or lost")
        return self._told([one], timeout)[0]

    def explained(self, *, limit: int | None = None, timeout: float = 10.0) -> Consequences:
        """Return the changes, each with its reason, those that are gained first.

        Parameters
        ----------
        limit : int, optional
            At most so many.
        timeout : float
            Seconds for each reason.

        Raises
        ------
        QueryError
            The changes are a copy, perhaps from another process.
        QueryTimeout
            A reason took longer.
        """
        every = [*self.gained, *self.lost]
        some = every[: len(every) if limit is None else limit]
        told = [Consequence(*pair) for pair in zip(some, self._told(some, timeout), strict=True)]
        cut = len(self.gained)
        return Consequences(tuple(told[:cut]), tuple(told[cut:]), len(some) < len(every))

    def _told(self, some: Sequence[Relation], timeout: float) -> list[str]:
        if self._reasons is None:
            raise QueryError("these changes are a copy: ask those that the update gave, in their process")
        return self._reasons(some, timeout) if some else []

    def __bool__(self) -> bool:
        return bool(self.gained or self.lost)

    def to_dict(self) -> dict[str, Any]:
        """Return the changes as JSON values."""
        told = {
            "gained": [one.to_dict() for one in self.gained],
            "lost": [one.to_dict() for one in self.lost],
        }
        return told if self.stamp is None else {"stamp": self.stamp, **told}


def _stamp(given: Any) -> float | None:
    """Return a stamp as a number, if it is one."""
    if given is None:
        return None
    try:
        stamp = math.nan if isinstance(given, bool) or not isinstance(given, Real) else float(given)
    except OverflowError:
        stamp = math.inf
    if not math.isfinite(stamp):
        raise SceneError(f"the stamp {quoted(given)} is not a finite number: give seconds since the epoch")
    return stamp


def _ids(data: Mapping[str, Any], key: str) -> tuple[str, ...]:
    found = data.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
        raise SceneError(f"{key} is not a list of ids: give those of what is there no more")
    return tuple(found)
