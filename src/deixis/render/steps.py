"""Steps: what a renderer asks of a proof, so that this layer need not know the one above it."""

from __future__ import annotations

from collections.abc import Iterator

from deixis.evidence import Unit
from deixis.steps import Step


def reasons(step: Step) -> Iterator[Step]:
    """Yield the nearest steps below that a person needs; of a negation, what came closest to refuting it."""
    for child in step.children:
        if child.shown:
            yield child
        else:
            yield from reasons(child)


def visible(text: str) -> str:
    r"""Return a text with nothing in it that is obeyed and not seen: such characters are written out.

    Examples
    --------
    >>> visible("left\u202eright\n")
    'left\\u202eright\\n'
    """
    return "".join(one if one.isprintable() else one.encode("unicode_escape").decode("ascii") for one in text)


def amount(value: float, unit: Unit) -> str:
    """Return a measured number with its unit, to the last digit that was kept.

    Examples
    --------
    >>> amount(0.04, "m"), amount(1.5e-06, "m3"), amount(1.2, "1")
    ('0.04 m', '1.5e-06 m³', '1.2')
    """
    return f"{value:.9g}{ {'m': ' m', 'm3': ' m³', '1': ''}[unit] }"
