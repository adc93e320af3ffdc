r"""A goal in the subset that every engine runs, answered by DuckDB: ``on_top_of(X, Y), \+ touches(X, wall)``.

The goal is read as the body of one rule by the reader of rule files, so nothing of it is ever run as Prolog
or spliced into SQL.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any, Final

from deixis.engines import AutoExecutor
from deixis.errors import QueryError
from deixis.knowledge import KnowledgeBase
from deixis.ruleset import Problem, Rule, RuleFile, assemble, read_text
from deixis.ruleset.model import Atom, Constant, Negation, atoms, variables
from deixis.vocabulary import BASE, RELATIONS

LONGEST: Final = 4096
"""Characters of a goal."""

MOST_GOALS: Final = 16
"""Parts of a goal: each may multiply the rows there are."""

_HEAD: Final = "deixis asks"
"""The predicate of the question, which no file can define by accident."""

_FILE: Final = Path("goal")


def answers(kb: KnowledgeBase, goal: str, limit: int, timeout: float) -> dict[str, Any]:
    """Return the bindings for which a goal holds.

    Raises
    ------
    QueryError
        The goal is not in the subset.
    QueryTimeout
        It took longer.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
    ...     answers(kb, "on_top_of(X, heater)", 10, 10.0)["bindings"]
    [{'X': 'sweater'}]
    """
    file, names = _question(goal)
    ruleset, problems = assemble(kb.ruleset.files, [file])
    _refuse(problems)
    labels = [(view.id, view.label) for view in kb.scene.views]
    predicate = file.rules[0].head.predicate
    with AutoExecutor(ruleset) as executor:
        table = executor.run(kb.facts, [predicate], view_labels=labels, margins=False, timeout=timeout)[
            predicate
        ]
    rows = list(islice(table.rows(), limit + 1))
    return {
        "goal": goal,
        "holds": bool(rows),
        "bindings": [dict(zip(names, row, strict=False)) for row in rows[:limit]] if names else [],
        "truncated": len(rows) > limit,
        "notes": [kb.unknown_name(name) for name in _strangers(kb, file.rules[0])],
    }


def _strangers(kb: KnowledgeBase, asked: Rule) -> list[str]:
    """Return the names that a relation is asked of and that no thing and no view has, each once."""
    relations = {(term.name, term.arity) for term in (*BASE, *RELATIONS)}
    named = (value for atom, _ in atoms(asked.body) if atom.predicate in relations for value in atom.args)
    told = dict.fromkeys(str(value.value) for value in named if isinstance(value, Constant))
    if not told:
        return []
    known = {*kb.facts.ids, *(view.id for view in kb.scene.views)}
    return [name for name in told if name not in known]


def _question(goal: str) -> tuple[RuleFile, list[str]]:
    """Return a file of one rule whose body is the goal, and its variables."""
    text = goal.strip().removesuffix(".")
    if len(text) > LONGEST:
        raise QueryError(f"the goal is longer than {LONGEST} characters: ask something shorter")
    file, problems = read_text(f"asked(nothing) :-\n{text}\n.", _FILE)
    _refuse(problems)
    if len(file.rules) != 1 or file.declared or file.module or file.imports:
        raise QueryError("ask one goal: a conjunction of relations, comparisons and \\+ of them")
    (rule,) = file.rules
    if sum(len(one.goals) if isinstance(one, Negation) else 1 for one in rule.body) > MOST_GOALS:
        raise QueryError(f"the goal has more than {MOST_GOALS} parts: ask something shorter")
    said = [one for part in rule.body if not isinstance(part, Negation) for one in variables(part)]
    told = {one.name: one for one in said if not one.anonymous}
    # A question without variables still needs a column: the constant that it was read with.
    args = tuple(told.values()) or rule.head.args
    asked = Rule(Atom(_HEAD, args, rule.head.place), rule.body)
    return RuleFile(_FILE, None, (), (), (), (asked,), {}), list(told)


def _refuse(problems: list[Problem]) -> None:
    wrong = [one for one in problems if not one.warning]
    if wrong:
        raise QueryError("; ".join(one.message + (f" ({one.hint})" if one.hint else "") for one in wrong[:3]))
