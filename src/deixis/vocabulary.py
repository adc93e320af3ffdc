"""The vocabulary: one table for the paper's words, ours, and what each is.

Tests hold the rule files, the sentences, ``rules/axioms.pl`` and ``kb/axioms.md`` to it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

Kind = Literal["measure", "base", "relation"]


@dataclass(frozen=True, slots=True)
class Term:
    """One predicate of the theory.

    Attributes
    ----------
    axiom : int
        The paper's number, counted through its equations.
    paper : str
        The paper's name.
    name : str
        Ours, in Python, in Prolog and on the command line.
    arity : int
        Of the Prolog predicate.
    rdf : str
        Local name of the RDF property.
    kind : {"measure", "base", "relation"}
        A measured quantity; a relation that others are made of, for both orders of a pair (the horizontal
        cardinal ones in figure-reference order only); a relation people speak in, in that order too.
    view : bool
        Whether it depends on where one stands; then the last argument is the view.
    """

    axiom: int
    paper: str
    name: str
    arity: int
    rdf: str
    kind: Kind
    view: bool = False


TERMS: Final = (
    Term(1, "SpatialObj", "spatial_obj", 1, "SpatialObject", "measure"),
    Term(14, "distance", "distance", 3, "distance", "measure"),
    Term(15, "IsClose", "is_close", 2, "isClose", "base"),
    Term(16, "Touches", "touches", 2, "touches", "base"),
    Term(17, "Int", "intersects", 2, "intersects", "base"),
    Term(18, "inter", "intersection", 3, "intersection", "measure"),
    Term(19, "ComplCont", "compl_cont", 2, "completelyContains", "base"),
    Term(20, "hs", "halfspace", 5, "halfspace", "measure"),
    Term(21, "E_s", "east_s", 2, "eastStrict", "base"),
    Term(21, "W_s", "west_s", 2, "westStrict", "base"),
    Term(21, "N_s", "north_s", 2, "northStrict", "base"),
    Term(21, "S_s", "south_s", 2, "southStrict", "base"),
    Term(21, "A_s", "above_s", 2, "aboveStrict", "base"),
    Term(21, "B_s", "below_s", 2, "belowStrict", "base"),
    Term(22, "E_r", "east_r", 2, "eastRelaxed", "base"),
    Term(23, "W_r", "west_r", 2, "westRelaxed", "base"),
    Term(24, "N_r", "north_r", 2, "northRelaxed", "base"),
    Term(25, "S_r", "south_r", 2, "southRelaxed", "base"),
    Term(26, "A_r", "above_r", 2, "aboveRelaxed", "base"),
    Term(27, "B_r", "below_r", 2, "belowRelaxed", "base"),
    Term(28, "Above", "above", 2, "above", "relation"),
    Term(29, "Below", "below", 2, "below", "relation"),
    Term(30, "Int(hs, sReg)", "int_hs", 4, "meetsHalfspace", "measure"),
    Term(30, "ComplCont(hs, sReg)", "cont_hs", 4, "withinHalfspace", "measure"),
    Term(31, "RightOf", "right_of", 3, "rightOf", "relation", view=True),
    Term(32, "LeftOf", "left_of", 3, "leftOf", "relation", view=True),
    Term(33, "InFrontOf", "in_front_of", 3, "inFrontOf", "relation", view=True),
    Term(34, "Behind", "behind", 3, "behind", "relation", view=True),
    Term(35, "Beside", "beside", 3, "beside", "relation", view=True),
    Term(36, "OnTopOf", "on_top_of", 2, "onTopOf", "relation"),
    Term(37, "LeansOn", "leans_on", 2, "leansOn", "relation"),
    Term(38, "AffixedOn", "affixed_on", 2, "affixedOn", "relation"),
    Term(39, "adjSRCard", "adj_sr_card", 3, "adjacentCardinality", "measure"),
    Term(40, "PartIn", "part_in", 2, "partIn", "relation"),
    Term(19, "Inside", "inside", 2, "inside", "relation"),
    Term(15, "Near", "near", 2, "near", "relation"),
)
"""Every predicate that encodes an axiom, in the paper's order; the words for "in" and "near" last."""

BY_NAME: Final = {term.name: term for term in TERMS}

RELATIONS: Final = tuple(term for term in TERMS if term.kind == "relation")
"""The relations people speak in."""

BASE: Final = tuple(term for term in TERMS if term.kind == "base")
"""The relations they are made of."""


def asked_for(relation: str | Iterable[str] | None) -> list[str]:
    """Return the names of relations that are asked for, each once; by default all that people speak in.

    A string is one name: it is iterable too, and its letters are never meant.

    Examples
    --------
    >>> asked_for("near"), asked_for(["near", "above", "near"]), len(asked_for(None)) == len(RELATIONS)
    (['near'], ['near', 'above'], True)
    """
    if relation is None:
        return [term.name for term in RELATIONS]
    return [relation] if isinstance(relation, str) else list(dict.fromkeys(relation))
