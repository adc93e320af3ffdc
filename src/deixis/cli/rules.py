"""``deixis rules``: rule files checked, drawn, and compiled to other languages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deixis.cli.output import printable

if TYPE_CHECKING:
    from deixis.ruleset import Indicator, Ruleset

app = typer.Typer(help="Check, draw and compile rule files.", no_args_is_help=True)

Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Rule files of your own.")]
MaybeFiles = Annotated[
    list[Path] | None, typer.Argument(metavar="[FILE...]", help="Rule files beside the theory's.")
]


_DENIED = "\\+ "


class Drawing(StrEnum):
    """How a graph is written."""

    TEXT = "text"
    DOT = "dot"


class Language(StrEnum):
    """What rules are compiled to."""

    SQL = "sql"
    SPARQL = "sparql"


@app.command()
def check(files: Files) -> None:
    """Print what is wrong with rule files, one problem a line; exit code 1 when there is any.

    A line is FILE:LINE:COLUMN: what is wrong (what to do about it).
    """
    from deixis.ruleset import examine

    theory, own = _split(files)
    _, problems = examine(theory, own)
    for one in problems:
        print(printable(one))
    if problems:
        raise typer.Exit(1)


@app.command()
def graph(
    files: MaybeFiles = None,
    output: Annotated[Drawing, typer.Option("--format", help="How to draw it.")] = Drawing.TEXT,
) -> None:
    """Print which predicate rests on which, stratum by stratum; what is denied is marked."""
    from deixis.ruleset import shown

    ruleset = _load(files or [])
    strata = ruleset.graph.strata()
    below: dict[Indicator, dict[str, None]] = {}
    for edge in ruleset.graph.edges:
        name = shown(edge.on)
        below.setdefault(edge.head, {})[_DENIED + name if edge.denied else name] = None
    if output is Drawing.TEXT:
        for level in sorted(set(strata.values())):
            print(f"stratum {level}")
            for one in strata:
                if strata[one] == level and one in below:
                    print(printable(f"  {shown(one)}: {', '.join(below[one])}"))
        return
    print("digraph rules {\n  rankdir = BT;\n  node [shape = box];")
    for head, names in below.items():
        for name in names:
            target = name.removeprefix(_DENIED)
            style = " [style = dashed]" if target != name else ""
            print(f"  {_quoted(shown(head))} -> {_quoted(target)}{style};")
    print("}")


@app.command(name="compile")
def compile_(
    language: Annotated[Language, typer.Option("--to", help="The language.")],
    files: MaybeFiles = None,
) -> None:
    """Print the rules in another language: SQL for DuckDB, or SPARQL for any triple store."""
    ruleset = _load(files or [])
    if language is Language.SQL:
        from deixis.sql import script

        print(script(ruleset, _spoken(ruleset)))
    else:
        from deixis.rdf import constructs

        print(constructs(ruleset, _spoken(ruleset)))


def _spoken(ruleset: Ruleset) -> list[Indicator]:
    """Return what is derived: the relations people speak in, and what the user's files define."""
    from deixis.vocabulary import RELATIONS

    return [*((term.name, term.arity) for term in RELATIONS), *sorted(ruleset.user)]


def _split(files: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Return the theory's files and the user's with what they import; a theory's file may be named too."""
    from deixis._files import datalog_files
    from deixis.ruleset import locate

    theory = list(datalog_files())
    return theory, list(locate(files, theory))


def _load(files: Sequence[Path]) -> Ruleset:
    from deixis.ruleset import load

    return load(*_split(files))


def _quoted(text: str) -> str:
    return json.dumps(printable(text))
