"""The demonstration: Figure 3 of the paper and its introduction, in relations and reasons."""

from __future__ import annotations

from deixis._files import kb_dir
from deixis.cli.output import write_table
from deixis.knowledge import KnowledgeBase

TELLING = ("on_top_of", "leans_on", "affixed_on", "part_in", "inside", "left_of", "right_of", "near")


def run() -> None:
    """Print the relations of ``kb/scenes/hans.json`` and the reasons for three of them."""
    path = kb_dir() / "scenes" / "hans.json"
    with KnowledgeBase.from_scene(path) as kb:
        surfaces = {thing.id for thing in kb.scene.objects if thing.kind == "surface"}
        found = [
            one
            for one in kb.relations(relation=TELLING)
            if not (one.relation == "near" and one.reference in surfaces)
        ]
        things = ", ".join(thing.id for thing in kb.scene.objects)
        views = " and ".join(f"{view.id} ({view.label})" for view in kb.scene.views)
        print(f"Scene {kb.scene.id}: {things}; seen from {views}.\n")
        write_table(
            ("relation", "figure", "reference", "view", "margin"),
            [(one.relation, one.figure, one.reference, one.view, one.margin) for one in found],
        )
        for goal in (
            "leans_on(extinguisher2, wall)",
            "affixed_on(sign, wall)",
            "on_top_of(sweater, heater)",
        ):
            proof = kb.why(goal).proof
            if proof is not None:
                print(f"\nWhy {goal}?\n{proof.sentence()}")
    print("\nNext: deixis why kb/scenes/hans.json 'leans_on(extinguisher2, wall)'")
