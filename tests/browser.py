"""A browser for tests: Debian's Chromium with software WebGL, and what is to be seen in it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from deixis.view import available

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-rasterization",
    "--disable-accelerated-2d-canvas",
]
"""WebGL in software, the rest drawn without it, as where there is no graphics card: four times as fast."""

needs_browser = [
    pytest.mark.skipif(not available(), reason="the page is not built: make page"),
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on the PATH"),
]

SEEN = """
(selector) => {
  const layers = [...document.querySelectorAll(selector)];
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [layers[0].width, layers[0].height];
  const drawing = copy.getContext("2d", { willReadFrequently: true });
  for (const one of layers) drawing.drawImage(one, 0, 0, copy.width, copy.height);
  const { data } = drawing.getImageData(0, 0, copy.width, copy.height);
  const counts = {};
  for (let at = 0; at < data.length; at += 4) {
    const name = [data[at], data[at + 1], data[at + 2]].join();
    counts[name] = (counts[name] ?? 0) + 1;
  }
  return { wide: copy.width, tall: copy.height, counts };
}
"""
"""How many pixels of which colour the canvases show, one drawn over the other."""


@contextmanager
def browser() -> Iterator[Browser]:
    """Run a browser for a block."""
    with sync_playwright() as player:
        running = player.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield running
        running.close()


@dataclass
class Window:
    """A page that is open, with all it asked for and complained about."""

    page: Page
    asked: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    @classmethod
    def open(
        cls, browser: Browser, address: str, *, wide: int = 1400, tall: int = 900, **given: Any
    ) -> Window:
        """Open an address and wait until the page is ready."""
        window = cls(browser.new_page(viewport={"width": wide, "height": tall}, **given))
        page = window.page
        page.on("request", lambda one: window.asked.append(one.url))
        page.on("pageerror", lambda error: window.complaints.append(str(error)))
        page.on("dialog", lambda one: (window.complaints.append(f"dialog {one.message}"), one.dismiss()))
        page.on(
            "console",
            lambda said: window.complaints.append(said.text) if said.type in ("error", "warning") else None,
        )
        page.goto(address)
        window.ready()
        return window

    def ready(self) -> None:
        """Wait until the page knows all, and has drawn it."""
        self.page.wait_for_selector("html[data-ready=yes]", timeout=30_000)
        self.drawn()

    def drawn(self) -> None:
        """Wait until what was asked of the page is drawn."""
        self.page.evaluate(
            "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )

    def click(self, selector: str, text: str | None = None) -> None:
        """Click on an element, the first with a text."""
        found = self.page.locator(selector)
        (found.filter(has_text=text) if text else found).first.click()
        self.drawn()

    def press(self, *keys: str) -> None:
        """Press keys, one after the other."""
        for key in keys:
            self.page.keyboard.press(key)
        self.drawn()

    def colours(self, selector: str = "#picture canvas") -> dict[tuple[int, int, int], int]:
        """Return how many pixels of each colour there are."""
        told = self.page.evaluate(SEEN, selector)
        return {tuple(map(int, name.split(","))): count for name, count in told["counts"].items()}

    def reddish(self) -> int:
        """Return how many pixels of the picture are as red as the figure that is lit up."""
        return sum(count for (r, g, b), count in self.colours().items() if r > g + 60 and r > b + 90)

    def bluish(self) -> int:
        """Return how many pixels of the picture are as blue as the reference that is lit up."""
        return sum(count for (r, g, b), count in self.colours().items() if b > r + 90 and b > g + 40)

    def picture(self) -> str:
        """Return the picture itself, to be compared."""
        return str(self.page.evaluate("() => document.querySelector('#picture canvas').toDataURL()"))

    def texts(self, selector: str) -> list[str]:
        """Return the texts of elements."""
        return [one.strip() for one in self.page.locator(selector).all_inner_texts()]


def saved(page: str, place: Path) -> str:
    """Write a page; return its address."""
    place.write_text(page, encoding="utf-8")
    return place.as_uri()
