r"""Rules as values: the Datalog subset of Prolog read, checked, and put in an order that derives it.

A rule file is plain Prolog that SWI-Prolog runs as it stands. What is accepted here (facts and rules with
atoms, ``\+`` and comparisons) means the same in every engine.
"""

from deixis.ruleset.checking import Ruleset, assemble, examine, load, refuse
from deixis.ruleset.graph import Graph
from deixis.ruleset.located import SHIPPED, locate, shipped
from deixis.ruleset.model import VIOLATIONS, Indicator, Kind, Problem, Rule, RuleFile, shown
from deixis.ruleset.reading import read_file, read_text

__all__ = [
    "SHIPPED",
    "VIOLATIONS",
    "Graph",
    "Indicator",
    "Kind",
    "Problem",
    "Rule",
    "RuleFile",
    "Ruleset",
    "assemble",
    "examine",
    "load",
    "locate",
    "read_file",
    "read_text",
    "refuse",
    "shipped",
    "shown",
]
