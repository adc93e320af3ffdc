"""The commands of ``deixis``."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deixis import __version__
from deixis.cli import perceive as perceive_command
from deixis.cli import rules as rules_commands
from deixis.cli import serve as serve_command
from deixis.cli.group import Group
from deixis.cli.measuring import Grounding, GroundingOption, measured
from deixis.cli.output import (
    Format,
    RelationFormat,
    counted,
    printable_lines,
    records,
    warn,
    write_csv,
    write_json,
    write_table,
)
from deixis.cli.shown import show_relations

if TYPE_CHECKING:
    from deixis.knowledge import KnowledgeBase

app = typer.Typer(
    name="deixis",
    cls=Group,
    help="Commonsense spatial relations of a 3D scene, and why they hold.\n\n"
    "Exit codes: 0 yes, 1 no, 2 error, 3 time-out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.add_typer(rules_commands.app, name="rules")
app.command()(serve_command.serve)
app.command()(perceive_command.perceive)


class Region(StrEnum):
    """Region models, as :data:`deixis.facts.RegionModel`, which takes longer to import."""

    BOX = "box"
    HULL = "hull"
    MESH = "mesh"


ScenePath = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene file (see `deixis import` for other formats).")
]
RegionOption = Annotated[
    Region,
    typer.Option(
        "--region",
        help="What things are measured as: their boxes, convex hulls, or meshes where they have any.",
    ),
]
ViewOption = Annotated[str | None, typer.Option("--view", help="Only this view's horizontal relations.")]
RelationOption = Annotated[
    list[str] | None, typer.Option("--relation", help="Only this relation; may be repeated.")
]
Seconds = Annotated[float, typer.Option("--timeout", min=0.001, help="Seconds before giving up.")]

RuleFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--rules",
        metavar="FILE",
        help="Your own rules, or a shipped file by its name: support, background, safety; may be repeated.",
    ),
]

Language = Annotated[str, typer.Option("--lang", metavar="LANGUAGE", help="What sentences are in: en or de.")]

_NAMED = 5
"""Things named in a message before it is cut short."""


class EngineName(StrEnum):
    """What derives relations."""

    AUTO = "auto"
    ARRAYS = "arrays"
    DUCKDB = "duckdb"
    PROLOG = "prolog"
    SPARQL = "sparql"


class OntologyFormat(StrEnum):
    """Formats of the ontology."""

    TTL = "ttl"
    OWL = "owl"
    NT = "nt"


class Length(StrEnum):
    """How much is told, as :data:`deixis.explain.Length`."""

    BRIEF = "brief"
    NORMAL = "normal"
    FULL = "full"


class TextOrJson(StrEnum):
    """Output formats of answers and explanations."""

    TEXT = "text"
    JSON = "json"


def _version(wanted: bool) -> None:
    if wanted:
        print(f"deixis {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def open_scene(
    scene: Path,
    region: Region,
    rules: list[Path] | None = None,
    language: str = "en",
    grounding: Grounding = Grounding.KERNEL,
    database: str | None = None,
) -> KnowledgeBase:
    """Return the knowledge base of a scene file; say on stderr what its readers should know."""
    from deixis.knowledge import KnowledgeBase
    from deixis.scene import Scene

    loaded = Scene.load(scene)
    warn(loaded.diagnostics)
    facts = measured(loaded, grounding, region.value, database)
    kb = KnowledgeBase(loaded, rules=rules or (), region=region.value, language=language, facts=facts)
    if kb.box_only:
        some = ", ".join(kb.box_only[:_NAMED]) + (" ..." if len(kb.box_only) > _NAMED else "")
        warn(
            [f"{len(kb.box_only)} of {len(kb.scene.objects)} have only a box and are measured as it: {some}"]
        )
    return kb


@app.command()
def relations(
    scene: ScenePath,
    view: ViewOption = None,
    relation: RelationOption = None,
    region: RegionOption = Region.BOX,
    output: Annotated[
        RelationFormat, typer.Option("--format", help="How to print them.")
    ] = RelationFormat.TABLE,
    timeout: Seconds = 60.0,
    rules: RuleFiles = None,
    engine: Annotated[
        EngineName, typer.Option(help="What derives them; all give the same.")
    ] = EngineName.AUTO,
    grounding: GroundingOption = Grounding.KERNEL,
    database: Annotated[
        str | None,
        typer.Option(
            "--db", metavar="DB", help="Where PostGIS measures: postgresql://... Nothing stays there."
        ),
    ] = None,
) -> None:
    """Print the relations that hold in a scene, each with its margin in metres."""
    with open_scene(scene, region, rules, "en", grounding, database) as kb:
        found = show_relations(kb, output, view=view, relation=relation, timeout=timeout, engine=engine.value)
    if not found:
        raise typer.Exit(1)


@app.command()
def facts(
    scene: ScenePath,
    region: RegionOption = Region.BOX,
    output: Annotated[Format, typer.Option("--format", help="How to print them.")] = Format.TABLE,
) -> None:
    """Print what was measured: one row for each ordered pair within reach."""
    kb = open_scene(scene, region)
    if output is Format.PL:
        sys.stdout.write(kb.facts_text())
        return
    rows = kb.facts.rows()
    if output is Format.JSON:
        write_json(
            {
                "scene": kb.scene.id,
                "thresholds": dict(kb.scene.thresholds.items()),
                "measured_as": kb.measured_as,
                "facts": rows,
                "withheld": [one.to_dict() for one in kb.withheld],
            }
        )
    else:
        columns = list(kb.facts.columns())
        if output is Format.TABLE:
            columns = [name for name in columns if not name.startswith("normal")]
        (write_csv if output is Format.CSV else write_table)(columns, records(columns, rows))


@app.command()
def ask(
    scene: ScenePath,
    goal: Annotated[str, typer.Argument(metavar="GOAL", help="A Prolog goal, e.g. 'on_top_of(X, table)'.")],
    region: RegionOption = Region.BOX,
    output: Annotated[
        TextOrJson, typer.Option("--format", help="How to print the answers.")
    ] = TextOrJson.TEXT,
    limit: Annotated[int | None, typer.Option(min=1, help="At most this many answers.")] = None,
    timeout: Seconds = 10.0,
    rules: RuleFiles = None,
) -> None:
    """Answer a question.

    Exit codes: 0 there is an answer, 1 there is none, 2 the question is wrong, 3 it took too long. Answers
    cut short by --limit say so: on stderr, and as "truncated" in JSON, where "timed_out" tells of a time-out.
    A name that nothing has is told on stderr, and in "notes": a relation of it does not hold.
    """
    from deixis.errors import QueryTimeout
    from deixis.prolog import Answers, Variable, term_json, term_text

    def as_json(answers: Answers, notes: list[str], *, timed_out: bool = False) -> None:
        rows = [{name: term_json(value) for name, value in row.items()} for row in answers.bindings]
        told = {"truncated": answers.truncated, "timed_out": timed_out, "output": answers.output}
        write_json({"goal": goal, "answers": rows, **told, "notes": notes})

    with open_scene(scene, region, rules) as kb:
        try:
            answers = kb.ask(goal, limit=limit, timeout=timeout)
        except QueryTimeout:
            if output is TextOrJson.JSON:
                as_json(Answers((), truncated=True), [], timed_out=True)
            raise
        notes = [kb.unknown_name(name) for name in answers.unknown]
    if output is TextOrJson.JSON:
        as_json(answers, notes)
    else:
        if answers.output:
            print(printable_lines(answers.output.removesuffix("\n")))
        for row in answers.bindings:
            known = {name: value for name, value in row.items() if value != Variable(name)}
            print(", ".join(f"{name} = {term_text(value)}" for name, value in known.items()) or "true")
        if not answers.bindings:
            print("false")
    warn(notes)
    if answers.truncated:
        warn([f"there are more answers than the {limit} printed"])
    if not answers.bindings:
        raise typer.Exit(1)


@app.command()
def shell(
    scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="Scene files.")],
    region: RegionOption = Region.BOX,
    rules: RuleFiles = None,
    lang: Language = "en",
) -> None:
    """Open SWI-Prolog with scenes and the rules loaded.

    At its prompt also: objects, axioms, help(on_top_of), why(GOAL), why_not(GOAL), contrast(GOAL, OTHER),
    view(V). With several scenes each id has the id of its scene and _ in front: hall_cup is cup of hall.
    """
    from deixis._files import theory_files
    from deixis.prolog.shell import exec_shell

    opened = [open_scene(scene, region, rules) for scene in scenes]
    grounded = [(kb.facts, [(view.id, view.label) for view in kb.scene.views]) for kb in opened]
    exec_shell([*theory_files(lang), *opened[0].rule_files], grounded, opened[0].tabled)


@app.command()
def export(
    scene: ScenePath,
    target: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="FILE", help="What to write: .trig, .nq, .jsonld, .ttl, .nt or .mcap."
        ),
    ],
    region: RegionOption = Region.BOX,
    view: ViewOption = None,
    proofs: Annotated[bool, typer.Option(help="By which steps each relation was derived.")] = True,
    rules: RuleFiles = None,
) -> None:
    """Write a scene with all that follows from it as RDF, or for Foxglove, by the ending of the file."""
    from deixis.rdf.export import save
    from deixis.rdf.formats import ending

    form = ending(target, also=["mcap"])
    with open_scene(scene, region, rules) as kb:
        if form == "mcap":
            from deixis.cli.bags import export_mcap

            told = export_mcap(kb, target, proofs=proofs, view=view)
        else:
            told = f"{save(kb, target, proofs=proofs, view=view)} quads"
    print(f"{target}: {told}", file=sys.stderr)


@app.command(name="import")
def import_(
    name: Annotated[
        str, typer.Argument(metavar="FORMAT", help="deixis, ithor, rdf, virtualhome, or an added one.")
    ],
    path: Annotated[
        str, typer.Argument(metavar="FILE", help="The file; for several scenes in one, FILE#SCENE.")
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="SCENE", help="Where to write the scene.")
    ],
) -> None:
    """Convert a scene of another format to a scene file."""
    from deixis.readers import read_one

    scene = read_one(name, path)
    warn(scene.diagnostics)
    scene.save(target)
    told = counted(len(scene.objects), "object"), counted(len(scene.views), "view")
    print(f"{target}: {', '.join(told)}", file=sys.stderr)


class SchemaName(StrEnum):
    """Formats that have a schema."""

    SCENE = "scene"
    FRAME = "frame"


@app.command()
def schema(
    name: Annotated[SchemaName, typer.Argument(metavar="[scene|frame]", help="Of which files.")] = (
        SchemaName.SCENE
    ),
) -> None:
    """Print the JSON Schema of scene files, or of the frame files that `perceive` reads."""
    from deixis.perception.frame_format import frame_schema
    from deixis.scene import scene_schema

    write_json(frame_schema() if name is SchemaName.FRAME else scene_schema())


@app.command()
def ontology(
    term: Annotated[
        str | None, typer.Argument(metavar="[TERM]", help="Only this: onTopOf, urn:deixis:term:onTopOf.")
    ] = None,
    output: Annotated[
        OntologyFormat, typer.Option("--format", help="Turtle, RDF/XML or N-Triples.")
    ] = OntologyFormat.TTL,
) -> None:
    """Print the ontology of what is exported, or what it says of one term."""
    from deixis.rdf import ontology as texts

    sys.stdout.write(texts.ontology(output.value) if term is None else texts.definition(term) + "\n")


@app.command()
def doctor() -> None:
    """Check that everything Deixis needs is here."""
    from deixis.cli.doctor import report

    if not report():
        raise typer.Exit(2)


@app.command()
def demo() -> None:
    """Show the paper's Figure 3: its relations, and why they hold."""
    from deixis.cli.demo import run

    run()
