"""Notebooks run from top to bottom without a warning; what outputs are stored is what they print."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from deixis.view import available

NOTEBOOKS = sorted((Path(__file__).resolve().parent.parent / "notebooks").glob("*.ipynb"))

SECONDS = 60.0
"""That a cell may take."""

PROMISED = {
    "00_hello_scene": [
        "on_top_of(sweater, heater): 2.0 cm to spare",
        "the fire extinguisher on the floor leans on the wall  [axiom 37]",
        "yes: the fire extinguisher on the floor is left of the radiator as seen from the robot",
        "no more: {('on_top_of', 'sweater', 'heater', '')}",
        "new:     nothing",
    ],
    "01_write_your_own_rule": [
        "mine.pl:7:5: on_top_off/2 is not defined (did you mean on_top_of/2?)",
        "within_reach towel shelf",
        "all the same: True",
        "fire_hazard: the sweater is a fire hazard on or against the electric heater",
        "5 rules checked on 13 things: 5 violations",
        "6 rules checked on 13 things: 6 violations",
        "the towel breaks the rule too_high because of the shelf",
    ],
    "02_sparql": [
        "extinguisher2  leansOn  wall",
        "robot  extinguisher2  leftOf  radiator",
        "counterexample: False",
        "extinguisher2 is left of radiator",
        "extinguisher2 0.14 m",
        "left_of extinguisher2 radiator v0 0.084",
        "403 SERVICE is switched off",
        "stopped: True",
    ],
    "03_why": [
        "The fire extinguisher on the floor leans on the wall, because",
        "but it is not affixed on the wall, because the floor touches it.",
        "sweater: 2.0 cm, and it holds: False",
        "uncertain on_top_of(sweater, heater), 2.0 cm to spare",
        "sure      left_of(extinguisher2, radiator), 8.4 cm to spare",
    ],
    "04_from_depth_to_map": [
        "bread board  3 x 25 x 36 cm, seen in 2 views",
        "toaster is on top of the table",
        "stool is on top of the floor",
        "the stool is right_of the table",
    ],
    "05_streams_and_datasets": [
        "2 s - left_of('cup','book','v0'): The cup is not left of the book",
        "9 s + on_top_of('cup','shelf'): The cup is on top of the shelf, because",
        "on the shelf since 3600.0 s after the first visit",
        "on the table after half an hour: ['book', 'cup']",
        "100 scenes, 1 refused",
        "rooms.jsonl:42 | the scene: not JSON at line 1",
        "the same: True 3778",
    ],
}
"""What each notebook prints, among other things."""


def load(path: Path) -> Any:
    notebook = nbformat.read(path, as_version=nbformat.NO_CONVERT)
    nbformat.validate(notebook)
    return notebook


def printed(notebook: Any) -> str:
    """Return all that the cells printed."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert {output.get("name", "stdout") for output in outputs} <= {"stdout"}
    return "".join(output.get("text", "") for output in outputs)


STORED = {"02_sparql"}
"""Those stored with what they print, for who reads them without running them."""


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_nothing_but_printed_text_is_stored(path: Path) -> None:
    notebook = load(path)
    assert bool(printed(notebook)) == (path.stem in STORED)
    for cell in notebook.cells:
        assert {output.output_type for output in cell.get("outputs", [])} <= {"stream"}
        assert cell.get("execution_count") is None
        assert not cell.metadata


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    notebook = load(path)
    stored = printed(notebook)
    # Not stored with it: in the test, a warning in any cell is an error.
    strict = "import warnings\nwarnings.simplefilter('error')"
    notebook.cells.insert(0, nbformat.v4.new_code_cell(strict))
    client = NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": str(path.parent)}}
    )
    client.execute()
    text = printed(notebook)
    assert stored in ("", text)
    assert [words for words in PROMISED[path.stem] if words not in text] == []
    shown = [one["data"] for cell in notebook.cells for one in cell.get("outputs", []) if "data" in one]
    if path.stem == "03_why" and available():
        assert shown[0]["text/html"].startswith("<iframe")
