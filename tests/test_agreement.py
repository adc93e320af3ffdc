"""The README's figures of agreement with other people's labels are what ``tests/agreement.py`` finds."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO

import pytest

import agreement
from readme import README, blocks, check

DATA = README.parent.parent / "shared" / "data"

pytestmark = [
    pytest.mark.skipif(
        not ((DATA / "ithor" / "scenes.jsonl").exists() and (DATA / "virtualhome").exists()),
        reason="the simulators' labels, ../shared/data/ithor and ../shared/data/virtualhome, are not here",
    ),
    # One table for all, made once, in one worker.
    pytest.mark.xdist_group("agreement"),
]


@pytest.fixture(scope="module")
def table() -> str:
    """Return the table, without the confusions below it."""
    with redirect_stdout(StringIO()) as printed:
        agreement.main(DATA)
    return printed.getvalue().split("\n\n")[0] + "\n"


def test_the_readme_prints_the_table(table: str) -> None:
    (shown,) = (block for block in blocks("text") if block["text"].startswith("labels / relations "))
    check(shown, re.sub(" +$", "", table, flags=re.MULTILINE))


def test_the_readme_says_what_the_table_says(table: str) -> None:
    text = " ".join(README.read_text(encoding="utf-8").split())
    said = re.search(r"precision (\.\d+), recall (\.\d+), F1 (\.\d+)\.", text)
    assert said is not None
    (row,) = (line for line in table.splitlines() if line.startswith("THOR, 13 rooms: as labelled "))
    assert [f"0{figure}" for figure in said.groups()] == row.split()[-3:]


def test_agreement_is_good_enough(table: str) -> None:
    least = {"THOR, 13 rooms: as labelled": 0.90, "VirtualHome, 2 homes: CLOSE / near": 0.95}
    for name, f1 in least.items():
        (row,) = (line for line in table.splitlines() if line.startswith(name + " "))
        assert float(row.split()[-1]) >= f1
