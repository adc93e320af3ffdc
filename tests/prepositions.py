"""How far the words of ``rules/prepositions.pl`` agree with what people say of small scenes: a table.

    python tests/prepositions.py [../shared/data]

For each tabletop scene people were asked which of nine prepositions fit a figure and a ground; one of them
counts as theirs where more than half of those asked accepted it. All rows of labels.csv are candidates.
``one person`` is how well one of them agrees with the majority of the others (from the data's README).
``without one`` is the lowest and highest F1 with any one scene left out: how much hangs on a single scene.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import trimesh

from deixis._files import datalog_files, rules_dir
from deixis.facts import REGION_MODELS, RegionModel
from deixis.grounding import ground
from deixis.ruleset import load as load_rules
from deixis.scene import BoxRegion, Label, MeshRegion, Region, Scene, SpatialObject, View
from deixis.sql import SqlExecutor

ONE_PERSON = {
    "in": 0.87,
    "inside": 0.72,
    "on": 0.84,
    "on top of": 0.72,
    "above": 0.64,
    "over": 0.33,
    "below": 0.62,
    "under": 0.72,
    "against": 0.76,
}
"""F1 of one person against the majority of the others, by word."""

WORDS = tuple(ONE_PERSON)

DATA = Path(__file__).resolve().parent.parent.parent / "shared" / "data"

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

    def without(self, scene: str) -> Score:
        """Return the score of the other scenes."""
        return Score(
            {pair for pair in self.found if pair[0] != scene},
            {pair for pair in self.labelled if pair[0] != scene},
        )

    def without_one(self) -> tuple[float, float]:
        """Return the least and the greatest F1 with any one scene left out."""
        scenes = {pair[0] for pair in self.found | self.labelled} | {""}
        values = [self.without(scene).f1 for scene in scenes]
        return min(values), max(values)


def labels(data: Path) -> dict[str, list[dict[str, str]]]:
    """Return what people said, by scene."""
    found: dict[str, list[dict[str, str]]] = {}
    with (data / "prepositions" / "labels.csv").open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            found.setdefault(line["scene"], []).append(line)
    return found


def scores(data: Path, regions: Iterable[RegionModel] = REGION_MODELS) -> dict[RegionModel, dict[str, Score]]:
    """Return how well each word is met over all scenes, by what things are measured as."""
    result = {region: {word: Score(set(), set()) for word in WORDS} for region in regions}
    with SqlExecutor(load_rules(datalog_files(), [rules_dir() / "prepositions.pl"])) as executor:
        for name, lines in labels(data).items():
            scene = load(data / "prepositions" / "scenes" / f"{name}.json")
            for region, by_word in result.items():
                tables = executor.run(ground(scene, region=region), [("fits", 3)], margins=False)
                fits = set(tables["fits", 3].rows())
                for line in lines:
                    pair = (name, line["figure"], line["ground"])
                    for word, score in by_word.items():
                        if (word, *pair[1:]) in fits:
                            score.found.add(pair)
                        if 2 * int(line[word]) > int(line["n_annotators"]):
                            score.labelled.add(pair)
    return result


def main(data: Path) -> None:
    """Print the table, then which pairs meshes get wrong."""
    tables = scores(data)
    heads = "  ".join(f"{region + ' P':>6} {'R':>4} {'F1':>4}" for region in tables)
    print(f"{'word':<10} {'labels':>6}  {heads}  {'without one':>11}  one person")
    for word in WORDS:
        cells = (
            f"{one[word].precision:6.2f} {one[word].recall:4.2f} {one[word].f1:4.2f}"
            for one in tables.values()
        )
        least, most = tables["mesh"][word].without_one()
        count = len(tables["box"][word].labelled)
        print(f"{word:<10} {count:>6}  {'  '.join(cells)}  {least:6.2f}-{most:.2f}  {ONE_PERSON[word]:10.2f}")
    for word, score in tables["mesh"].items():
        for title, pairs in (
            ("wrong", score.found - score.labelled),
            ("missed", score.labelled - score.found),
        ):
            listed = "; ".join(" / ".join(pair) for pair in sorted(pairs))
            print(f"mesh, {word}, {title}: {listed or 'none'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DATA)
