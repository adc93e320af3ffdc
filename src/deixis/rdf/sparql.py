"""One rule as one SPARQL CONSTRUCT, which any triple store runs.

What goes into the text are IRIs, percent-encoded, and numbers; so no name can be read as anything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from deixis.rdf.layout import DOUBLE, NODE, TERM, TYPE, iri, is_node, term
from deixis.ruleset import Indicator, Rule, Ruleset, shown
from deixis.ruleset.model import (
    SAME,
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Expression,
    Negation,
    Variable,
)

_OPERATORS: Final = {"=<": "<=", "=:=": "=", "=\\=": "!="}


class _Variables:
    """Names of variables in SPARQL: ``_~#`` and other letters of ours do not occur there."""

    def __init__(self) -> None:
        self._known: dict[str, str] = {}

    def of(self, name: str) -> str:
        return self._known.setdefault(name, f"?v{len(self._known)}")


class RuleSparql:
    """Compiles one rule of a ruleset.

    Parameters
    ----------
    ruleset : Ruleset
    rule : Rule
    """

    def __init__(self, ruleset: Ruleset, rule: Rule) -> None:
        self._ruleset, self._rule = ruleset, rule
        self._variables = _Variables()
        self._nodes = 0

    def construct(self) -> str:
        """Return the CONSTRUCT that adds the rule's conclusions."""
        where = [self._goal(goal) for goal in self._rule.body]
        head = self._rule.head
        kinds = self._ruleset.kinds[head.predicate]
        node = "?node"
        if is_node(kinds):
            parts = [f"ENCODE_FOR_URI(STR({self._value(value)}))" for value in head.args]
            start = NODE + term(head.predicate).removeprefix(TERM)
            separated = ', ":", '.join(parts)
            where.append(f'BIND(IRI(CONCAT("{start}:", {separated})) AS {node})')
        return f"CONSTRUCT {{ {self._triples(head, node)} }}\nWHERE {{\n  " + "\n  ".join(where) + "\n}"

    def _goal(self, goal: Atom | Comparison | Negation) -> str:
        match goal:
            case Atom():
                return self._pattern(goal)
            case Comparison():
                return self._filter(goal)
            case Negation():
                inner = " ".join(self._goal(one) for one in goal.goals)
                return f"FILTER NOT EXISTS {{ {inner} }}"

    def _pattern(self, atom: Atom) -> str:
        self._nodes += 1
        return self._triples(atom, f"?n{self._nodes}")

    def _triples(self, atom: Atom, node: str) -> str:
        kinds = self._ruleset.kinds[atom.predicate]
        values = [self._value(value) for value in atom.args]
        return triples(atom.predicate, is_node(kinds), values, node)

    def _filter(self, goal: Comparison) -> str:
        left, right = self._value(goal.left), self._value(goal.right)
        if goal.operator in SAME:
            denied = "!" if goal.operator.startswith("\\") else ""
            return f"FILTER({denied}sameTerm({left}, {right}))"
        return f"FILTER({left} {_OPERATORS.get(goal.operator, goal.operator)} {right})"

    def _value(self, value: Expression) -> str:
        match value:
            case Variable():
                return self._variables.of(value.name)
            case Constant(kind="number"):
                return f'"{float(value.value)!r}"^^<{DOUBLE}>'
            case Constant():
                return f"<{iri(value.kind, str(value.value))}>"
            case Arithmetic(operator, (only,)):
                return f"({operator} {self._value(only)})"
            case Arithmetic(operator, (left, right)):
                return f"({self._value(left)} {operator} {self._value(right)})"
        raise AssertionError(value)


def triples(predicate: Indicator, node_form: bool, values: Sequence[str], node: str) -> str:
    """Return the triples of one row, as a pattern or a template."""
    name = term(predicate)
    if node_form:
        parts = [f"{node} <{TYPE}> <{name}> ."]
        parts += [f"{node} <{name}.{at}> {value} ." for at, value in enumerate(values, 1)]
        return " ".join(parts)
    if len(values) == 1:
        return f"{values[0]} <{TYPE}> <{name}> ."
    return f"{values[0]} <{name}> {values[1]} ."


def select(ruleset: Ruleset, predicate: Indicator) -> str:
    """Return the SELECT of all rows of a predicate: v1, v2 ...

    Examples
    --------
    >>> from deixis._files import rules_dir
    >>> from deixis.ruleset import load
    >>> select(load([rules_dir() / "facts.pl"]), ("surface", 1))
    'SELECT ?v1 WHERE { ?v1 <http://www.w3.org/1999/02/22-rdf-syntax-ns#type> <urn:deixis:term:surface.1> . }'
    """
    values = [f"?v{at + 1}" for at in range(predicate[1])]
    pattern = triples(predicate, is_node(ruleset.kinds[predicate]), values, "?node")
    return f"SELECT {' '.join(values)} WHERE {{ {pattern} }}"


def constructs(ruleset: Ruleset, wanted: Sequence[Indicator]) -> str:
    """Return all rules that some predicates rest on as CONSTRUCTs, in an order that derives them."""
    needed = ruleset.graph.needed(wanted)
    lines = [
        "# What each finds is to be added to the store before the next is run. A fact of the rule files is a",
        "# CONSTRUCT without conditions.",
    ]
    for component in ruleset.graph.components:
        rules = [rule for one in sorted(component & needed) for rule in ruleset.by_head.get(one, ())]
        if component & ruleset.graph.recursive:
            lines += ["", f"# Repeat the next {len(rules)} until they add nothing more."]
        for rule in rules:
            name = shown(rule.head.predicate).encode("unicode_escape").decode("ascii")
            lines += ["", f"# {name}", RuleSparql(ruleset, rule).construct()]
    return "\n".join(lines)
