"""The only door to SWI-Prolog: a child process that a question cannot reach out of."""

from deixis.prolog.engine import Answers, PrologEngine
from deixis.prolog.show import term_json, term_text
from deixis.prolog.terms import Atom, Compound, Term, Variable
from deixis.prolog.text import facts_text

__all__ = [
    "Answers",
    "Atom",
    "Compound",
    "PrologEngine",
    "Term",
    "Variable",
    "facts_text",
    "term_json",
    "term_text",
]
