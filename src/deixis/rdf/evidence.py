"""Evidence as quads: what a leaf of a proof measured and compared, and what there is to be seen of it."""

from __future__ import annotations

from typing import Final

from deixis.evidence import Evidence, Point, Witness
from deixis.rdf.layout import TERM
from deixis.rdf.names import SceneNames
from deixis.rdf.namespaces import GEO
from deixis.rdf.quads import GraphWriter

_QUANTITY: Final = TERM + "quantity"
_VALUE: Final = TERM + "value"
_THRESHOLD: Final = TERM + "threshold"
_COMPARED: Final = TERM + "comparedWith"
_WITNESS: Final = TERM + "witness"
_TAKEN_FROM: Final = TERM + "takenFrom"
_DIRECTION: Final = TERM + "direction"
_BOUND: Final = TERM + "bound"
_SEEN_FROM: Final = TERM + "seenFrom"
_AS_WKT: Final = GEO + "asWKT"
_WKT: Final = GEO + "wktLiteral"


def write_evidence(to: GraphWriter, iri: str, found: Evidence, names: SceneNames) -> None:
    """Write what a step rests on: a number and a threshold where it has one of each, and the geometry."""
    if len(found.values) == 1:
        (one,) = found.values
        to.text(iri, _QUANTITY, one.name)
        to.number(iri, _VALUE, one.value)
    if len(found.thresholds) == 1:
        (one,) = found.thresholds
        to.text(iri, _THRESHOLD, one.name)
        to.number(iri, _COMPARED, one.value)
    if found.witness is not None:
        _write_witness(to, iri, found.witness, names)


def _write_witness(to: GraphWriter, iri: str, seen: Witness, names: SceneNames) -> None:
    if seen.view is not None:
        to.link(iri, _SEEN_FROM, names.view(seen.view))
    if seen.points is None:
        return
    node = f"{iri}:witness"
    to.link(iri, _WITNESS, node)
    to.literal(node, _AS_WKT, f"<{names.frame}> {_wkt(*seen.points)}", _WKT)
    models = dict.fromkeys(seen.measured_as[thing] for thing in seen.things)
    to.text(iri, _TAKEN_FROM, ", ".join(models))
    facing = seen.normal if seen.plane is None else seen.plane.normal
    if facing is not None:
        to.text(iri, _DIRECTION, _numbers(facing))
    if seen.plane is not None:
        to.text(iri, _BOUND, seen.plane.bound)


def _wkt(one: Point, other: Point) -> str:
    """Return the line between two points; where they are the same, the point: no line has length 0."""
    if one == other:
        return f"POINT Z ({_numbers(one)})"
    return f"LINESTRING Z ({_numbers(one)}, {_numbers(other)})"


def _numbers(point: Point) -> str:
    return " ".join(map(repr, point))
