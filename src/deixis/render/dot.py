"""DOT: a proof as a graph for Graphviz, a step that serves twice drawn once."""

from __future__ import annotations

from collections.abc import Iterable
from textwrap import wrap
from typing import Final

from deixis.render.steps import amount, reasons, visible
from deixis.steps import Step

_SHAPES: Final = {
    "rule": "box",
    "fact": "box",
    "comparison": "ellipse",
    "negation": "octagon",
    "conjunction": "box",
}

_WIDTH: Final = 36
"""Characters in a line of a label."""


def dot(proofs: Iterable[Step], name: str = "why") -> str:
    r"""Return proofs as a directed graph in the DOT language, from conclusions to reasons.

    Examples
    --------
    >>> from deixis.explain import Proof
    >>> leaf = Proof("fact", "gap", (), 'the gap of the "cup" is 1 cm', 0.01, None, None, True, ())
    >>> print(dot([leaf]))
    digraph "why" {
      graph [rankdir=TB];
      node [fontname="Helvetica,Arial,sans-serif", fontsize=11];
      n0 [shape=box, label="the gap of the \"cup\" is 1 cm\n0.01 m"];
    }
    """
    drawing = _Drawing()
    for proof in proofs:
        drawing.draw(proof)
    lines = "".join(f"  {line};\n" for line in (*drawing.nodes, *drawing.edges))
    head = f"digraph {_quoted([name])} {{\n  graph [rankdir=TB];\n"
    return head + '  node [fontname="Helvetica,Arial,sans-serif", fontsize=11];\n' + lines + "}"


class _Drawing:
    def __init__(self) -> None:
        self.nodes: list[str] = []
        self.edges: dict[str, None] = {}
        self._known: dict[tuple[object, ...], int] = {}

    def draw(self, step: Step) -> int:
        """Draw a step and all below it, unless it is there; return its number."""
        place = None if step.rule is None else (step.rule.file, step.rule.line)
        key = (step.kind, step.predicate, step.args, step.text, step.margin, place)
        # The same two numbers may be compared of other things.
        named = any(isinstance(one, str) for one in step.args)
        if named and key in self._known:
            return self._known[key]
        number = self._known[key] = len(self.nodes)
        failed = step.margin is not None and step.margin < 0.0
        style = ", style=dashed" if failed else ""
        self.nodes.append(f"n{number} [shape={_SHAPES[step.kind]}{style}, label={_quoted(_lines(step))}]")
        for reason in reasons(step):
            # What came closest to refuting a negation is no reason of it.
            style = " [style=dotted]" if step.kind == "negation" else ""
            self.edges[f"n{number} -> n{self.draw(reason)}{style}"] = None
        return number


def _lines(step: Step) -> list[str]:
    """Return what stands in a node: the sentence, then where the rule is and what there is to spare."""
    notes = [] if step.rule is None else [f"{step.rule.file}:{step.rule.line}"]
    if step.axiom is not None and step.rule is not None:
        notes.insert(0, f"axiom {step.axiom}")
    if step.margin is not None:
        notes.append(amount(step.margin, "m"))
    said = wrap(visible(step.text), _WIDTH, break_long_words=True, break_on_hyphens=False) or [""]
    return [*said, ", ".join(notes)] if notes else said


def _quoted(lines: Iterable[str]) -> str:
    """Return lines as a DOT string: neither its escapes nor its character references are obeyed."""
    escaped = (
        visible(line).replace("&", "&amp;").replace("\\", "\\\\").replace('"', '\\"') for line in lines
    )
    return '"' + "\\n".join(escaped) + '"'
