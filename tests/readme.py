"""The README's fenced blocks, for tests: what is shown must be what is printed."""

from __future__ import annotations

import os
import re
from doctest import ELLIPSIS, OutputChecker
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"

_FENCED = re.compile(r"^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(kind: str) -> list[re.Match[str]]:
    """Return the blocks of a kind: ``sh``, ``python`` ..."""
    return [one for one in _FENCED.finditer(README.read_text(encoding="utf-8")) if one["kind"] == kind]


def shown_after(block: re.Match[str]) -> re.Match[str]:
    """Return the text block that shows a block's output: the next one."""
    following = _FENCED.search(block.string, block.end())
    assert following is not None
    assert following["kind"] == "text"
    return following


def check(shown: re.Match[str], printed: str) -> None:
    """Compare a text block with what was printed; ``...`` in it stands for anything.

    With ``DEIXIS_BLESS=1`` in the environment a block without ``...`` is written anew instead.
    """
    if os.environ.get("DEIXIS_BLESS") == "1" and "..." not in shown["text"]:
        text = README.read_text(encoding="utf-8")
        README.write_text(text.replace(shown[0], f"```text\n{printed}```", 1), encoding="utf-8")
        return
    expected = shown["text"]
    if expected.endswith("...\n"):
        expected = expected.removesuffix("\n")
    assert OutputChecker().check_output(expected, printed, ELLIPSIS), f"{expected}\nis not\n{printed}"
