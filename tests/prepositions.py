"""How far region models agree with what people say of small tabletop scenes: a table.

    python tests/prepositions.py [../shared/data]

For each scene people were asked which of nine prepositions fit a figure and a ground; a preposition counts as
theirs where more than half of those asked accepted it. All rows of labels.csv are candidates. What each word
is read as here:

==============  =========================================================================================
in, inside      inside, or part_in
on              on_top_of
on top of       on_top_of, and the figure reaches higher than the ground: a mug within a shelf is on it
above, over     above, and apart: neither touching nor overlapping
below, under    below
against         touches, and neither is above the other: leaning, affixed, or beside
==============  =========================================================================================

People also place a larger thing by a smaller one ("the table is below the balloon"), which the theory's
conclusions never do. So each relation is read off the base relations in the order that people were asked:
above_r, below_r and touches, compl_cont and the two cardinalities of axiom 40. For pairs in figure-reference
order these are the conclusions themselves (axioms 19, 28, 29, 36, 40).
"""

from __future__ import annotations

import csv
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from deixis.facts import REGION_MODELS, Facts, RegionModel
from deixis.grounding import ground
from deixis.scene import BoxRegion, Label, MeshRegion, Region, Scene, SpatialObject, View

WORDS = ("in", "inside", "on", "on top of", "above", "over", "below", "under", "against")

Pair = tuple[str, str, str]


def load(path: Path) -> Scene:
    """Return a scene of the study: things with their meshes, floor, walls and ceiling as thin boxes."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    things = []
    for one in data["objects"]:
        region: Region
        if one["kind"] == "structure":
            box = one["obb"]
            region = BoxRegion(box["center"], box["size"], box["yaw_rad"])
        else:
            mesh: Any = trimesh.load_mesh(path.parent.parent / one["mesh"], process=False)
            region = MeshRegion(mesh.vertices, mesh.faces)
        kind = "surface" if one["kind"] == "structure" else "object"
        things.append(SpatialObject(one["id"], (Label(one["label"]),), kind, region))
    views = (View(f"v{number}", "camera", seen["position"]) for number, seen in enumerate(data["cameras"]))
    return Scene(data["scene"], tuple(things), tuple(views))


@dataclass
class Score:
    """Pairs found and pairs labelled."""

    found: set[Pair]
    labelled: set[Pair]

    @property
    def precision(self) -> float:
        return len(self.found & self.labelled) / max(len(self.found), 1)

    @property
    def recall(self) -> float:
        return len(self.found & self.labelled) / max(len(self.labelled), 1)

    @property
    def f1(self) -> float:
        return 2 * self.precision * self.recall / max(self.precision + self.recall, 1e-9)


def words_of(scene: Scene, facts: Facts, figure: str, ground: str) -> set[str]:
    """Return the words that fit a figure and a ground."""
    row, back = facts.row(figure, ground), facts.row(ground, figure)
    if row is None or back is None:
        return set()
    above, below = (bool(facts.vertical[row, side] >= 0.0) for side in (0, 1))
    touches = bool(facts.touches[row])
    tops = scene.boxes.center[:, 2] + scene.boxes.half[:, 2]
    higher = bool(np.greater(*(tops[facts.ids.index(name)] for name in (figure, ground))))
    part = bool(facts.intersects[row] and facts.frontier[row] < facts.frontier[back])
    found = set()
    if facts.compl_cont[row] or part:
        found |= {"in", "inside"}
    if above and touches:
        found |= {"on", "on top of"} if higher else {"on"}
    if above and facts.separation[row] > facts.thresholds.granularity:
        found |= {"above", "over"}
    if below:
        found |= {"below", "under"}
    if touches and not above and not below:
        found.add("against")
    return found


def scores(data: Path, region: RegionModel) -> dict[str, Score]:
    """Return how well each word is met over all scenes."""
    labels: dict[str, list[dict[str, str]]] = {}
    with (data / "prepositions" / "labels.csv").open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            labels.setdefault(line["scene"], []).append(line)
    result = {word: Score(set(), set()) for word in WORDS}
    for name, lines in labels.items():
        scene = load(data / "prepositions" / "scenes" / f"{name}.json")
        facts = ground(scene, region=region)
        for line in lines:
            pair = (name, line["figure"], line["ground"])
            words = words_of(scene, facts, pair[1], pair[2])
            for word in WORDS:
                if word in words:
                    result[word].found.add(pair)
                if 2 * int(line[word]) > int(line["n_annotators"]):
                    result[word].labelled.add(pair)
    return result


def main(data: Path) -> None:
    """Print the table, then which pairs meshes get wrong."""
    tables = {region: scores(data, region) for region in REGION_MODELS}
    heads = "  ".join(f"{region + ' P':>6} {'R':>4} {'F1':>4}" for region in tables)
    print(f"{'word':<10} {'labels':>6}  {heads}")
    for word in WORDS:
        cells = (
            f"{one[word].precision:6.2f} {one[word].recall:4.2f} {one[word].f1:4.2f}"
            for one in tables.values()
        )
        print(f"{word:<10} {len(tables['box'][word].labelled):>6}  {'  '.join(cells)}")
    for word, score in tables["mesh"].items():
        for title, pairs in (
            ("wrong", score.found - score.labelled),
            ("missed", score.labelled - score.found),
        ):
            listed = "; ".join(" / ".join(pair) for pair in sorted(pairs))
            print(f"mesh, {word}, {title}: {listed or 'none'}")


if __name__ == "__main__":
    beside = Path(__file__).resolve().parent.parent.parent / "shared" / "data"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else beside)
