"""The fenced blocks of README.md and of the guide, for tests: what is shown must be what is printed."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from doctest import ELLIPSIS, OutputChecker
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
PAGES = (README, *sorted((ROOT / "kb" / "guide").glob("*.md")))

_FENCED = re.compile(r"^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: on which page, of which kind, what it says."""

    page: Path
    kind: str
    text: str

    def __str__(self) -> str:
        line = self.page.read_text(encoding="utf-8").count("\n", 0, self.start())
        return f"{self.page.stem}-{line + 1}"

    def start(self) -> int:
        """Return where on its page it begins."""
        return self.page.read_text(encoding="utf-8").index(f"```{self.kind}\n{self.text}```")


def blocks(kind: str = r"\w*", page: Path | None = None) -> list[Block]:
    """Return the blocks of a kind, ``sh``, ``python`` ..., or of all: of one page or of all."""
    return [
        Block(one, found["kind"], found["text"])
        for one in (PAGES if page is None else (page,))
        for found in _FENCED.finditer(one.read_text(encoding="utf-8"))
        if re.fullmatch(kind, found["kind"])
    ]


def shown_after(block: Block) -> Block:
    """Return the text block that shows a block's output: the next one."""
    following = [one for one in blocks(page=block.page) if one.start() > block.start()]
    assert following[0].kind == "text"
    return following[0]


def check(shown: Block, printed: str) -> None:
    """Compare a text block with what was printed; ``...`` in it stands for anything.

    With ``DEIXIS_BLESS=1`` in the environment a block without ``...`` is written anew instead.
    """
    if os.environ.get("DEIXIS_BLESS") == "1" and "..." not in shown.text:
        text = shown.page.read_text(encoding="utf-8")
        written = text.replace(f"```text\n{shown.text}```", f"```text\n{printed}```", 1)
        shown.page.write_text(written, encoding="utf-8")
        return
    expected = shown.text
    if expected.endswith("...\n"):
        expected = expected.removesuffix("\n")
    assert OutputChecker().check_output(expected, printed, ELLIPSIS), f"{expected}\nis not\n{printed}"
