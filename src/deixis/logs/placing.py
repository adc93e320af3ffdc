"""Placing: detections of any frame as regions in the fixed frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from deixis.frames import Array
from deixis.logs.boxes import EXACT, turned_box
from deixis.logs.detections import Detection, faults
from deixis.logs.report import Report
from deixis.logs.transforms import Transforms, Unknown, seconds, unit
from deixis.regions import Region
from deixis.strict_json import quoted
from deixis.thresholds import MAX_COORDINATE

_STOOD: Final = "a box is tilted: it is stood upright"
_TILTED: Final = "a box is tilted: relations of boxes are those of the upright box around it"

_UNTURNED: Final = np.array([0.0, 0.0, 0.0, 1.0])


class Placing:
    """Places detections.

    Parameters
    ----------
    known : Transforms
    frame : str
        The fixed frame.
    level : float
        Degrees: a box tilted by no more is stood upright.
    report : Report
        Told what is left out, and what is taken in otherwise than it was told.
    """

    def __init__(self, known: Transforms, frame: str, level: float, report: Report) -> None:
        self._known, self._frame, self._report = known, frame, report
        self._level = math.radians(level)

    def regions(self, found: Sequence[Detection]) -> list[Region | None]:
        """Return the regions of what one message shows; None for what is left out."""
        result: list[Region | None] = [None] * len(found)
        turns = np.empty((len(found), 4))
        groups: dict[tuple[str, int], list[int]] = {}
        for at, one in enumerate(found):
            turn = self._turn(one, f"detection {at} of {seconds(one.stamp)}")
            if turn is not None:
                turns[at] = turn
                groups.setdefault((one.frame, one.stamp), []).append(at)
        for (frame, stamp), group in groups.items():
            self._place(frame, stamp, group, found, turns, result)
        return result

    def _turn(self, one: Detection, where: str) -> Array | None:
        fault = faults(one, MAX_COORDINATE)
        turn = None
        if fault is None and not any(one.quaternion):
            self._report.note("a box has no orientation, 0 0 0 0: it counts as unturned in its frame", where)
            turn = _UNTURNED
        elif fault is None:
            turn = unit(one.quaternion)
            fault = None if turn is not None else "a quaternion is not of length one"
        if fault is not None:
            self._report.skip(fault, where)
        return turn

    def _place(
        self,
        frame: str,
        stamp: int,
        group: Sequence[int],
        found: Sequence[Detection],
        turns: Array,
        result: list[Region | None],
    ) -> None:
        from scipy.spatial.transform import Rotation

        if not frame:
            self._report.skip("no frame is named", f"at {seconds(stamp)}", len(group))
            return
        pose = self._known.pose(frame, self._frame, stamp)
        if isinstance(pose, Unknown):
            self._report.skip(pose.reason, pose.detail, len(group))
            return
        centers = pose.position + pose.turn.apply([found[at].center for at in group])
        matrices = (pose.turn * Rotation.from_quat(turns[list(group)])).as_matrix()
        reach = 0.5 * np.linalg.norm([found[at].size for at in group], axis=1)
        far = np.abs(centers).max(axis=1) + reach > MAX_COORDINATE
        for at, center, matrix, beyond in zip(group, centers, matrices, far.tolist(), strict=True):
            if beyond:
                self._report.skip(
                    f"it is beyond {MAX_COORDINATE:g} m in {quoted(self._frame)}", seconds(stamp)
                )
                continue
            region, tilt = turned_box(center, matrix, np.array(found[at].size), self._level)
            result[at] = region
            if tilt > EXACT:
                self._report.note(
                    _STOOD if tilt <= self._level else _TILTED,
                    f"by {math.degrees(tilt):.2f} degrees at {seconds(stamp)}",
                )
