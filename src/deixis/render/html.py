"""HTML: an explanation that opens step by step, as a fragment for other pages and as a page of its own.

The steps are nested ``<details>``: no script is needed, and the keyboard opens them. All text goes through
one function that escapes it, and characters that would reorder or hide it are written out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Final

from deixis.evidence import Evidence, Point, Value
from deixis.render.steps import amount, reasons, visible
from deixis.steps import Step

Part = tuple[str, Sequence[Step]]
"""A heading, and the steps below it."""

_OPEN: Final = 2
"""Steps so deep, and no deeper, are open at first."""

_STYLE: Final = """\
.deixis-why { font: 0.95rem/1.45 system-ui, sans-serif; max-width: 60rem; color-scheme: light dark;
  padding: 0.6em 0.8em; background: var(--ground); --ground: #fff; --text: #1c1e21; --dim: #5b6068;
  --line: #d4d7dc; --mark: #0b57d0; --ill: #a8071a; color: var(--text) }
@media (prefers-color-scheme: dark) {
  .deixis-why { --ground: #1b1d21; --text: #e8eaed; --dim: #a6abb3; --line: #454a52; --mark: #8ab4f8;
    --ill: #ff9c92 } }
.deixis-why h2 { margin: 0.4em 0; font-size: 1em }
.deixis-why ul { list-style: none; margin: 0; padding: 0 0 0 0.6em; border-left: 1px solid var(--line) }
.deixis-why li { margin: 0.15em 0; padding-left: 0.4em }
.deixis-why summary { cursor: pointer }
.deixis-why summary:focus-visible { outline: 2px solid var(--mark); outline-offset: 2px }
.deixis-why small { color: var(--dim); margin-left: 0.6em }
.deixis-why .fails { color: var(--ill) }
.deixis-why dl { display: grid; grid-template-columns: max-content auto; gap: 0 1em; font-size: 0.9em;
  margin: 0.2em 0 0.4em 1.2em; color: var(--dim) }
.deixis-why dt, .deixis-why dd { margin: 0; overflow-wrap: anywhere }
"""


def fragment(parts: Iterable[Part]) -> str:
    """Return an explanation as an HTML element with its own style, to be put into a page.

    Parameters
    ----------
    parts : iterable of (str, sequence of Step)
        Headings, each with the steps below it.

    Examples
    --------
    >>> print(fragment([("Nothing is <b>known</b>.", ())]).splitlines()[-2])
    <h2>Nothing is &lt;b&gt;known&lt;/b&gt;.</h2>
    """
    lines = [f"<style>\n{_STYLE}</style>"]
    for heading, steps in parts:
        lines.append(f"<h2>{_text(heading)}</h2>")
        lines += _listed(steps, 0)
    return '<div class="deixis-why">\n' + "\n".join(lines) + "\n</div>"


def page(title: str, parts: Iterable[Part], language: str = "en") -> str:
    """Return an explanation as a whole page that needs nothing else, not even a network."""
    return f"""<!doctype html>
<html lang="{_text(language)}">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{_text(title)}</title>
</head>
<body>
<main>
{fragment(parts)}
</main>
</body>
</html>
"""


def _listed(steps: Iterable[Step], depth: int) -> Iterator[str]:
    steps = list(steps)
    if not steps:
        return
    yield "<ul>"
    for step in steps:
        yield "<li>"
        yield from _step(step, depth)
        yield "</li>"
    yield "</ul>"


def _step(step: Step, depth: int) -> Iterator[str]:
    below = list(reasons(step))
    rows = [] if step.evidence is None else list(_rows(step.evidence))
    # What came closest to refuting a negation is no reason of it: it waits until it is asked for.
    is_open = depth < _OPEN and step.kind != "negation" and below
    said = f"<span>{_text(step.text)}</span>{_notes(step)}"
    if not below and not rows:
        yield f'<div class="{step.kind}">{said}</div>'
        return
    yield f'<details class="{step.kind}"{" open" if is_open else ""}><summary>{said}</summary>'
    if rows:
        cells = (f"<dt>{_text(name)}</dt><dd>{_text(value)}</dd>" for name, value in rows)
        yield "<dl>" + "".join(cells) + "</dl>"
    yield from _listed(below, depth + 1)
    yield "</details>"


def _notes(step: Step) -> str:
    """Return axiom, place of the rule, and what there is to spare."""
    notes = [] if step.axiom is None or step.rule is None else [f"<small>axiom {step.axiom}</small>"]
    if step.rule is not None:
        notes.append(f"<small>{_text(step.rule.file)}:{step.rule.line}</small>")
    if step.margin is not None:
        fails = ' class="fails"' if step.margin < 0.0 else ""
        spare = amount(abs(step.margin), "m")
        notes.append(f"<small{fails}>{f'short by {spare}' if fails else f'{spare} to spare'}</small>")
    return "".join(notes)


def _rows(evidence: Evidence) -> Iterator[tuple[str, str]]:
    """Yield what a leaf rests on, name by name."""
    yield from map(_value, evidence.values)
    yield from map(_value, evidence.thresholds)
    seen = evidence.witness
    if seen is None:
        return
    yield "of", ", ".join(seen.things)
    if seen.view is not None:
        yield "seen from", seen.view
    if seen.points is not None:
        yield "measured between", f"{_point(seen.points[0])} and {_point(seen.points[1])}"
    if seen.plane is not None:
        yield (
            f"plane of its {seen.plane.bound}",
            f"{_point(seen.plane.point)} facing {_point(seen.plane.normal)}",
        )
    elif seen.normal is not None:
        yield "along", _point(seen.normal)
    yield "measured as", ", ".join(f"{thing}: {model}" for thing, model in seen.measured_as.items())


def _value(one: Value) -> tuple[str, str]:
    return one.name, amount(one.value, one.unit)


def _point(point: Point) -> str:
    return "(" + ", ".join(f"{one:.4g}" for one in point) + ")"


def _text(text: str) -> str:
    return escape(visible(text))
