"""Moments: times as people write and read them, to and from seconds since the epoch."""

from __future__ import annotations

import math
from datetime import UTC, datetime, time, tzinfo

from deixis.errors import MapError
from deixis.strict_json import quoted


def seconds(text: str, *, day: float | None = None) -> float:
    """Return a time that a user wrote as seconds since the epoch; without a zone it is UTC.

    Parameters
    ----------
    text : str
        A number, ``2026-11-22T10:42:00Z``, or a time of day such as ``10:42`` or ``10:42:05+01:00``.
    day : float, optional
        A moment of the day that a time of day is of, in the zone it is written in.

    Raises
    ------
    MapError
        It is no time, or a time of day where no day is known.

    Examples
    --------
    >>> seconds("2026-11-22T10:42:00Z"), seconds("12.5"), seconds("10:42", day=1795400000.0)
    (1795344120.0, 12.5, 1795430520.0)
    """
    try:
        number = float(text)
    except ValueError:
        pass
    else:
        if math.isfinite(number):
            return number
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        moment = _of_day(text, day)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _of_day(text: str, day: float | None) -> datetime:
    try:
        clock = time.fromisoformat(text)
    except ValueError:
        raise MapError(
            f"{quoted(text)} is no time: give seconds since the epoch, 2026-11-22T10:42:00Z, or 10:42"
        ) from None
    date = None if day is None else _datetime(day, clock.tzinfo or UTC)
    if date is None:
        raise MapError(f"{quoted(text)} is a time of no certain day: give it as 2026-11-22T10:42:00Z")
    return datetime.combine(date.date(), clock)


def moment(stamp: float) -> str:
    """Return seconds since the epoch as programs read them; what is beyond the calendar as it is.

    Examples
    --------
    >>> moment(1795344120.25), moment(100.0006), moment(1795344120250.0)
    ('2026-11-22T10:42:00.250Z', '1970-01-01T00:01:40.000600Z', '1795344120250.0')
    """
    found = _datetime(stamp, UTC)
    if found is None:
        return repr(stamp)
    # Cut short, it would be a time before the one that is meant.
    precise = "microseconds" if found.microsecond % 1000 else "milliseconds"
    return found.isoformat(timespec=precise).replace("+00:00", "Z")


def spoken(stamp: float) -> str:
    """Return seconds since the epoch as people read them.

    Examples
    --------
    >>> spoken(1795344125.0), spoken(1795344125.25), spoken(1e300)
    ('2026-11-22 10:42:05 UTC', '2026-11-22 10:42:05.250 UTC', '1e+300 s')
    """
    found = _datetime(round(stamp, 3), UTC)
    if found is None:
        return f"{stamp!r} s"
    precise = "milliseconds" if found.microsecond else "seconds"
    return found.replace(tzinfo=None).isoformat(" ", precise) + " UTC"


def exact(stamp: float) -> str | None:
    """Return seconds since the epoch as an ``xsd:dateTimeStamp``; None where the calendar has no such time.

    Examples
    --------
    >>> exact(1795344125.0), exact(1e300)
    ('2026-11-22T10:42:05Z', None)
    """
    found = _datetime(stamp, UTC)
    return None if found is None else found.isoformat().replace("+00:00", "Z")


def duration(length: float) -> str:
    """Return how long something took, in its two largest units.

    Examples
    --------
    >>> duration(1080.0), duration(97230.0), duration(61.0), duration(0.25)
    ('18 minutes', '1 day 3 hours', '1 minute 1 second', '0.25 seconds')
    """
    if length < 1.0:
        return f"{length:.3g} seconds"
    parts: list[tuple[int, str]] = []
    rest = round(length)
    for size, unit in ((86400, "day"), (3600, "hour"), (60, "minute"), (1, "second")):
        count, rest = divmod(rest, size)
        if count or parts:
            parts.append((count, unit))
    return " ".join(f"{count} {unit}{'' if count == 1 else 's'}" for count, unit in parts[:2] if count)


def _datetime(stamp: float, zone: tzinfo) -> datetime | None:
    try:
        return datetime.fromtimestamp(stamp, zone)
    except (ValueError, OverflowError, OSError):
        return None
