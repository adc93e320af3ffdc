"""How far the relations agree with the labels of two simulators: a table to read, not a test.

    python tests/agreement.py [../shared/data]

AI2-THOR says for each thing that can be picked up which receptacles it is in or on (a surface, a container,
a holder). VirtualHome says ON, INSIDE and CLOSE. Precision and recall are over pairs of things.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from deixis.knowledge import KnowledgeBase
from deixis.readers import ithor, read, virtualhome
from deixis.relations import Relation
from deixis.scene import Scene

Pair = tuple[str, str]


@dataclass
class Score:
    """Pairs found and pairs labelled, counted; the kinds of thing in the wrong ones."""

    right: int = 0
    wrong: Counter[str] = field(default_factory=Counter)
    missed: Counter[str] = field(default_factory=Counter)

    def add(self, found: set[Pair], labelled: set[Pair], kinds: dict[str, str]) -> None:
        """Count one scene."""
        self.right += len(found & labelled)
        self.wrong.update(f"{kinds[a]} / {kinds[b]}" for a, b in found - labelled)
        self.missed.update(f"{kinds[a]} / {kinds[b]}" for a, b in labelled - found)

    @property
    def precision(self) -> float:
        return self.right / max(self.right + self.wrong.total(), 1)

    @property
    def recall(self) -> float:
        return self.right / max(self.right + self.missed.total(), 1)

    @property
    def f1(self) -> float:
        return 2 * self.precision * self.recall / max(self.precision + self.recall, 1e-9)

    def row(self, name: str) -> str:
        """Return one line of the table."""
        counts = f"{self.right + self.wrong.total():6d} {self.right + self.missed.total():6d}"
        return f"{name:<50} {counts}  {self.precision:.3f}  {self.recall:.3f}  {self.f1:.3f}"


def pairs(relations: Iterable[Relation], *names: str) -> set[Pair]:
    """Return the (figure, reference) pairs of some relations."""
    return {(one.figure, one.reference) for one in relations if one.relation in names}


def whole_of(originals: dict[str, str]) -> dict[str, str]:
    """Return for each part, by the simulator's ids, the thing it is a part of: a basin's sink.

    ``Sink|-01.99|+01.14|-00.98|SinkBasin`` is a part of ``Sink|-01.99|+01.14|-00.98``.
    """
    short = {original: name for name, original in originals.items()}
    return {
        name: short[whole]
        for name, original in originals.items()
        if original.count("|") == 4 and (whole := original.rpartition("|")[0]) in short
    }


def thor(path: Path) -> dict[str, Score]:
    """Return the scores over all rooms: as labelled, and with parts counted as their wholes."""
    scores = {"as labelled": Score(), "a basin counted as its sink": Score()}
    for scene in read("ithor", path):
        labels = ithor.parents(path, scene.id)
        kinds = {thing.id: thing.label for thing in labels}
        movable = {thing.id for thing in labels if thing.pickupable}
        receptacles = {thing.id for thing in labels if thing.receptacle}
        labelled = {(thing.id, where) for thing in labels if thing.pickupable for where in thing.receptacles}
        with KnowledgeBase(scene) as kb:
            relations = kb.relations(relation=["on_top_of", "inside", "part_in", "affixed_on"])
        found = {
            (a, b)
            for a, b in pairs(relations, "on_top_of", "inside", "part_in", "affixed_on")
            if a in movable and b in receptacles
        }
        scores["as labelled"].add(found, labelled, kinds)
        whole = whole_of(ithor.original_ids(path, scene.id))
        scores["a basin counted as its sink"].add(
            {(a, whole.get(b, b)) for a, b in found}, {(a, whole.get(b, b)) for a, b in labelled}, kinds
        )
    return scores


def homes(paths: Iterable[Path]) -> dict[str, Score]:
    """Return the scores over the VirtualHome scenes, for each of their relations."""
    scores = {name: Score() for name in ("ON / on_top_of", "INSIDE / inside or part_in", "CLOSE / near")}
    for path in paths:
        (scene,) = read("virtualhome", path)
        scene = closer(scene, 1.5)
        kinds = {thing.id: thing.label for thing in scene.objects}
        surfaces = {thing.id for thing in scene.objects if thing.kind == "surface"}
        labels: dict[str, set[Pair]] = {}
        for figure, relation, reference in virtualhome.edges(path):
            labels.setdefault(relation, set()).add((figure, reference))
        with KnowledgeBase(scene) as kb:
            relations = kb.relations(relation=["on_top_of", "inside", "part_in", "near"])
        scores["ON / on_top_of"].add(pairs(relations, "on_top_of"), labels.get("ON", set()), kinds)
        scores["INSIDE / inside or part_in"].add(
            pairs(relations, "inside", "part_in"), labels.get("INSIDE", set()), kinds
        )
        scores["CLOSE / near"].add(
            unordered(pairs(relations, "near"), surfaces), unordered(labels["CLOSE"], surfaces), kinds
        )
    return scores


def unordered(found: set[Pair], surfaces: set[str]) -> set[Pair]:
    """Return pairs of things, not surfaces, in one order: CLOSE is symmetric."""
    return {(min(pair), max(pair)) for pair in found if not surfaces & set(pair)}


def closer(scene: Scene, closeness: float) -> Scene:
    """Return a scene read with another T: VirtualHome calls 1.5 m close."""
    return replace(scene, thresholds=replace(scene.thresholds, closeness=closeness))


def main(data: Path) -> None:
    """Print the table."""
    print(f"{'labels / relations':<50} {'found':>6} {'labels':>6}  {'P':<5}  {'R':<5}  {'F1':<5}")
    tables = [("THOR, 13 rooms", thor(data / "ithor" / "scenes.jsonl"))]
    tables.append(("VirtualHome, 2 homes", homes(sorted((data / "virtualhome").glob("*_graph.json")))))
    for title, scores in tables:
        for name, score in scores.items():
            print(score.row(f"{title}: {name}"))
    for title, scores in tables:
        for name, score in scores.items():
            print(f"\n{title}: {name}")
            for word, counts in (("found, not labelled", score.wrong), ("labelled, not found", score.missed)):
                listed = "; ".join(f"{kinds} ({count})" for kinds, count in counts.most_common(8))
                print(f"  {word}: {listed or 'none'}")


if __name__ == "__main__":
    here = Path(__file__).resolve().parent.parent
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else here.parent / "shared" / "data")
