"""Evidence: what a leaf of a proof rests on, as numbers with names and as geometry to be shown.

:mod:`deixis.leaves` gathers it; here is what it is made of, and how what was measured is called.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from deixis.facts import SolidModel

Unit = Literal["m", "m3", "1"]
"""Metres, cubic metres, or none."""

Point = tuple[float, float, float]
"""Metres, or a direction, in the world frame."""


@dataclass(frozen=True, slots=True)
class Value:
    """A number with its name and unit, exact as it was measured or set."""

    name: str
    value: float
    unit: Unit


@dataclass(frozen=True, slots=True)
class Plane:
    """The bound of a halfspace that decides a fact: see :class:`deixis.bounds.Planes`.

    Attributes
    ----------
    point : (3,) float
        On it.
    normal : (3,) float
        Unit vector to where the fact holds.
    bound : {"face", "middle", "end", "side", "height"}
        Which of the halfspace's bounds it is.
    """

    point: Point
    normal: Point
    bound: str


@dataclass(frozen=True, slots=True)
class Witness:
    """What to light up in a picture.

    Attributes
    ----------
    things : tuple of str
        Ids, the figure first.
    points : pair of (3,) float, or None
        What is measured lies between them, metres, world frame. Of a separation the figure's point and the
        reference's; of a halfspace the figure's and the one below it in the plane.
    normal : (3,) float or None
        Unit vector from reference to figure along which the two are parted.
    plane : Plane or None
    view : str or None
        Id of the view that it is so in; None where it is so in every view.
    measured_as : mapping of str to str
        What points and plane were taken from, for each of the things: its box, hull, mesh or outline.
    """

    things: tuple[str, ...]
    points: tuple[Point, Point] | None = None
    normal: Point | None = None
    plane: Plane | None = None
    view: str | None = None
    measured_as: Mapping[str, SolidModel] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a leaf of a proof rests on.

    Attributes
    ----------
    values : tuple of Value
        What was measured.
    thresholds : tuple of Value
        What it was compared with.
    margin : float or None
        Metres to spare, negative where it fails; None where no length decides.
    witness : Witness or None
        None where there is nothing to be seen, such as of a threshold.
    """

    values: tuple[Value, ...] = ()
    thresholds: tuple[Value, ...] = ()
    margin: float | None = None
    witness: Witness | None = None

    @classmethod
    def from_dict(cls, node: Mapping[str, Any]) -> Evidence:
        """Return the evidence that :meth:`to_dict` gave as dicts."""
        seen = node["witness"]
        return cls(
            tuple(Value(**one) for one in node["values"]),
            tuple(Value(**one) for one in node["thresholds"]),
            node["margin"],
            None if seen is None else _witness(seen),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the evidence as nested dicts, ready for JSON.

        Examples
        --------
        >>> Evidence((Value("separation", 0.01, "m"),)).to_dict()["values"]
        [{'name': 'separation', 'value': 0.01, 'unit': 'm'}]
        """
        seen = self.witness
        return {
            "values": [_value(one) for one in self.values],
            "thresholds": [_value(one) for one in self.thresholds],
            "margin": self.margin,
            "witness": None
            if seen is None
            else {
                "things": list(seen.things),
                "points": None if seen.points is None else [list(point) for point in seen.points],
                "normal": None if seen.normal is None else list(seen.normal),
                "plane": None
                if seen.plane is None
                else {
                    "point": list(seen.plane.point),
                    "normal": list(seen.plane.normal),
                    "bound": seen.plane.bound,
                },
                "view": seen.view,
                "measured_as": dict(seen.measured_as),
            },
        }


def _witness(node: Mapping[str, Any]) -> Witness:
    points, plane = node["points"], node["plane"]
    return Witness(
        tuple(node["things"]),
        None if points is None else (_point(points[0]), _point(points[1])),
        None if node["normal"] is None else _point(node["normal"]),
        None if plane is None else Plane(_point(plane["point"]), _point(plane["normal"]), plane["bound"]),
        node["view"],
        dict(node["measured_as"]),
    )


def _point(values: Sequence[float]) -> Point:
    x, y, z = values
    return x, y, z


def _value(one: Value) -> dict[str, Any]:
    return {"name": one.name, "value": one.value, "unit": one.unit}


_PAIR: Final[tuple[tuple[str, Unit], ...]] = (
    ("distance", "m"),
    ("separation", "m"),
    ("protrusion", "m"),
    ("intersection", "m3"),
    ("frontier", "m3"),
    ("margin along Z+", "m"),
    ("margin along Z-", "m"),
)

_ASPECT: Final[tuple[tuple[str, Unit], ...]] = tuple(
    (f"margin along {axis}", "m") for axis in ("X+", "X-", "Y+", "Y-")
)

_LISTED: Final[Mapping[tuple[str, int], tuple[int, tuple[tuple[str, Unit], ...]]]] = {
    ("pair", 9): (2, _PAIR),
    ("aspect", 7): (3, _ASPECT),
    ("strict", 5): (4, (("strict margin", "m"),)),
    ("halfspace", 5): (4, (("margin", "m"),)),
    ("label", 3): (2, (("score", "1"),)),
}
"""Predicates with numbers: from which argument on they stand, and what they are."""

_VOLUMES: Final = frozenset({"intersection", "frontier", "adj_sr_card"})


def measured(predicate: str, args: tuple[str | float | None, ...]) -> tuple[Value, ...]:
    """Return the numbers that a step states, with their names; thresholds are no measurements.

    A rule's number is called as the rule is: what ``separation(cup, table, S)`` states is the separation.

    Examples
    --------
    >>> measured("separation", ("cup", "table", 0.01))
    (Value(name='separation', value=0.01, unit='m'),)
    """
    if predicate == "threshold":
        return ()
    start, names = _LISTED.get((predicate, len(args)), (0, ()))
    if names:
        found = zip(names, args[start:], strict=True)
        return tuple(
            Value(name, float(one), unit) for (name, unit), one in found if isinstance(one, int | float)
        )
    unit: Unit = "m3" if predicate in _VOLUMES else "m"
    return tuple(Value(predicate, float(one), unit) for one in args if isinstance(one, int | float))


def threshold(predicate: str, args: tuple[str | float | None, ...]) -> tuple[Value, ...]:
    """Return the threshold that a step states, if it states one.

    Examples
    --------
    >>> threshold("threshold", ("halfspace_scale", 1.2))
    (Value(name='halfspace_scale', value=1.2, unit='1'),)
    """
    if predicate != "threshold" or len(args) != 2:
        return ()
    name, value = args
    if not isinstance(name, str) or not isinstance(value, int | float):
        return ()
    return (Value(name, float(value), "1" if name == "halfspace_scale" else "m"),)
