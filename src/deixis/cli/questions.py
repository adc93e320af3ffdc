"""Commands that ask why, why not, what is wrong, and what would be if things stood elsewhere."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from deixis.cli.commands import (
    EngineName,
    Language,
    Length,
    Region,
    RegionOption,
    RuleFiles,
    ScenePath,
    Seconds,
    TextOrJson,
    app,
    open_scene,
)
from deixis.cli.explanations import (
    ExplanationFile,
    ExplanationFormat,
    ExplanationOption,
    write_explanation,
)
from deixis.cli.output import printable, printable_lines, warn, write_json
from deixis.errors import QueryError

if TYPE_CHECKING:
    from deixis.explain import Answer, Proofs


@app.command()
def why(
    scene: ScenePath,
    goal: Annotated[str, typer.Argument(metavar="GOAL", help="A relation, e.g. 'leans_on(ladder, wall)'.")],
    region: RegionOption = Region.BOX,
    output: ExplanationOption = ExplanationFormat.TEXT,
    to: ExplanationFile = None,
    length: Annotated[
        Length, typer.Option(help="The reason that decides it; an outline; every step with its evidence.")
    ] = Length.NORMAL,
    every: Annotated[
        bool, typer.Option("--all", help="All proofs, the best first, not only that one.")
    ] = False,
    limit: Annotated[int, typer.Option(min=1, help="With --all: at most this many.")] = 20,
    timeout: Seconds = 10.0,
    rules: RuleFiles = None,
    lang: Language = "en",
) -> None:
    """Explain why a relation holds, down to the measured numbers; exit code 1 when it does not hold."""
    with open_scene(scene, region, rules, lang) as kb:
        warn(kb.variables_like_names(goal))
        found = kb.why_all(goal, limit=limit, timeout=timeout) if every else None
        told: Answer | Proofs
        if found:
            told = kb.evidence(found) if output is not ExplanationFormat.TEXT else found
        else:
            answer = kb.why(goal, timeout=timeout)
            told = kb.evidence(answer) if output is not ExplanationFormat.TEXT else answer
    said = printable_lines(told.told(length.value))
    write_explanation(told, {"goal": goal, **told.to_dict()}, said, goal, output, to)
    if found and found.truncated:
        warn([f"there are more proofs than the {limit} printed"])
    if not told:
        raise typer.Exit(1)


@app.command(name="why-not")
def why_not(
    scene: ScenePath,
    goal: Annotated[
        str, typer.Argument(metavar="GOAL", help="A relation, e.g. 'affixed_on(picture, wall)'.")
    ],
    region: RegionOption = Region.BOX,
    output: ExplanationOption = ExplanationFormat.TEXT,
    to: ExplanationFile = None,
    timeout: Seconds = 10.0,
    rules: RuleFiles = None,
    lang: Language = "en",
) -> None:
    """Say what keeps a relation from holding: of each rule what fails, the nearest first.

    Exit codes: 0 it does not hold, 1 it does, 2 the question is wrong.
    """
    with open_scene(scene, region, rules, lang) as kb:
        warn(kb.variables_like_names(goal))
        found = kb.why_not(goal, timeout=timeout)
        if output is not ExplanationFormat.TEXT:
            found = kb.evidence(found)
    said = "\n".join(map(printable, [found.sentence(), *found.others()]))
    write_explanation(found, {"goal": goal, **found.to_dict()}, said, goal, output, to)
    if found.holds:
        raise typer.Exit(1)


@app.command()
def contrast(
    scene: ScenePath,
    goal: Annotated[str, typer.Argument(metavar="GOAL", help="A relation that holds.")],
    rather_than: Annotated[str, typer.Option(metavar="GOAL", help="One that does not.")],
    region: RegionOption = Region.BOX,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print it.")] = TextOrJson.TEXT,
    timeout: Seconds = 10.0,
    rules: RuleFiles = None,
    lang: Language = "en",
) -> None:
    """Say why one relation holds rather than another, in a sentence.

    Exit codes: 0 the one holds and the other does not, 1 otherwise, 2 the question is wrong.
    """
    with open_scene(scene, region, rules, lang) as kb:
        warn(kb.variables_like_names(goal, rather_than))
        found = kb.contrast(goal, rather_than, timeout=timeout)
    if output is TextOrJson.JSON:
        write_json({"goal": goal, "rather_than": rather_than, **found.to_dict()})
    else:
        print(printable(found.sentence()))
    if not found:
        raise typer.Exit(1)


@app.command()
def check(
    scene: ScenePath,
    rules: RuleFiles = None,
    view: Annotated[str | None, typer.Option(help="Look from this view only.")] = None,
    region: RegionOption = Region.BOX,
    engine: Annotated[
        EngineName, typer.Option(help="What derives the violations; all give the same.")
    ] = EngineName.AUTO,
    output: ExplanationOption = ExplanationFormat.TEXT,
    to: ExplanationFile = None,
    brief: Annotated[bool, typer.Option("--brief", help="Without reasons: needs no SWI-Prolog.")] = False,
    timeout: Seconds = 60.0,
    lang: Language = "en",
) -> None:
    """List what breaks the rules of safety, or your own, each with its reasons.

    Without --rules it checks the shipped rules of safety. Exit codes: 0 no violation, 1 there are violations,
    2 error, 3 time-out.
    """
    with open_scene(scene, region, rules, lang) as kb:
        found = kb.check(view=view, engine=engine.value, reasons=not brief, timeout=timeout)
        if output is not ExplanationFormat.TEXT:
            found = kb.evidence(found)
    says, said = {one.rule: one.says for one in found.checked}, []
    for one in found.violations:
        said.append(printable(": ".join(filter(None, (one.rule, says[one.rule])))))
        told = one.text if one.proof is None else one.proof.outline()
        said.append(printable_lines("\n".join(f"  {line}" for line in told.split("\n"))) + "\n")
    said.append(found.summary())
    write_explanation(found, found.to_dict(), "\n".join(said), f"Check of {found.scene}", output, to)
    if not found.passed:
        raise typer.Exit(1)


@app.command()
def change(
    scene: ScenePath,
    goal: Annotated[str, typer.Argument(metavar="GOAL", help="A relation, e.g. 'on_top_of(cup, table)'.")],
    output: Annotated[
        TextOrJson, typer.Option("--format", help="How to print the change.")
    ] = TextOrJson.TEXT,
    rules: RuleFiles = None,
) -> None:
    """Find the smallest move of a thing that makes a relation hold, or cease to.

    The move is verified by trying it. Exit codes: 0 there is one, 1 none was found within three metres, 2
    the question is wrong.
    """
    with open_scene(scene, Region.BOX, rules) as kb:
        warn(kb.variables_like_names(goal))
        found = kb.change(goal)
    if output is TextOrJson.JSON:
        write_json({"goal": goal, "change": None if found is None else found.to_dict()})
    elif found is None:
        print("No move within three metres was found that changes it.")
    else:
        # To the micrometre, as what-if --move takes it; no power of ten is written.
        offset = ",".join(f"{round(metres, 6) + 0.0:.6f}".rstrip("0").rstrip(".") for metres in found.offset)
        becomes = "holds" if found.holds else "no longer holds"
        print(
            f"Move {printable(found.thing)} by {offset} m ({100 * found.distance:.1f} cm): "
            f"then {printable(goal)} {becomes}."
        )
        if found.collides:
            print(f"There it would share space with {', '.join(map(printable, found.collides))}.")
    if found is None:
        raise typer.Exit(1)


@app.command(name="what-if")
def what_if(
    scene: ScenePath,
    move: Annotated[
        list[str],
        typer.Option("--move", metavar="THING=X,Y,Z", help="Move a thing by metres; may be repeated."),
    ],
    region: RegionOption = Region.BOX,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print them.")] = TextOrJson.TEXT,
    timeout: Seconds = 60.0,
    rules: RuleFiles = None,
    lang: Language = "en",
) -> None:
    """Print the relations gained and lost if things stood elsewhere, each with its reason.

    Exit codes: 0 something would change, 1 nothing would, 2 the question is wrong.
    """
    moves = dict(map(_move, move))
    with open_scene(scene, region, rules, lang) as kb:
        found = kb.consequences(moves, timeout=timeout)
    if output is TextOrJson.JSON:
        write_json({"moves": {thing: list(offset) for thing, offset in moves.items()}, **found.to_dict()})
    else:
        for sign, some in (("+", found.gained), ("-", found.lost)):
            for one in some:
                print(f"{sign} {printable(one.because)}")
    if not found:
        warn(["nothing would change"])
        raise typer.Exit(1)


def _move(text: str) -> tuple[str, tuple[float, float, float]]:
    """Return a thing and the offset that a user wrote; an id may have an equals sign in it."""
    thing, _, offset = text.rpartition("=")
    try:
        x, y, z = map(float, offset.split(","))
    except ValueError:
        raise QueryError(f"{text!r} is no move: write THING=X,Y,Z in metres, such as cup=0,0,-0.04") from None
    return thing, (x, y, z)
