"""Commands that speak as people do: a scene described, questions answered, what a preposition means."""

from __future__ import annotations

from typing import Annotated

import typer

from deixis.cli.commands import Region, RegionOption, ScenePath, Seconds, TextOrJson, app, open_scene
from deixis.cli.output import printable, printable_lines, write_json

ViewOption = Annotated[
    str | None, typer.Option("--view", help="Whose left and right; the first view's unless given.")
]


@app.command()
def describe(
    scene: ScenePath,
    about: Annotated[
        str | None, typer.Option("--object", metavar="ID", help="Speak of this thing only.")
    ] = None,
    view: ViewOption = None,
    most: Annotated[int, typer.Option("--sentences", min=1, help="At most so many.")] = 6,
    region: RegionOption = Region.BOX,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print it.")] = TextOrJson.TEXT,
    timeout: Seconds = 60.0,
) -> None:
    """Say what is where, in a few sentences; with --format json also the relations each rests on.

    Exit codes: 0 something is said, 1 there is nothing to say, 2 error, 3 time-out.
    """
    with open_scene(scene, region) as kb:
        found = kb.describe(about=about, view=view, most=most, timeout=timeout)
    if output is TextOrJson.JSON:
        write_json(found.to_dict())
    else:
        for line in found.lines():
            print(printable(line))
    if not found.sentences:
        raise typer.Exit(1)


@app.command()
def say(
    scene: ScenePath,
    question: Annotated[str, typer.Argument(metavar="QUESTION", help="E.g. 'what is on the table?'.")],
    view: ViewOption = None,
    region: RegionOption = Region.BOX,
    output: Annotated[TextOrJson, typer.Option("--format", help="How to print it.")] = TextOrJson.TEXT,
    timeout: Seconds = 60.0,
) -> None:
    """Answer a question in plain English.

    What is on, in, near ... X; what is X on; which Xs are on Y; where is X; is X on Y; how many Xs are on Y;
    why is X on Y; why isn't X on Y; each with 'from the robot' behind it where left and right matter. Other
    questions are refused.

    Exit codes: 0 yes, or there are some; 1 no, or none; 2 refused, or not clear which thing is meant; 3
    time-out.
    """
    with open_scene(scene, region) as kb:
        found = kb.say(question, view=view, timeout=timeout)
    if output is TextOrJson.JSON:
        write_json(found.to_dict())
    else:
        print(printable_lines(found.text))
    if found.choices:
        raise typer.Exit(2)
    if not found.holds:
        raise typer.Exit(1)


@app.command()
def lexicon(
    word: Annotated[
        str | None, typer.Argument(metavar="[WORD]", help="A preposition, or the name of a relation.")
    ] = None,
) -> None:
    """Print what a preposition means here, which prepositions say a relation, or all of them.

    Exit codes: 0 known, 2 not known, or known and not grounded: the message says why.
    """
    from deixis.words.lexicon import ENTRIES, entry_of, words_for

    known = word is not None and any(word in entry.forms for entry in ENTRIES)
    said = () if word is None or known else words_for(word)
    if said:
        print(", ".join(said))
        return
    for entry in ENTRIES if word is None else [entry_of(word)]:
        print(", ".join(entry.forms))
        for sense in entry.senses:
            print(f"  {sense.predicate}: {printable(sense.gloss)}")
