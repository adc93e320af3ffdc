"""The README's figures of agreement with other people's labels are what ``tests/agreement.py`` finds."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO

import pytest

import agreement
from readme import README, blocks, check

DATA = README.parent.parent / "shared" / "data"

LEAST = {"THOR, 13 rooms: as labelled": 0.90, "VirtualHome, 2 homes: CLOSE / near": 0.95}
"""F1 that is not to be lost."""


@pytest.mark.skipif(
    not ((DATA / "ithor" / "scenes.jsonl").exists() and (DATA / "virtualhome").exists()),
    reason="the simulators' labels, ../shared/data/ithor and ../shared/data/virtualhome, are not here",
)
def test_the_readme_tells_how_far_the_relations_agree() -> None:
    with redirect_stdout(StringIO()) as printed:
        agreement.main(DATA)
    table = [line.rstrip() for line in printed.getvalue().split("\n\n")[0].splitlines()]
    figures = {line[:50].rstrip(): line.split()[-3:] for line in table}

    (shown,) = (block for block in blocks("text") if block.text.startswith("labels / relations "))
    check(shown, "\n".join([*table, ""]))
    text = " ".join(README.read_text(encoding="utf-8").split())
    said = re.search(r"precision (\.\d+), recall (\.\d+), F1 (\.\d+)\.", text)
    assert said is not None
    assert [f"0{figure}" for figure in said.groups()] == figures["THOR, 13 rooms: as labelled"]
    assert {name: figures[name] for name, least in LEAST.items() if float(figures[name][2]) < least} == {}
