"""Where PostGIS cannot do what an axiom says: each case in numbers, what it answers, and what is right.

A case is asked anew each time; nothing of it is written down but what is right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import psycopg
from psycopg.sql import SQL

from deixis.postgis.functions import names

Box = tuple[Sequence[float], Sequence[float], float]
"""Centre, size and yaw, as in a scene file."""

_BOX = (
    "pg_temp.raised(pg_temp.rectangle(-0.5 * %({0}sx)s, -0.5 * %({0}sy)s, 0.5 * %({0}sx)s, 0.5 * %({0}sy)s,"
    " %({0}yaw)s, %({0}x)s, %({0}y)s), %({0}z)s - 0.5 * %({0}sz)s, %({0}sz)s)"
)


@dataclass(frozen=True)
class Case:
    """One thing that goes wrong.

    Attributes
    ----------
    row : str
        Of Table 1(a).
    what : str
        What is given, in words.
    boxes : sequence of Box
        A, and perhaps B.
    question : str
        The expression that is asked, with A and B in braces.
    right : str
        What the axiom says, and why.
    """

    row: str
    what: str
    boxes: Sequence[Box]
    question: str
    right: str

    def answer(self, connection: psycopg.Connection[Any]) -> str:
        """Return what the server says, or the beginning of its complaint."""
        values: dict[str, float] = {}
        for name, (center, size, yaw) in zip("ab", self.boxes, strict=False):
            values |= dict(zip((f"{name}{axis}" for axis in "xyz"), center, strict=True))
            values |= dict(zip((f"{name}s{axis}" for axis in "xyz"), size, strict=True))
            values[f"{name}yaw"] = yaw
        solids = {name.upper(): SQL(_BOX.replace("{0}", name)) for name in "ab"[: len(self.boxes)]}
        asked = SQL("SELECT {}").format(SQL(self.question).format(**solids, **names(connection)))
        try:
            with connection.transaction():
                row = connection.execute(asked, values).fetchone()
        except psycopg.errors.InternalError_ as error:
            return f"error: {str(error).partition(' : ')[0]}"
        assert row is not None
        if row[0] is None:
            return "null"
        return str(row[0]).lower() if isinstance(row[0], bool) else f"{row[0]:.9g}"

    def asked(self) -> str:
        """Return the question as people write it."""
        spelt = self.question.replace("{extrude}", "ST_Extrude").replace("{makesolid}", "ST_MakeSolid")
        spelt = spelt.replace("{volume}", "ST_Volume").replace("{intersection}", "ST_3DIntersection")
        return spelt.replace("{A}", "A").replace("{B}", "B")

    def given(self) -> str:
        """Return the boxes in numbers."""
        told = []
        for name, (center, size, yaw) in zip("AB", self.boxes, strict=False):
            numbers = [", ".join(f"{value!r}" for value in part) for part in (center, size)]
            told.append(
                f"{name}: centre ({numbers[0]}), size ({numbers[1]})" + (f", yaw {yaw!r}" if yaw else "")
            )
        return "; ".join(told)


_TURN, _OFF = 1.5, 0.09
_BESIDE = (
    0.5 + 0.5 * (0.9 + 0.7) * math.cos(_TURN) - _OFF * math.sin(_TURN),
    -0.2 + 0.5 * (0.9 + 0.7) * math.sin(_TURN) + _OFF * math.cos(_TURN),
    0.5,
)

_REFUSED = (
    (
        (-2.738816140901986, 0.44682180369712804, -0.5286641871211113),
        (0.8897845462925174, 0.7618079969359866, 0.6586716257577772),
        -4.388364674152634,
    ),
    (
        (-2.0748010069637175, 0.4570763879819366, -0.5603908319869784),
        (0.723106338217961, 0.6104966634783672, 0.5952183360260432),
        -3.268978880377018,
    ),
)

_HULL = "ST_GeomFromText(ST_AsText({0}))"
"""A polyhedron as the semantic map keeps it: without the mark of a solid, which no format carries."""

CASES = (
    Case(
        "Min Oriented BBox",
        "points at (2, 0), (2, 4), (4, 2) and (1, 3): the area of their envelope",
        (),
        "round(ST_Area(ST_OrientedEnvelope('MULTIPOINT(2 0, 2 4, 4 2, 1 3)'::geometry))::numeric, 6)::float8",
        "8, since axiom 10 asks for the least volume, GEOS before 3.12 takes the least width",
    ),
    Case(
        "Min Oriented BBox",
        "the convex hull as a polyhedron",
        (((0, 0, 0.5), (1, 1, 1), 0.0),),
        "ST_OrientedEnvelope({A})",
        "its rectangle: the operator has to be given the hull's corners (ST_Points)",
    ),
    Case(
        "Reference object set",
        "a sheet of a square metre without thickness: its volume",
        (),
        "{volume}({makesolid}({extrude}(ST_MakeEnvelope(-0.5, -0.5, 0.5, 0.5), 0, 0, 0)))",
        "D times its area (decision 0009): it has to be made D thick first",
    ),
    Case(
        "Touches",
        "two boxes that share a face, turned",
        (((0.5, -0.2, 0.5), (0.9, 0.6, 0.2), _TURN), (_BESIDE, (0.7, 0.4, 0.4), _TURN)),
        "ST_3DDWithin({A}, {B}, 0)",
        "true; the gap is rounding, hence the contact band (decision 0004)",
    ),
    Case(
        "Touches",
        "a cup 1 cm above a table",
        (((0, 0, 0.81), (0.1, 0.1, 0.1), 0.0), ((0, 0, 0.375), (1, 1, 0.75), 0.0)),
        "ST_3DDWithin({A}, {B}, 0)",
        "true, since a gap up to D is contact",
    ),
    Case(
        "Int",
        "a cup that its sensor saw 5 mm deep in the table",
        (((0, 0, 0.795), (0.1, 0.1, 0.1), 0.0), ((0, 0, 0.375), (1, 1, 0.75), 0.0)),
        "ST_3DIntersects({A}, {B})",
        "false, since an overlap up to P is contact",
    ),
    Case(
        "Int",
        "a jar within a cabinet, both as the hulls that are stored",
        (((0, 0, 1), (0.2, 0.2, 0.3), 0.0), ((0, 0, 1), (1, 0.8, 2), 0.0)),
        f"ST_3DIntersects({_HULL.format('{A}')}, {_HULL.format('{B}')})",
        "true: a stored polyhedron is a surface until ST_MakeSolid makes a solid of it",
    ),
    Case(
        "IsClose",
        "the same jar and cabinet: their distance",
        (((0, 0, 1), (0.2, 0.2, 0.3), 0.0), ((0, 0, 1), (1, 0.8, 2), 0.0)),
        f"ST_3DDistance({_HULL.format('{A}')}, {_HULL.format('{B}')})",
        "0, for the same reason",
    ),
    Case(
        "IsClose",
        "two rods in one place: their distance",
        (((0, 0, 0), (0.1, 0, 0), 0.0), ((0, 0, 0), (0.1, 0, 0), 0.0)),
        "ST_3DDistance({A}, {B})",
        "0, so near; ST_3DDWithin says false of them at any distance",
    ),
    Case(
        "inter",
        "two of the random boxes",
        _REFUSED,
        "round({volume}({intersection}({A}, {B}))::numeric, 9)::float8",
        "0.032384855 m3; rounded to float64 the faces of what ST_3DIntersection returns cut themselves",
    ),
    Case(
        "ComplCont",
        "a jar that sticks out of a cabinet by 5 mm: its volume less that of the intersection",
        (((0.405, 0, 1), (0.2, 0.2, 0.3), 0.0), ((0, 0, 1), (1, 0.8, 2), 0.0)),
        "round(({volume}({A}) - {volume}({intersection}({A}, {B})))::numeric, 9)::float8",
        "contained, since up to D is within (decision 0009)",
    ),
)
