"""How explanations are written: text, JSON, a page that opens step by step, or a graph for Graphviz."""

from __future__ import annotations

import json
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deixis._files import write_whole
from deixis.errors import SceneError
from deixis.strict_json import quoted

if TYPE_CHECKING:
    from deixis.render import Shown


class ExplanationFormat(StrEnum):
    """Output formats of explanations."""

    TEXT = "text"
    JSON = "json"
    HTML = "html"
    DOT = "dot"


ExplanationOption = Annotated[
    ExplanationFormat,
    typer.Option("--format", help="text, json, html (a page that opens step by step) or dot (for Graphviz)."),
]

ExplanationFile = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write it there instead of printing it.")
]


def write_explanation(
    found: Shown,
    values: Mapping[str, Any],
    said: str,
    title: str,
    form: ExplanationFormat,
    to: Path | None,
) -> None:
    """Print an explanation, or write it to a file.

    Parameters
    ----------
    found : Shown
    values : mapping
        Of it as JSON.
    said : str
        It as text.
    title : str
        Of the page.
    form : ExplanationFormat
    to : Path or None
        The file.

    Raises
    ------
    SceneError
        The file cannot be written.
    """
    match form:
        case ExplanationFormat.TEXT:
            text = said
        case ExplanationFormat.JSON:
            text = json.dumps(values, ensure_ascii=False, indent=2, allow_nan=False)
        case ExplanationFormat.HTML:
            text = found.to_html(title).rstrip("\n")
        case ExplanationFormat.DOT:
            text = found.to_dot()
    if to is None:
        print(text)
        return
    try:
        write_whole(to, f"{text}\n".encode())
    except OSError as cause:
        raise SceneError(f"{quoted(str(to), 200)} cannot be written: {cause.strerror}") from cause
