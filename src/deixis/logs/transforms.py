"""Transforms: where frames of a robot were at a moment, by chains of what was told of each (tf).

Each frame has a parent and, at some stamps, a pose in it. Between two stamps the pose is interpolated: the
place along the line, the turn along the shortest way. Before the first and after the last nothing is known,
unless one may hold the nearest pose for a while. A static pose holds at any time.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from deixis.frames import Array
from deixis.strict_json import quoted
from deixis.thresholds import MAX_COORDINATE

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

CACHE: Final = 30 * 10**9
"""Nanoseconds before the latest pose of a frame for which earlier ones are kept."""

UNIT_WITHIN: Final = 0.01
"""How far a quaternion's length may be from one, as tf2 has it."""

_DEEPEST: Final = 100
"""Frames between a frame and its root; more are a loop."""

_LOOP: Final = "tf has a loop"


class Pose(NamedTuple):
    """A place, metres, and a turn."""

    position: Array
    turn: Rotation

    def after(self, inner: Pose) -> Pose:
        """Return the pose in the outer frame of what has the pose ``inner`` in this one."""
        return Pose(self.position + self.turn.apply(inner.position), self.turn * inner.turn)

    def inverse(self) -> Pose:
        """Return the pose of the outer frame in this one."""
        back = self.turn.inv()
        return Pose(-back.apply(self.position), back)


@dataclass(frozen=True, slots=True)
class Unknown:
    """That a pose is not known, and why: ``reason`` tells kinds apart, ``detail`` has frames and stamps."""

    reason: str
    detail: str


Step = tuple[str, Pose | None]
"""A frame, and the pose in it of the frame before it in a chain."""


@dataclass(slots=True)
class _Track:
    """Poses of one frame in its parents, by stamp."""

    stamps: list[int] = field(default_factory=list)
    parents: list[str] = field(default_factory=list)
    poses: list[tuple[Array, Array]] = field(default_factory=list)


def unit(quaternion: Sequence[float]) -> Array | None:
    """Return a quaternion x, y, z, w with length one; None where it is no turn.

    Examples
    --------
    >>> unit([0.0, 0.0, 0.0, 1.001]).tolist(), unit([0.0, 0.0, 0.0, 0.0])
    ([0.0, 0.0, 0.0, 1.0], None)
    """
    given = np.array(quaternion, dtype=np.float64)
    # No number, and none so large that its square is none, is at most two.
    length = float(np.sqrt(given @ given)) if (np.abs(given) <= 2.0).all() else 0.0
    return given / length if abs(length - 1.0) <= UNIT_WITHIN else None


def frame_name(name: str) -> str:
    """Return a frame's name as tf2 has it: without the slash that ROS 1 puts in front.

    Examples
    --------
    >>> frame_name("/map")
    'map'
    """
    return name.removeprefix("/")


def seconds(stamp: int) -> str:
    """Return a stamp in nanoseconds as seconds, exactly.

    Examples
    --------
    >>> seconds(1_700_000_000_000_000_001)
    '1700000000.000000001'
    """
    return f"{'-' if stamp < 0 else ''}{abs(stamp) // 10**9}.{abs(stamp) % 10**9:09d}"


class Transforms:
    """What is known of frames.

    Parameters
    ----------
    hold : int
        Nanoseconds before the first and after the last pose of a frame for which that pose counts.

    Examples
    --------
    >>> known = Transforms()
    >>> for stamp, x in ((0, 0.0), (10, 1.0)):
    ...     known.tell("base", "map", stamp, [x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    True
    True
    >>> known.pose("base", "map", 4).position.tolist()
    [0.4, 0.0, 0.0]
    >>> known.pose("base", "map", 11).reason
    'tf does not reach the stamp'
    """

    def __init__(self, hold: int = 0) -> None:
        self._hold = hold
        self._tracks: dict[str, _Track] = {}
        self._static: dict[str, tuple[str, Array, Array]] = {}

    def tell(
        self,
        child: str,
        parent: str,
        stamp: int,
        position: Sequence[float],
        quaternion: Sequence[float],
        *,
        static: bool = False,
    ) -> bool:
        """Take in the pose of a frame in its parent; return whether it is one.

        Parameters
        ----------
        child, parent : str
        stamp : int
            Nanoseconds; of a static pose without meaning.
        position : x, y, z
            Metres.
        quaternion : x, y, z, w
        static : bool
        """
        turn, place = unit(quaternion), np.array(position, dtype=np.float64)
        if turn is None or not (np.abs(place) <= MAX_COORDINATE).all():
            return False
        if child == parent or not child or not parent:
            return False
        if static:
            self._static[child] = parent, place, turn
            return True
        track = self._tracks.setdefault(child, _Track())
        at = bisect_left(track.stamps, stamp)
        if at < len(track.stamps) and track.stamps[at] == stamp:
            track.parents[at], track.poses[at] = parent, (place, turn)
        else:
            track.stamps.insert(at, stamp)
            track.parents.insert(at, parent)
            track.poses.insert(at, (place, turn))
        # One before the time that counts stays, to interpolate from; cut rarely, since it costs a copy.
        old = bisect_right(track.stamps, track.stamps[-1] - CACHE) - 1
        if old > len(track.stamps) // 2:
            del track.stamps[:old], track.parents[:old], track.poses[:old]
        return True

    def pose(self, frame: str, within: str, stamp: int) -> Pose | Unknown:
        """Return the pose of a frame in another at a stamp, or why it is not known."""
        if frame == within:
            from scipy.spatial.transform import Rotation

            return Pose(np.zeros(3), Rotation.identity())
        up, why = self._chain(frame, stamp, within)
        if up[-1][0] == within:
            return _composed(up)
        down, why_not = self._chain(within, stamp, up[-1][0])
        loop = next((one for one in (why, why_not) if one is not None and one.reason == _LOOP), None)
        if loop is not None:
            return loop  # where the two meet is on a way that was gone round many times
        passed = {name: at for at, (name, _) in enumerate(up)}
        meeting = next((at for at, (name, _) in enumerate(down) if name in passed), None)
        if meeting is not None:
            rise = up[: passed[down[meeting][0]] + 1]
            return _composed(down[: meeting + 1]).inverse().after(_composed(rise))
        return (
            why
            or why_not
            or Unknown(
                f"tf does not connect {quoted(frame)} and {quoted(within)}",
                f"{quoted(frame)} hangs on {quoted(up[-1][0])}, {quoted(within)} on {quoted(down[-1][0])}, "
                f"at {seconds(stamp)}",
            )
        )

    def _chain(self, frame: str, stamp: int, until: str) -> tuple[list[Step], Unknown | None]:
        """Return a frame and those it hangs on, as far as known, and what keeps it from going on."""
        found: list[Step] = [(frame, None)]
        while found[-1][0] != until:
            link = self._link(found[-1][0], stamp)
            if link is None or isinstance(link, Unknown):
                return found, link
            if len(found) > _DEEPEST:
                return found, Unknown(_LOOP, f"above {quoted(frame)} at {seconds(stamp)}")
            found.append(link)
        return found, None

    def _link(self, child: str, stamp: int) -> tuple[str, Pose] | Unknown | None:
        """Return the parent of a frame and the pose in it; None where it has none."""
        track = self._tracks.get(child)
        if track is None:
            still = self._static.get(child)
            return None if still is None else (still[0], _pose(still[1], still[2]))
        at = bisect_left(track.stamps, stamp)
        first, last = track.stamps[0], track.stamps[-1]
        if at < len(track.stamps) and track.stamps[at] == stamp:
            return track.parents[at], _pose(*track.poses[at])
        if 0 < at < len(track.stamps):
            return self._between(child, track, at, stamp)
        near = 0 if at == 0 else len(track.stamps) - 1
        if abs(stamp - track.stamps[near]) <= self._hold:
            return track.parents[near], _pose(*track.poses[near])
        return Unknown(
            "tf does not reach the stamp",
            f"{quoted(child)} in {quoted(track.parents[near])} is known from {seconds(first)} to "
            f"{seconds(last)}, not at {seconds(stamp)}",
        )

    def _between(self, child: str, track: _Track, at: int, stamp: int) -> tuple[str, Pose] | Unknown:
        from scipy.spatial.transform import Rotation, Slerp

        start, end = track.stamps[at - 1], track.stamps[at]
        if track.parents[at - 1] != track.parents[at]:
            return Unknown(
                "a frame changes its parent",
                f"{quoted(child)} goes from {quoted(track.parents[at - 1])} to {quoted(track.parents[at])} "
                f"between {seconds(start)} and {seconds(end)}",
            )
        (place, turn), (place_after, turn_after) = track.poses[at - 1], track.poses[at]
        part = (stamp - start) / (end - start)
        slerp = Slerp([0.0, 1.0], Rotation.from_quat(np.stack([turn, turn_after])))
        return track.parents[at], Pose(place + part * (place_after - place), slerp(part))


def _pose(place: Array, turn: Array) -> Pose:
    from scipy.spatial.transform import Rotation

    return Pose(place, Rotation.from_quat(turn))


def _composed(chain: Sequence[Step]) -> Pose:
    """Return the pose of a chain's first frame in its last."""
    from scipy.spatial.transform import Rotation

    result = Pose(np.zeros(3), Rotation.identity())
    for _, pose in chain:
        if pose is not None:
            result = pose.after(result)
    return result
