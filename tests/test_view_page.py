"""The page in a browser: from disk, by pointer and by keys, its parts linked; pixels tell what is seen."""

from __future__ import annotations

import base64
import json
import random
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from browser import Window, browser, needs_browser, saved
from deixis import KnowledgeBase, Scene
from deixis.view import framed, page_html
from endpoint import HANS, serving
from scenes import box, floor, scene
from screenshots import PICTURES, SHOTS, shot

pytestmark = [*needs_browser, pytest.mark.xdist_group("browser")]

LEANS = "relation=leans_on%2Cextinguisher2%2Cwall"
HOSTILE = "<script>alert(1)</script>'); halt.<img src=x onerror=alert(2)>"
MANY = 5_000
"""Relations of the large scene, at least."""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as running:
        yield running


def unsteady() -> Scene:
    """Return Figure 3 as seen by a robot whose pose is off by 5 cm: what rests on contact is uncertain."""
    scene = Scene.load(HANS)
    return replace(scene, thresholds=replace(scene.thresholds, pose_noise=0.05))


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    with KnowledgeBase(unsteady()) as kb:
        return saved(kb.page(), tmp_path_factory.mktemp("view") / "hans.html")


@pytest.fixture
def window(chromium: Browser, address: str) -> Iterator[Window]:
    opened = Window.open(chromium, address)
    yield opened
    assert opened.complaints == []
    assert {one.partition("#")[0] for one in opened.asked} == {address}
    opened.page.close()


def test_it_opens_from_disk_and_asks_for_nothing(window: Window) -> None:
    """That nothing else is asked for is checked of every test's window."""
    policy = window.page.locator("meta[http-equiv]").get_attribute("content")
    assert policy is not None
    assert "connect-src" not in policy
    assert window.page.locator("#live").is_hidden()
    assert len(window.colours()) > 100
    assert len(window.colours("#canvas canvas")) > 20
    lost = "() => document.querySelector('#picture canvas').getContext('webgl2').isContextLost()"
    assert window.page.evaluate(lost) is False
    assert window.texts("#count") == ["39 of 45"]


def test_a_click_on_a_thing_shows_its_relations(window: Window) -> None:
    before, red = window.picture(), window.reddish()
    label = window.page.locator(".labels span", has_text="radiator").bounding_box()
    assert label is not None
    window.page.mouse.click(label["x"] + label["width"] / 2, label["y"] + label["height"] + 16)
    window.drawn()
    assert window.picture() != before
    assert window.reddish() > red + 500
    shown = window.texts(".row .says")
    assert shown
    assert all("radiator" in one for one in shown)
    assert window.page.locator("#thing").input_value() == "2"
    assert "thing=radiator" in window.page.url


def test_a_click_on_a_relation_explains_it_and_lights_it_up(window: Window) -> None:
    red, blue = window.reddish(), window.bluish()
    window.click(".row", "leans on the wall")
    assert window.reddish() > red + 200
    assert window.bluish() > blue
    told = window.texts(".words")
    assert told[0].startswith("the fire extinguisher on the floor leans on the wall")
    assert any("the floor touches" in one or "touches the wall" in one for one in told)
    assert "leans_on(extinguisher2, wall)" in window.texts("#evidence")[0]
    assert LEANS in window.page.url


def test_a_click_is_not_lost_when_the_list_moves_under_it(window: Window) -> None:
    row = window.page.locator(".row", has_text="is left of the radiator").first
    row.scroll_into_view_if_needed()
    window.drawn()
    place = row.bounding_box()
    assert place is not None
    window.page.mouse.move(place["x"] + 20, place["y"] + place["height"] / 2)
    window.page.mouse.down()
    window.page.evaluate("() => { document.querySelector('#rows').scrollTop += 1; }")
    window.page.set_viewport_size({"width": 1390, "height": 890})
    window.drawn()
    window.page.mouse.up()
    window.drawn()
    assert "relation=left_of" in window.page.url
    assert window.page.locator('.row[aria-selected="true"]').count() == 1


def test_a_click_on_a_leaf_lights_up_what_was_measured(window: Window) -> None:
    window.click(".row", "is left of the radiator")
    whole = window.picture()
    window.click(".line", "the radiator is the reference")
    other = window.picture()
    assert other != whole
    window.click(".line", "reaches into the space left of")
    assert window.picture() != other
    assert "step=1" in window.page.url
    evidence = window.texts("#evidence")[0]
    assert "margin 0.083742166 m" in evidence
    crimson = sum(n for (r, g, b), n in window.colours().items() if r > 150 and g < 60 and b < 110)
    assert crimson > 20


def test_a_click_on_the_graph_selects_a_relation_or_a_thing(window: Window) -> None:
    green = """() => {
      const layers = [...document.querySelectorAll("#canvas canvas")];
      const copy = document.createElement("canvas");
      [copy.width, copy.height] = [layers[0].width, layers[0].height];
      const drawing = copy.getContext("2d");
      for (const one of layers) drawing.drawImage(one, 0, 0);
      const { data } = drawing.getImageData(0, 0, copy.width, copy.height);
      for (let at = 0; at < data.length; at += 4) {
        const [r, g, b] = data.slice(at, at + 3);
        if (g > r + 50 && g > b + 20) return [(at / 4) % copy.width, Math.floor(at / 4 / copy.width)];
      }
      return null;
    }"""
    window.page.locator("#search").fill("leans")
    window.drawn()
    # Its fitting, once the size is known, is done by the next frame.
    window.page.wait_for_timeout(200)
    place = window.page.evaluate(green)
    assert place is not None
    area = window.page.locator("#canvas").bounding_box()
    assert area is not None
    window.page.mouse.click(area["x"] + place[0], area["y"] + place[1] + 1)
    window.drawn()
    assert LEANS in window.page.url
    assert window.page.locator('.row[aria-selected="true"]').count() == 1


def test_the_view_changes_left_and_right(window: Window) -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        sides = ["left_of", "right_of", "in_front_of", "behind", "beside"]
        for number, view in enumerate(kb.scene.views):
            before = window.picture()
            window.page.locator("#view").select_option(str(number))
            window.drawn()
            assert (window.picture() != before) == (number > 0)
            for side in sides:
                found = kb.relations(view=view.id, relation=[side])
                options = window.page.locator(f'#only option[value="{side}"]').count()
                if not options:
                    assert not found
                    continue
                window.page.locator("#only").select_option(side)
                window.drawn()
                assert len(window.texts(".row")) == len(found)
            window.page.locator("#only").select_option("")
    of_robot = {one.figure for one in kb.relations(view="v0", relation=["left_of"])}
    assert of_robot != {one.figure for one in kb.relations(view="v1", relation=["left_of"])}


def test_what_is_uncertain_is_marked_and_dashed(window: Window) -> None:
    with KnowledgeBase(unsteady()) as kb:
        noise = kb.scene.thresholds.pose_noise
        doubtful = [one for one in kb.relations(view="v0") if one.margin is not None and one.margin < noise]
    drawn = window.colours("#canvas canvas")
    window.click("#unsure")
    assert window.texts("#count") == [f"{len(doubtful)} of 45"]
    assert window.colours("#canvas canvas") != drawn
    assert all("uncertain" in one for one in window.texts(".row"))
    dashes = "() => getComputedStyle(document.querySelector('.row.doubtful .swatch')).borderTopStyle"
    assert window.page.evaluate(dashes) == "dashed"
    window.click(".row", "leans on")
    assert window.page.locator(".step .tag.unsure").count() > 0
    assert "within the pose noise of 5 cm: uncertain" in window.texts("#evidence")[0]


def test_the_address_restores_what_was_shown(window: Window, chromium: Browser) -> None:
    window.page.locator("#view").select_option("1")
    window.page.locator("#search").fill("extinguisher2")
    window.click("#unsure")
    window.click("#spaces")
    window.click(".row", "leans on")
    window.click(".line", "touches the wall")
    again = Window.open(chromium, window.page.url)
    assert again.page.url == window.page.url
    assert again.picture() == window.picture()
    for selector in (".row", ".step[aria-selected=true] > .line", "#evidence", "#count"):
        assert again.texts(selector) == window.texts(selector)
    assert again.page.locator("#search").input_value() == "extinguisher2"
    again.page.evaluate(
        "() => { location.hash = 'thing=nobody&relation=none&step=9.9&view=x&only=y&theme=z'; }"
    )
    again.drawn()
    assert again.texts("#count") == ["39 of 45"]
    assert again.complaints == []
    again.page.close()


def test_all_is_done_by_keys(window: Window) -> None:
    def focused() -> str:
        return str(
            window.page.evaluate("() => document.activeElement.id || document.activeElement.className")
        )

    stops = []
    for _ in range(20):
        window.press("Tab")
        stops.append(focused())
        outline = window.page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none"
        if stops[-1] == "rows":
            break
    assert stops[-1] == "rows"
    assert {"view", "thing", "theme", "search", "only", "unsure"} <= set(stops)
    before = window.picture()
    window.press("ArrowDown", "ArrowDown")
    assert window.picture() != before
    assert window.page.locator("#rows").get_attribute("aria-activedescendant") == "row-1"
    window.press("End")
    assert window.page.locator("#rows").get_attribute("aria-activedescendant") == "row-38"
    window.press("Home", "Tab")
    if focused() == "all":
        window.press("Tab")
    assert focused() == "step"
    whole = window.texts("#evidence")
    window.press("ArrowDown")
    assert window.texts("#evidence") != whole
    window.press("ArrowLeft", "ArrowLeft")
    assert "step=" not in window.page.url
    assert window.page.locator('.step[aria-expanded="false"]').count() == 1
    window.press("ArrowRight", "ArrowRight")
    assert "step=0" in window.page.url
    window.press("Escape")
    assert "step=" not in window.page.url
    window.press("Escape")
    assert "relation=" not in window.page.url
    window.press("/")
    assert focused() == "search"
    window.page.keyboard.type("sweater")
    window.drawn()
    assert all("weater" in one for one in window.texts(".row .says"))
    window.page.locator("#picture canvas").focus()
    before = window.picture()
    window.press("ArrowLeft", "+")
    assert window.picture() != before


def test_it_is_dark_where_all_is_and_by_choice(chromium: Browser, address: str) -> None:
    dark = Window.open(chromium, address, color_scheme="dark")
    common = max(dark.colours().items(), key=lambda one: one[1])[0]
    assert sum(common) < 150
    ink = "() => getComputedStyle(document.body).color"
    assert dark.page.evaluate(ink) == "rgb(230, 233, 236)"
    dark.click("#theme")
    assert sum(max(dark.colours().items(), key=lambda one: one[1])[0]) > 600
    assert "theme=light" in dark.page.url
    assert dark.complaints == []
    dark.page.close()


def test_it_fits_a_phone(chromium: Browser, address: str) -> None:
    phone = Window.open(chromium, f"{address}#{LEANS}", wide=390, tall=844, has_touch=True)
    assert phone.page.evaluate("() => document.documentElement.scrollWidth") == 390
    assert not phone.page.locator("#tree").is_visible()
    phone.click(".tabs button", "Why")
    assert phone.page.locator("#tree").is_visible()
    assert not phone.page.locator("#rows").is_visible()
    phone.click(".tabs button", "Graph")
    assert len(phone.colours("#canvas canvas")) > 10
    assert phone.reddish() > 50
    assert phone.complaints == []
    phone.page.close()


def test_hostile_labels_are_text_and_nothing_runs(chromium: Browser, tmp_path: Path) -> None:
    made = scene(floor(), box("a'b", (0, 0, 0.5), (1, 1, 1), label=HOSTILE), name=HOSTILE)
    with KnowledgeBase.from_scene(made) as kb:
        place = saved(kb.page(), tmp_path / "hostile.html")
    window = Window.open(chromium, place)
    assert window.texts("#title") == [HOSTILE]
    window.click(".row", HOSTILE)
    assert HOSTILE in window.texts(".words")[0]
    assert HOSTILE in window.texts(".labels span.figure")[0]
    assert window.page.locator("img").count() == 0
    assert (window.complaints, len(window.asked)) == ([], 1)
    # The policy holds against what gets in all the same.
    window.page.evaluate("""() => {
      document.body.insertAdjacentHTML("beforeend", "<img src=x onerror='document.title = 1'>");
      const script = document.createElement("script");
      script.textContent = "document.title = 2";
      document.body.append(script);
    }""")
    window.page.wait_for_timeout(100)
    assert window.page.title() == f"{HOSTILE}: Deixis"
    assert any("Content Security Policy" in one for one in window.complaints)
    window.page.close()


def test_points_meshes_and_what_was_cut_down_are_drawn(chromium: Browser, tmp_path: Path) -> None:
    chance = random.Random(4)  # noqa: S311 - no secret
    cloud = [[chance.uniform(0, 1), chance.uniform(0, 1), chance.uniform(0, 1)] for _ in range(3_000)]
    mesh = {"vertices": [[2, 0, 0], [3, 0, 0], [2.5, 1, 0], [2.5, 0.5, 1]],
            "faces": [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]}  # fmt: skip
    made = scene(
        floor(),
        {"id": "cloud", "label": "cloud", "points": cloud},
        {"id": "tent", "label": "tent", "mesh": mesh},
    )
    with KnowledgeBase.from_scene(made) as kb:
        place = saved(kb.page(), tmp_path / "shapes.html")
    window = Window.open(chromium, f"{place}#thing=cloud")
    assert "2000 points of" in window.texts("#evidence")[0]
    assert len(window.colours()) > 50
    assert window.complaints == []
    window.page.close()


def test_a_notebook_shows_it_in_a_frame(chromium: Browser, tmp_path: Path) -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        place = saved(f"<!doctype html><body>{framed(kb.page())}</body>", tmp_path / "notebook.html")
    page = chromium.new_page(viewport={"width": 1200, "height": 800})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(place)
    inside = page.frame_locator("iframe")
    inside.locator("html[data-ready=yes]").wait_for(timeout=30_000)
    inside.locator(".row", has_text="leans on").click()
    assert "leans on the wall" in inside.locator(".words").first.inner_text()
    assert errors == []
    page.close()


def test_the_server_shows_it(chromium: Browser) -> None:
    with serving(HANS) as server:
        reply = server.send("GET", "/scenes/hans/view")
        assert reply.status == 200
        assert reply.headers["content-type"].startswith("text/html")
        policy = reply.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'sha256-")
        assert "; connect-src 'self'; " in policy
        assert policy.endswith("frame-ancestors 'none'")
        assert server.send("GET", "/scenes/nobody/view").status == 404
        window = Window.open(chromium, f"{server.url}/scenes/hans/view#{LEANS}")
        assert window.texts(".words")[0].startswith("the fire extinguisher on the floor leans on")
        assert window.complaints == []
        # It follows the scene, and asks for nothing else.
        assert {one.partition("#")[0].partition("?")[0] for one in window.asked} <= {
            f"{server.url}/scenes/hans/view", f"{server.url}/scenes/hans/changes", f"{server.url}/favicon.ico"
        }  # fmt: skip
        window.page.close()
        page = chromium.new_page()
        page.goto(server.url)
        link = page.locator("#scenes a")
        link.wait_for(timeout=10_000)
        assert link.get_attribute("href") == "/scenes/hans/view"
        page.close()


DIFFERENT = """
async ([one, other]) => {
  const pixels = async (text) => {
    const image = new Image();
    image.src = "data:image/png;base64," + text;
    await image.decode();
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [image.width, image.height];
    const drawing = copy.getContext("2d");
    drawing.drawImage(image, 0, 0);
    return drawing.getImageData(0, 0, copy.width, copy.height).data;
  };
  const [a, b] = [await pixels(one), await pixels(other)];
  if (a.length !== b.length) return 1;
  let count = 0;
  for (let at = 0; at < a.length; at += 4) {
    const apart = [0, 1, 2].map((one) => Math.abs(a[at + one] - b[at + one]));
    if (apart[0] + apart[1] + apart[2] > 60) count += 1;
  }
  return count / (a.length / 4);
}
"""
"""Which share of the pixels of two pictures differ by more than letters drawn a little otherwise."""


@pytest.mark.parametrize("name", list(SHOTS))
def test_the_pictures_of_the_readme_are_current(chromium: Browser, tmp_path: Path, name: str) -> None:
    """If it fails for a good reason: python tests/screenshots.py."""
    kept = (PICTURES / f"{name}.png").read_bytes()
    assert len(kept) < 200_000
    taken = shot(chromium, name, tmp_path)
    page = chromium.new_page()
    both = [base64.b64encode(one).decode() for one in (kept, taken)]
    assert page.evaluate(DIFFERENT, both) < 0.05
    page.close()


def crowd(things: int, side: float) -> Scene:
    chance = random.Random(7)  # noqa: S311 - no secret
    objects = [floor("floor", half=side / 2)]
    for number in range(things - 1):
        size = [chance.uniform(0.1, 0.6) for _ in range(3)]
        x, y = (chance.uniform(-side / 2, side / 2) for _ in range(2))
        label = chance.choice(["box", "chair", "lamp", "cup", "table"])
        objects.append(box(f"thing{number}", (x, y, size[2] / 2), size, chance.uniform(0, 3), label))
    return scene(*objects, name="crowd")


def test_five_hundred_things_stay_lively(chromium: Browser, tmp_path: Path) -> None:
    with KnowledgeBase.from_scene(crowd(500, 18.5)) as kb:
        now, later = kb.page_data()
    page = page_html("crowd", now, later)
    assert len(now["relations"]) >= MANY
    place = saved(page, tmp_path / "crowd.html")
    raw = len(json.dumps(now)) + len(json.dumps(later))
    window = Window.open(chromium, place)
    paint = window.page.evaluate("() => performance.getEntriesByName('first-contentful-paint')[0].startTime")
    assert window.page.locator(".row").count() < 40
    spent = []
    for press in ["ArrowDown"] * 6:
        window.page.locator("#rows").focus()
        spent.append(
            window.page.evaluate(
                """(key) => new Promise((done) => {
                  const start = performance.now();
                  document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
                  requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - start)));
                })""",
                press,
            )
        )
    things = []
    for number in (3, 33, 333):
        start = time.perf_counter()
        window.page.locator("#thing").select_option(str(number))
        window.drawn()
        things.append(1000 * (time.perf_counter() - start))
        assert window.page.locator("#thing").input_value() == str(number)
        assert window.reddish() > 10
    told = f"{len(now['things'])} things, {len(now['relations'])} relations"
    sizes = f"{len(page) / 1e6:.2f} MB, its data {raw / 1e6:.2f} MB before they are deflated"
    first = f"first paint {paint:.0f} ms"
    print(f"{told}: {sizes}; {first}; a relation selected {min(spent):.0f} ms, a thing {min(things):.0f} ms")
    assert window.complaints == []
    window.page.close()
