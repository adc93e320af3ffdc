"""Which predicates are derived tile by tile, which from all tiles together, and from what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from deixis.ruleset import Indicator, Ruleset
from deixis.ruleset.base import BASE_FACTS
from deixis.ruleset.extent import THINGS
from deixis.ruleset.owning import Ownership, ownerships
from deixis.ruleset.plan import Node
from deixis.sql.program import Program


@dataclass(frozen=True)
class Cut:
    """How the work of deriving some predicates is shared.

    Attributes
    ----------
    ruleset : Ruleset
    here : tuple of Indicator
        Wanted, and derived tile by tile.
    after : tuple of Indicator
        Wanted, and derived from the union of all tiles.
    program : Program or None
        What derives those.
    nodes : tuple of Node
        Derived tile by tile for that.
    facts : tuple of Indicator
        Measured facts that it needs.
    owners : mapping
        Whose tile a row belongs to.
    links : int
        How far around a tile one has to look.
    """

    ruleset: Ruleset
    here: tuple[Indicator, ...]
    after: tuple[Indicator, ...]
    program: Program | None
    nodes: tuple[Node, ...]
    facts: tuple[Indicator, ...]
    owners: dict[Indicator, Ownership]
    links: int

    @property
    def tables(self) -> dict[str, Indicator]:
        """Return the names of the tables that the program rests on, of letters, digits and _ only."""
        if self.program is None:
            return {}
        derived = {self.program.names.tables[node]: node[0] for node in self.nodes}
        return derived | {self.program.given_tables[one]: one for one in self.facts}

    @property
    def labels(self) -> bool:
        """Return whether the labels matter to what is derived in tiles."""
        from deixis.ruleset.plan import Plan

        truth, near = self.derived()
        plan = Plan.of(self.ruleset, truth, margins=True, near=near)
        needed = {node[0] for node in plan.needed} | set(self.facts)
        return ("label", 3) in needed

    def derived(self) -> tuple[tuple[Indicator, ...], tuple[Indicator, ...]]:
        """Return what is to be derived in each tile: what holds, and how near it comes to holding."""
        truth = dict.fromkeys([*self.here, *(one for one, mode in self.nodes if mode == "truth")])
        return tuple(truth), tuple(one for one, mode in self.nodes if mode == "near")


def share_out(ruleset: Ruleset, wanted: Sequence[Indicator]) -> Cut:
    """Return how the work of deriving some predicates is shared between tiles and what comes after.

    Examples
    --------
    >>> from deixis._files import datalog_files
    >>> from deixis.ruleset import load, locate
    >>> rules = load(datalog_files(), locate(["support"], datalog_files()))
    >>> cut = share_out(rules, [("near", 2), ("supported_by", 2)])
    >>> cut.here, cut.after, cut.nodes, cut.links
    ((('near', 2),), (('supported_by', 2),), ((('held_by', 2), 'truth'),), 1)
    """
    owners = ownerships(ruleset)
    here = tuple(one for one in wanted if one in owners)
    after = tuple(one for one in wanted if one not in owners)
    program, nodes, facts = None, [], []
    if after:
        program = Program(ruleset, after, margins=True, stated=owners.keys() - BASE_FACTS.keys())
        nodes = sorted(node for node in program.needed if node[0] in program.stated)
        facts = sorted(one for one in program.given_tables if one in THINGS)
    used = {*here, *(one for one, _ in nodes), *facts}
    links = max((owners[one].links for one in used), default=0)
    return Cut(ruleset, here, after, program, tuple(nodes), tuple(facts), owners, links)
