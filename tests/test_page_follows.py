"""The page that a server sends follows the scene: in a browser, while updates come."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser

from browser import Window, browser, needs_browser
from endpoint import HANS, Server, serving, start
from scenes import box

pytestmark = [*needs_browser, pytest.mark.xdist_group("browser")]

LEANS = "relation=leans_on%2Cextinguisher2%2Cwall"
HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as running:
        yield running


@pytest.fixture
def server() -> Iterator[Server]:
    with serving(HANS, "--writable") as running:
        yield running


@pytest.fixture
def window(chromium: Browser, server: Server) -> Iterator[Window]:
    opened = Window.open(chromium, f"{server.url}/scenes/hans/view")
    signed(opened, "live")
    yield opened
    assert opened.complaints == []
    assert all(one.startswith(server.url) for one in opened.asked)
    opened.page.close()


def signed(window: Window, text: str) -> None:
    """Wait until the page says how it stands."""
    window.page.wait_for_function(
        "(text) => document.getElementById('live').textContent === text", arg=text, timeout=30_000
    )


def shows(window: Window, event: str) -> None:
    """Wait until the page shows what an event made."""
    window.page.wait_for_function(
        "(event) => document.documentElement.dataset.event === event", arg=event, timeout=30_000
    )
    window.drawn()


def tell(server: Server, window: Window | None = None, **update: Any) -> dict[str, Any]:
    reply = server.change("hans", update)
    assert reply.status == 200, reply.body
    if window is not None:
        shows(window, reply.json["event"])
    return dict(reply.json)


def test_what_changes_is_said_and_marked(server: Server, window: Window) -> None:
    picture = window.picture()
    found = tell(server, window, moves={"sweater": [0, 0, 0.1]})
    assert [one["relation"] for one in found["lost"]] == ["on_top_of"]
    assert window.texts("#news p") == ["The sweater is on top of the electric heater"]
    assert window.texts("#count") == ["38 of 44"]
    assert "44 relations" in window.texts("#summary")[0]
    assert window.picture() != picture
    assert window.page.locator(".row.fresh").count() == 0
    tell(server, window, moves={"sweater": [0, 0, -0.1]})
    assert window.picture() == picture
    assert window.texts(".row.fresh .says") == ["The sweater is on top of the electric heater"]
    window.page.wait_for_selector("#news", state="hidden", timeout=20_000)
    assert window.page.locator(".row.fresh").count() == 0


def test_what_is_selected_and_seen_stays(server: Server, window: Window) -> None:
    window.page.locator("#view").select_option("1")
    window.page.locator("#search").fill("extinguisher2")
    window.click("#spaces")
    window.click(".row", "leans on")
    window.click(".line", "touches the wall")
    window.page.locator(".twist").nth(1).click()
    window.page.locator("#picture canvas").focus()
    window.press("ArrowLeft", "ArrowUp", "+")
    address, picture, tree = window.page.url, window.picture(), window.texts("#tree")
    assert LEANS in address
    assert window.page.locator('[aria-expanded="false"]').count() == 1
    tell(server, window, stamp=1)
    assert (window.page.url, window.picture(), window.texts("#tree")) == (address, picture, tree)
    assert window.page.locator('[aria-expanded="false"]').count() == 1
    # Something else moves: the rest stays.
    tell(server, window, moves={"sweater": [0, 0, 0.1]})
    assert (window.page.url, window.texts("#tree")) == (address, tree)
    assert window.page.evaluate("() => document.activeElement.tagName") == "CANVAS"


def test_a_proof_is_the_new_one_and_who_was_in_it_still_is(server: Server, window: Window) -> None:
    window.click(".row", "leans on")
    window.page.locator('.step[aria-selected="true"]').first.focus()
    window.press("ArrowDown")
    before = window.texts("#evidence"), window.texts("#tree")
    tell(server, window, moves={"extinguisher2": [0, 0, 0.005]})
    assert (window.texts("#evidence"), window.texts("#tree")) != before
    assert window.page.evaluate("() => document.activeElement.dataset.path") == "0"
    assert window.page.locator('.step[aria-selected="true"]').count() == 1


def test_what_is_not_there_any_more_is_not_selected(server: Server, window: Window) -> None:
    window.page.locator("#thing").select_option(label="sweater")
    window.click(".row", "on top of")
    assert "relation=on_top_of%2Csweater" in window.page.url
    tell(server, window, moves={"sweater": [0, 0, 0.1]})
    assert "relation=" not in window.page.url
    assert "thing=sweater" in window.page.url
    tell(server, window, removed=["sweater"])
    assert "thing=" not in window.page.url
    assert window.page.locator("#thing").input_value() == ""
    assert not any("sweater" in one for one in window.texts("#thing option"))


def test_things_and_views_come_and_go(server: Server, window: Window) -> None:
    view = {"id": "v9", "label": "Ada", "position": [3.0, -1.0, 1.0], "heading": 1.6}
    cup = box("cup", (1.6, 1.9, 0.75), (0.1, 0.1, 0.1), 0.0, HOSTILE)
    tell(server, window, objects=[cup], views=[view])
    assert "Ada" in window.texts("#view option")
    assert any(HOSTILE in one for one in window.texts("#thing option"))
    window.page.locator("#view").select_option(label="Ada")
    window.drawn()
    tell(server, window, removed_views=["v9"], removed=["cup"])
    assert window.page.locator("#view").input_value() == "0"
    assert "Ada" not in window.texts("#view option")


def test_a_replaced_scene_is_shown_anew_and_a_removed_one_is_gone(server: Server, window: Window) -> None:
    tell(server, window, removed=["sweater"])
    assert server.put("hans", json.loads(HANS.read_text())).status == 200
    window.page.wait_for_function(
        "() => document.getElementById('summary').textContent.startsWith('8 things')"
    )
    assert server.send("DELETE", "/scenes/hans", token=True).status == 204
    signed(window, "this scene was removed")
    window.page.wait_for_timeout(2500)
    # That there is nothing to be followed is told to the console by the browser itself.
    assert all("404" in one for one in window.complaints)
    window.complaints.clear()
    assert server.put("hans", json.loads(HANS.read_text())).status == 201
    signed(window, "live")
    window.complaints.clear()


def test_a_lost_connection_is_said_and_found_again(chromium: Browser, tmp_path: Path) -> None:
    server = start(HANS, "--writable", "--store", tmp_path)
    window = Window.open(chromium, f"{server.url}/scenes/hans/view#{LEANS}")
    signed(window, "live")
    server.kill()
    signed(window, "connection lost, trying again")
    with serving("--writable", "--store", tmp_path, port=server.port) as again:
        tell(again, removed=["sweater"])
        signed(window, "live")
        window.page.wait_for_function(
            "() => document.getElementById('summary').textContent.startsWith('7 things')", timeout=30_000
        )
        assert LEANS in window.page.url
    assert all("net::" in one for one in window.complaints)
    window.page.close()
    assert server.process.stderr is not None
    server.process.stderr.close()


def test_a_click_is_not_lost_when_an_update_comes_in_the_middle(server: Server, window: Window) -> None:
    known = "() => document.documentElement.dataset.event"
    for text in ("leans on the wall", "is near the electric heater"):
        window.page.locator("#search").fill(text)
        window.drawn()
        place = window.page.locator(".row", has_text=text).first.bounding_box()
        assert place is not None
        window.page.mouse.move(place["x"] + 20, place["y"] + place["height"] / 2)
        window.page.mouse.down()
        before = window.page.evaluate(known)
        with window.page.expect_response(lambda one: one.url.endswith("view/data")) as response:
            event = server.change("hans", {"moves": {"sweater": [0, 0, 0.001]}}).json["event"]
        response.value.finished()
        window.page.wait_for_timeout(500)
        assert window.page.evaluate(known) == before
        window.page.mouse.up()
        assert text in window.texts('.row[aria-selected="true"]')[0]
        shows(window, event)
        assert text in window.texts('.row[aria-selected="true"]')[0]
