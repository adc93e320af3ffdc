"""Take the pictures of the page that the README shows.

    python tests/screenshots.py

writes ``kb/pictures/page.png`` and ``page-dark.png``; a test checks that they are current. Needs `make page`
and Chromium.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from playwright.sync_api import Browser

from browser import Window, browser, saved
from deixis import KnowledgeBase

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "kb" / "pictures"

SHOTS = {
    "page": ("hans", "light", "thing=extinguisher2&relation=left_of%2Cextinguisher2%2Cradiator%2Cv0&step=1"),
    "page-dark": ("kitchen", "dark", "thing=bread1&relation=on_top_of%2Cbread1%2Ccounter_top2"),
}
"""Of each picture the scene, the theme, and what is selected."""


def shot(browser: Browser, name: str, folder: Path) -> bytes:
    """Return a picture, as a PNG."""
    scene, theme, selected = SHOTS[name]
    with KnowledgeBase.from_scene(ROOT / "kb" / "scenes" / f"{scene}.json") as kb:
        address = saved(kb.page(), folder / f"{scene}.html")
    window = Window.open(browser, f"{address}#{selected}", wide=1200, tall=720, color_scheme=theme)
    if theme == "light":
        window.click("#closer")
    window.page.mouse.move(600, 660)
    window.page.wait_for_timeout(500)
    window.drawn()
    picture = window.page.screenshot()
    window.page.close()
    return picture


if __name__ == "__main__":
    with browser() as running, tempfile.TemporaryDirectory() as folder:
        for name in SHOTS:
            (PICTURES / f"{name}.png").write_bytes(shot(running, name, Path(folder)))
