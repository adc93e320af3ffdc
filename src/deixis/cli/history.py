"""``deixis map since``, ``history``, ``changes`` and ``export``: what held when, and as RDF."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from deixis.cli.commands import Region, RegionOption, RelationOption, RuleFiles, Seconds, TextOrJson
from deixis.cli.maps import At, Database, app, at_of, time_of
from deixis.cli.output import printable, records, warn, write_csv, write_json, write_table
from deixis.moments import moment

if TYPE_CHECKING:
    from deixis.explain import Answer
    from deixis.scene import Scene
    from deixis.semantic_map import Interval, SemanticMap
    from deixis.words import Lasting


class Listed(StrEnum):
    """Output formats of intervals."""

    TEXT = "text"
    TABLE = "table"
    JSON = "json"
    CSV = "csv"


_COLUMNS: Final = ("relation", "figure", "reference", "view", "since", "until")

_REASON: Final = 10.0
"""Seconds for each reason."""

ViewToo = Annotated[
    str | None, typer.Option("--view", help="Only this view's horizontal relations, beside the others.")
]
Why = Annotated[bool, typer.Option("--why", help="Also say why, with the numbers measured at that time.")]


@app.command()
def since(
    goal: Annotated[str, typer.Argument(metavar="GOAL", help="A relation, e.g. 'on_top_of(cup, table)'.")],
    database: Database,
    at: At = None,
    why: Why = False,
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print it.")] = TextOrJson.TEXT,
    timeout: Seconds = 600.0,
) -> None:
    """Say since when something holds, or held at a time; exit code 1 where it does not."""
    from deixis.semantic_map import Interval, open_map

    with open_map(database) as kept:
        now = kept.span()[1]
        name, figure, reference, *view = _named(kept, goal, rules)
        by = view[0] if view else None
        then = at_of(kept, at)
        how: dict[str, Any] = {"rules": rules or (), "region": region.value, "timeout": timeout}
        found = kept.since(name, figure, reference, by, at=then, **how)
        last = None
        if found is None:
            before = kept.intervals([name], figure=figure, reference=reference, view=by, end=then, **how)
            last = max((one for one in before if one.view == by), key=lambda one: one.since, default=None)
        answer = None
        if why:
            missing = [] if found else _missing(kept.scene(at=then), (figure, reference, *view))
            answer = _why(kept, goal, then, rules, region, missing)
        lasting = _lasting(kept)
    if found is None:
        asked = Interval(name, figure, reference, by, now, None)
        text = lasting.not_so(asked, then, last)
    else:
        text = lasting.holds(found, now) if then is None else lasting.held(found, then)
    if output is TextOrJson.JSON:
        told: dict[str, Any] = {
            "goal": goal,
            "at": moment(now if then is None else then),
            "holds": found is not None,
            "interval": None if found is None else _row(found),
            "last": None if last is None else _row(last),
            "text": text,
        }
        write_json(told if answer is None else {**told, "why": answer.to_dict()})
    else:
        print(printable(text))
        if answer is not None:
            for line in answer.told("normal").split("\n"):
                print(printable(line))
    if found is None:
        raise typer.Exit(1)


@app.command()
def history(
    database: Database,
    relation: RelationOption = None,
    figure: Annotated[str | None, typer.Option(metavar="ID", help="Only of this figure.")] = None,
    reference: Annotated[str | None, typer.Option(metavar="ID", help="Only by this reference.")] = None,
    view: ViewToo = None,
    at: At = None,
    start: Annotated[
        str | None, typer.Option("--from", metavar="TIME", help="Only what held then or later.")
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="TIME", help="Only what held then or earlier.")
    ] = None,
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    output: Annotated[Listed, typer.Option("--format", help="How to print them.")] = Listed.TEXT,
    timeout: Seconds = 600.0,
) -> None:
    """List from when to when relations held, the earliest first; exit code 1 where none did."""
    from deixis.errors import QueryError
    from deixis.semantic_map import open_map

    if at is not None and (start is not None or end is not None):
        raise QueryError("--at is one time, and --from and --to are two: give the one or the others")
    how: dict[str, Any] = {"rules": rules or (), "region": region.value, "timeout": timeout}
    with open_map(database) as kept:
        asked: dict[str, Any] = {"figure": figure, "reference": reference, "view": view, **how}
        if at is not None:
            found = kept.relations(at=at_of(kept, at), relation=relation, **asked)
        else:
            span = at_of(kept, start), at_of(kept, end)
            found = kept.intervals(relation, start=span[0], end=span[1], **asked)
        lasting = _lasting(kept)
    rows = list(map(_row, found))
    if output is Listed.JSON:
        write_json(rows)
    elif output is Listed.TEXT:
        for one in found:
            print(printable(lasting.was(one)))
    else:
        (write_csv if output is Listed.CSV else write_table)(_COLUMNS, records(_COLUMNS, rows))
    if not rows:
        raise typer.Exit(1)


@app.command()
def changes(
    start: Annotated[str, typer.Argument(metavar="FROM", help="A time, as of --at.")],
    end: Annotated[str, typer.Argument(metavar="TO", help="A later one.")],
    database: Database,
    relation: RelationOption = None,
    view: Annotated[
        str | None, typer.Option(help="Whose left and right count; without it nobody's do.")
    ] = None,
    why: Why = False,
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print them.")] = TextOrJson.TEXT,
    timeout: Seconds = 600.0,
) -> None:
    """Say what changed between two times: + holds now, - does not any more, ~ held for a while between.

    Exit code 1 where nothing did.
    """
    from deixis.semantic_map import open_map

    with open_map(database) as kept:
        found = kept.changes(
            time_of(kept, start), time_of(kept, end),
            relation=relation, view=view, rules=rules or (), region=region.value, timeout=timeout,
        )  # fmt: skip
        lasting = _lasting(kept)
        reason = partial(_because, kept, rules=rules, region=region) if why else _no_reason
        told = {
            name: [(one, reason(one, name)) for one in getattr(found, name)]
            for name in ("gained", "lost", "passing")
        }
    if output is TextOrJson.JSON:
        rows = {
            name: [_row(one) | ({} if said is None else {"because": said}) for one, said in some]
            for name, some in told.items()
        }
        write_json({"from": moment(found.start), "to": moment(found.end), **rows})
    else:
        for sign, some in zip("+-~", told.values(), strict=True):
            for one, said in some:
                print(f"{sign} {printable(lasting.was(one))}")
                if said is not None:
                    print(f"  {printable(said)}")
    if not found:
        raise typer.Exit(1)


@app.command()
def export(
    database: Database,
    target: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="FILE", help="What to write: .trig, .nq, .jsonld, .ttl or .nt."
        ),
    ],
    at: At = None,
    proofs: Annotated[
        bool, typer.Option(help="By which steps each relation of that time was derived.")
    ] = True,
    timeout: Seconds = 600.0,
) -> None:
    """Write the scene of a time with all that follows as RDF, and when each relation held, ever."""
    from deixis.knowledge import KnowledgeBase
    from deixis.rdf.export import save
    from deixis.rdf.history import history_quads
    from deixis.semantic_map import open_map

    with open_map(database) as kept:
        then = kept.scene(at=at_of(kept, at))
        past = history_quads(then, kept.intervals(timeout=timeout), kept.labels(), kept.views())
    warn(then.diagnostics)
    with KnowledgeBase(then) as kb:
        count = save(kb, target, proofs=proofs, more=past)
    print(f"{target}: {count} quads", file=sys.stderr)


def _named(kept: SemanticMap, goal: str, rules: list[Path] | None) -> tuple[str, ...]:
    """Return relation, figure, reference and perhaps view of a goal."""
    from deixis.counterfactual import named_fact
    from deixis.engines import predicates
    from deixis.semantic_map import ruleset_of

    known = [*kept.labels(), *kept.views()]
    return named_fact(goal, known, partial(predicates, ruleset=ruleset_of(rules) if rules else None))


def _lasting(kept: SemanticMap) -> Lasting:
    from deixis.words import Lasting

    return Lasting(kept.labels(), kept.views())


def _row(one: Interval) -> dict[str, Any]:
    until = None if one.until is None else moment(one.until)
    return {**one.to_dict(), "since": moment(one.since), "until": until}


def _missing(then: Scene, names: Sequence[str | None]) -> list[str]:
    """Return which things and views are not there in a scene."""
    there = {thing.id for thing in then.objects} | {view.id for view in then.views}
    return [name for name in names if name and name not in there]


def _why(
    kept: SemanticMap,
    goal: str,
    at: float | None,
    rules: list[Path] | None,
    region: Region,
    missing: Sequence[str] = (),
) -> Answer:
    """Return why something held at a time, or why not; where something was missing, that it was."""
    from deixis.explain import Answer
    from deixis.knowledge import KnowledgeBase

    if missing:
        return Answer(None, None, f"at that time there is no {' and no '.join(missing)}")
    with KnowledgeBase(kept.scene(at=at), rules=rules or (), region=region.value) as kb:
        return kb.why(goal, timeout=_REASON)


def _no_reason(_one: Interval, _change: str) -> None:
    return None


def _because(kept: SemanticMap, one: Interval, change: str, rules: list[Path] | None, region: Region) -> str:
    """Return the reason of a change, of the time at which it came."""
    from deixis.consequences import because

    at = one.until if change == "lost" and one.until is not None else one.since
    gone = _missing(kept.scene(at=at), (one.figure, one.reference, one.view))
    return f"{' and '.join(gone)} gone" if gone else because(_why(kept, one.to_prolog(), at, rules, region))
