"""Reports: what of a log was read, what was left out and why; nothing is left out in silence."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(slots=True)
class _Count:
    count: int
    first: str


@dataclass(slots=True)
class Report:
    """What became of what a log shows.

    Attributes
    ----------
    frames : int
        Moments that were read.
    detections : int
        Detections in them that became things.
    first, last : int or None
        Stamps of the first and the last of the moments, nanoseconds.
    """

    frames: int = 0
    detections: int = 0
    first: int | None = None
    last: int | None = None
    _skipped: dict[str, _Count] = field(default_factory=dict)
    _notes: dict[str, _Count] = field(default_factory=dict)

    def skip(self, reason: str, detail: str, count: int = 1) -> None:
        """Count what is left out; the detail of the first of each reason is kept."""
        self._skipped.setdefault(reason, _Count(0, detail)).count += count

    def note(self, what: str, detail: str, count: int = 1) -> None:
        """Count what is taken in otherwise than it was told."""
        self._notes.setdefault(what, _Count(0, detail)).count += count

    @property
    def skipped(self) -> dict[str, int]:
        """Return how many were left out, by the reason."""
        return {reason: one.count for reason, one in self._skipped.items()}

    def lines(self) -> list[str]:
        """Return a sentence on each reason.

        Examples
        --------
        >>> report = Report()
        >>> report.skip("a size is negative", "detection 3 of 1.000000000")
        >>> report.lines()
        ['1 left out: a size is negative (the first: detection 3 of 1.000000000)']
        """
        return [
            f"{one.count} {what}: {reason} (the first: {one.first})"
            for what, counts in (("left out", self._skipped), ("taken in, but", self._notes))
            for reason, one in counts.items()
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the report as JSON values."""
        listed = {
            key: [{"reason": reason, "count": one.count, "first": one.first} for reason, one in some.items()]
            for key, some in (("skipped", self._skipped), ("notes", self._notes))
        }
        return {"frames": self.frames, "detections": self.detections, **listed}
