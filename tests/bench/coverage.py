"""Table 1 of the paper, operator by operator: ``make coverage`` writes what is found to ``kb/coverage.md``.

    python -m bench.coverage [FILE]

Every number is found in this one run. All but the milliseconds is the same wherever PostGIS, GEOS and SFCGAL
are of the same versions.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import psycopg

from bench.coverage_cases import CASES
from bench.coverage_study import SPOKEN, Study, random_clouds, random_room
from bench.run import wrapped
from deixis.grounding import ground
from deixis.postgis import grounding as postgis
from deixis.scene import BoxRegion, Scene, SpatialObject
from postgis_server import postgis as server

ROOMS, THINGS, CLOUDS = 20, 50, 1_000
"""Twenty rooms of fifty boxes are a thousand."""


class Line(NamedTuple):
    """A line of Table 1(a): the paper's name and operators, what of ours it is beside, and its file."""

    name: str
    operators: str
    ours: str
    file: str = ""


TABLE_1A = {
    "box": Line(
        "Min Oriented BBox, of boxes", "OrientedEnvelope, ZMin, ZMax, Extrude", "`Scene.boxes`", "minimum_box"
    ),
    "cloud": Line("Min Oriented BBox, of clouds", "the same", "`Scene.boxes`"),
    "frame": Line("CBB", "Rotate, Angle, Centroid", "`boxes.contextualise`", "contextualised_box"),
    "upright": Line("Top/Bottom Halfspaces", "Extrude", "where they begin and end", "top_and_bottom"),
    "side": Line("L/R/Front/Back Halfspaces", "Extrude", "where they begin and end", "sides"),
    "volume": Line("Volume", "Volume", "`Facts.volume`", "reference_order"),
    "order": Line("Reference object set", "Volume", "`figure_reference/2`"),
    "close": Line("IsClose", "3DDWithin, T", "`is_close/2`", "near"),
    "touch": Line("Touches", "3DDWithin, 0", "`touches/2`"),
    "meet": Line("Int", "3DIntersects", "`intersects/2`", "overlap"),
    "inter": Line("inter", "3DIntersection, Volume", "`intersection/3`", "intersection"),
    "held": Line("CompletelyContains", "3DIntersection, Volume", "`compl_cont/2`", "containment"),
    "vertical": Line("Above, Below", "3DIntersects", "`above_r/2`, `below_r/2`", "above_and_below"),
    "horizontal": Line("LeftOf, RightOf, InFrontOf, Behind", "3DIntersects", "`int_hs/4`", "beside"),
    "part": Line("adjSRCard", "Scale, Intersection, Volume", "whose `adj_sr_card/3` is less", "frontier"),
}

FOLLOWS = (
    "RightOf, LeftOf",
    "Touches, Above",
    "Touches, Above, Below",
    "Touches, Above",
    "ComplCont",
    "inter, adjSRCard",
    "IsClose",
)
"""What each relation of Table 1(b) follows from, by the paper."""

WHY = {
    "frontier": "as of adjSRCard",
    "int_hs, where it does not": "where the cross-sections share nothing only the sign means anything",
    "cont_hs, where it does not": "the same",
}

CROSSED = Scene(
    "crossed",
    (
        SpatialObject("a", (), "object", BoxRegion([0.0, 0.0, 0.0], [0.8, 0.3, 0.5])),
        SpatialObject("b", (), "object", BoxRegion([0.0, 0.0, 0.1], [0.2, 0.7, 0.4], 0.7)),
    ),
)

INTRODUCTION = (
    "Written by `make coverage`; a test makes it anew and compares all but the milliseconds. Each row of "
    "Table 1(a) is a file of SQL that anyone can read. What it says is compared with what our kernel says of "
    "the same things, or pairs. The milliseconds are of the file, for each row that it makes, on a machine "
    "with other work. The functions of SFCGAL are spelt `ST_` before PostGIS 3.5 and `CG_` since; both are "
    "found."
)

THE_FACTS = (
    "`deixis.postgis.ground` returns the table that our kernel returns: the operators say what holds, and "
    "how far that is from changing is measured on the same geometry (decision 0048)."
)


def release(connection: psycopg.Connection[Any]) -> str:
    """Return the versions that the answers depend on."""
    (said,) = connection.execute("SELECT postgis_full_version()").fetchone() or ("",)
    found = dict(re.findall(r'(POSTGIS|GEOS|SFCGAL)="(?:SFCGAL )?([\d.]+)', said))
    return f"PostGIS {found['POSTGIS']}, GEOS {found['GEOS']}, SFCGAL {found['SFCGAL']}"


def operators(study: Study) -> Iterator[str]:
    """Yield Table 1(a)."""
    yield "| Table 1(a) | operators, `ST_` ... | ours | agree | of | ms each | in `postgis/sql/` |"
    yield "|---|---|---|--:|--:|--:|---|"
    for key, line in TABLE_1A.items():
        cost = f"{1000.0 * study.seconds[line.file] / max(study.made[line.file], 1):.2g}" if line.file else ""
        file = f"`{line.file}.sql`" if line.file else ""
        cells = (line.name, line.operators, line.ours, f"{study.agreed[key]:,}", f"{study.compared[key]:,}")
        yield f"| {' | '.join(cells)} | {cost} | {file} |"
    yield ""
    yield "What differs, by cause:"
    yield ""
    for key, line in TABLE_1A.items():
        for cause, count in study.causes[key].items():
            if count:
                yield f"* {line.name}, {count:,}: {cause}."


def relations(study: Study) -> Iterator[str]:
    """Yield Table 1(b)."""
    yield "| Table 1(b) | follows from | hold by our facts | by one of the two only |"
    yield "|---|---|--:|--:|"
    for name, follows in zip(SPOKEN, FOLLOWS, strict=True):
        yield f"| `{name}` | {follows} | {study.relations[name]:,} | {study.differing[name]:,} |"


def facts(study: Study) -> Iterator[str]:
    """Yield how the columns of the facts compare."""
    yield "| column | numbers | other than ours by more than a nanometre | why |"
    yield "|---|--:|--:|---|"
    for name, count in study.numbers.items():
        column, _, where = name.partition(", ")
        why = WHY.get(name, "") if study.other[name] else ""
        yield f"| `{column}`{', ' + where if where else ''} | {count:,} | {study.other[name]:,} | {why} |"


def cases(connection: psycopg.Connection[Any]) -> Iterator[str]:
    """Yield where PostGIS cannot do what an axiom says."""
    with postgis.session(connection) as session:
        postgis.load(session, Scene("none"))
        for case in CASES:
            yield f"* **{case.row}**: {case.what}. {case.given()}".rstrip()
            yield f"  `{case.asked()}` says {case.answer(session)}; right is {case.right}."
    one = postgis.ground(connection, CROSSED)
    mine = ground(CROSSED)
    (a, b), (ours, back) = one.frontier.tolist(), mine.frontier.tolist()
    yield (
        "* **adjSRCard**: two bars that cross. A: centre (0, 0, 0), size (0.8, 0.3, 0.5); "
        "B: centre (0, 0, 0.1), size (0.2, 0.7, 0.4), yaw 0.7"
    )
    yield (
        f"  `frontier.sql` says {a:.5f} m3 of A and {b:.5f} m3 of B, so A is partly in B; right is "
        f"{ours:.5f} and {back:.5f}, so B is partly in A: ST_Scale moves a slanting face by another distance "
        "than a square one."
    )


def text(connection: psycopg.Connection[Any], rooms: int, things: int, clouds: int) -> str:
    """Return the whole text."""
    study = Study(connection)
    study.look_at_clouds(random_clouds(clouds))
    for seed in range(rooms):
        study.look(random_room(things, seed))
    scope = f"{rooms} rooms of {things} boxes with a view each, a floor and two walls among them"
    sections = (
        ("# Coverage: Table 1 of the paper, operator by operator", [*wrapped(iter([INTRODUCTION]))]),
        ("## The operators", [f"{release(connection)}. {scope}; {clouds:,} clouds.", "", *operators(study)]),
        ("## The facts", [*wrapped(iter([THE_FACTS])), "", *facts(study)]),
        ("## What follows", ["The same rules, on the facts of either.", "", *relations(study)]),
        ("## Where PostGIS cannot do what an axiom says", [*cases(connection)]),
    )
    return "\n\n".join("\n".join([title, "", *content]) for title, content in sections) + "\n"


def without_times(written: str) -> str:
    """Return the text without what no two runs agree on: the milliseconds."""
    return re.sub(r"\| [\d.e+]* (\| `\w+\.sql` \|)", r"|  \1", written)


def main(target: Path | None) -> None:
    """Print the text, and write it."""
    with server() as address, psycopg.connect(address, autocommit=True) as connection:
        found = text(connection, ROOMS, THINGS, CLOUDS)
    print(found)
    if target:
        target.write_text(found, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
