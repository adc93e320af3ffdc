"""Write the page of the guide that lists what can be said: from the vocabulary and the comments of the rules.

    python tests/vocabulary_page.py

``tests/test_readme.py`` holds the page to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from deixis.vocabulary import BASE, RELATIONS, TERMS
from ontology import definitions

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "kb" / "guide" / "vocabulary.md"

HEAD = """# What can be said

Written by `python tests/vocabulary_page.py` from the comments of the rules. `help(on_top_of)` in
`deixis shell` and `deixis ontology onTopOf` say the same; [axioms.md](../axioms.md) has the paper's words.

The figure is what one speaks of, the reference what one places it by: a wall, a floor, or the not smaller of
the two ([why](../decisions/0006-figure-and-reference.md)). So one asks `near(cup, table)`, not
`near(table, cup)`.

A side of a thing is a space: as wide as the thing's box when that is turned to the viewer, and
`halfspace_scale` times as deep. What stands diagonally before a thing is on none of its sides.
[conventions.md](../conventions.md) is exact about it, and has all thresholds with their defaults.
"""


def heads() -> dict[str, str]:
    """Return each predicate with its arguments as its comment names them."""
    found = {}
    for name in ("facts", "topology", "direction", "commonsense"):
        text = (ROOT / "rules" / f"{name}.pl").read_text(encoding="utf-8")
        for head in re.findall(r"^%!  (.+?) is \w+\.$", text, re.MULTILINE):
            found[f"{head.partition('(')[0]}/{head.count(',') + 1}"] = re.sub(r"[?+-](?=[A-Z])", "", head)
    return found


def page() -> str:
    """Return the page."""
    said, written = definitions(), heads()

    def rows(keys: list[tuple[str, int | None]]) -> Iterator[str]:
        yield "| goal | means | axiom |"
        yield "|---|---|--:|"
        for key, axiom in keys:
            yield f"| `{written[key]}` | {said[key]} | {axiom or ''} |"
        yield ""

    def keyed(kinds: tuple[str, ...]) -> list[tuple[str, int | None]]:
        return [(f"{one.name}/{one.arity}", one.axiom) for one in TERMS if one.kind in kinds]

    axioms = {f"{one.name}/{one.arity}" for one in TERMS}
    given = [key for key in written if key not in axioms and key != "pair/9"]
    facts = [(key, None) for key in given if key not in ("aspect/7", "strict/5")]
    lines = [
        HEAD,
        "## Relations people speak in",
        "",
        f"What `deixis relations` gives where `--relation` does not say otherwise: {len(RELATIONS)} of them.",
        "",
        *rows(keyed(("relation",))),
        "## What they are made of",
        "",
        f"{len(BASE)} relations, given with `--relation NAME` only. Rules and questions may use them.",
        "",
        *rows(keyed(("base",))),
        "## What is measured and given",
        "",
        "For rules of your own, beside all of the above. A comparison of a measured length has a margin:",
        "`distance(A, B, D), D =< 0.3`.",
        "",
        *rows(keyed(("measure",))),
        *rows(facts),
    ]
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
