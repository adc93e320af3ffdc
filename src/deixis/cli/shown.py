"""Relations on stdout, in every format."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from deixis.cli.output import RelationFormat, records, warn, write_csv, write_json, write_table

if TYPE_CHECKING:
    from deixis.engines import Engine
    from deixis.knowledge import KnowledgeBase
    from deixis.relations import Relation

_RDF: Final = (RelationFormat.TTL, RelationFormat.TRIG, RelationFormat.NQ, RelationFormat.JSONLD)

_COLUMNS: Final = ("relation", "figure", "reference", "view", "margin")


def show_relations(
    kb: KnowledgeBase,
    output: RelationFormat,
    *,
    view: str | None,
    relation: Sequence[str] | None,
    timeout: float,
    engine: Engine,
) -> tuple[Relation, ...]:
    """Print the relations that hold; say on stderr how many hold by little. Return them."""
    found = kb.relations(view=view, relation=relation, timeout=timeout, engine=engine)
    if output is RelationFormat.JSON:
        write_json(
            {
                "scene": kb.scene.id,
                "measured_as": kb.measured_as,
                "relations": [one.to_dict() for one in found],
                "withheld": [one.to_dict() for one in kb.withheld if view in (None, one.view)],
            }
        )
    elif output is RelationFormat.PL:
        for one in found:
            sys.stdout.write(one.to_prolog() + ".\n")
    elif output in _RDF:
        from deixis.rdf.export import relations_text

        sys.stdout.write(relations_text(kb, found, output.value))
    else:
        rows = records(_COLUMNS, [one.to_dict() for one in found])
        (write_csv if output is RelationFormat.CSV else write_table)(_COLUMNS, rows)
    noise = kb.scene.thresholds.pose_noise
    unsure = sum(one.margin is not None and one.margin < noise for one in found)
    if output is RelationFormat.TABLE and unsure:
        warn([f"{unsure} of {len(found)} hold by less than the pose noise of {noise * 100:g} cm"])
    return found
