"""The data of the page: all that was derived, as it was derived; and the page that holds it."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shlex
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import deixis.view.html
from commands import call, run
from deixis import KnowledgeBase, Scene
from deixis.bounds import BOUNDS
from deixis.proof import Proof, Rule
from deixis.view import available, framed, page_html
from deixis.view.html import PLAIN, packed
from deixis.view.reasons import KINDS
from deixis.view.shapes import FACES, POINTS, TOTAL, shapes
from readme import blocks
from scenes import box, floor, scene

ROOT = Path(__file__).resolve().parent.parent
SCENES = ROOT / "kb" / "scenes"
PAGE = ROOT / "src" / "deixis" / "view" / "page"
HOSTILE = "</script><script>alert(1)</script>'); halt.<!--{{now}}"

built = pytest.mark.skipif(not available(), reason="the page is not built: make page")


@pytest.fixture(scope="module", params=["hans", "inspection", "kitchen"])
def kb(request: pytest.FixtureRequest) -> Iterator[KnowledgeBase]:
    rules = ("safety",) if request.param == "inspection" else ()
    with KnowledgeBase.from_scene(SCENES / f"{request.param}.json", rules=rules) as found:
        yield found


def unpacked(text: str) -> Any:
    told = json.loads(text)
    return json.loads(zlib.decompress(base64.b64decode(told), -15)) if isinstance(told, str) else told


def proof_of(tables: dict[str, Any], number: int) -> Proof:
    """Read a proof from its tables."""
    words = tables["words"]
    kind, predicate, args, text, margin, axiom, rule, shown, below, *_ = tables["steps"][number]
    return Proof(
        KINDS[kind],
        words[predicate],
        tuple(one[0] if isinstance(one, list) else None if one is None else words[one] for one in args),
        words[text],
        margin,
        axiom,
        None if rule is None else Rule(*tables["rules"][rule]),
        bool(shown),
        tuple(proof_of(tables, one) for one in below),
    )


def test_every_proof_is_there_whole(kb: KnowledgeBase) -> None:
    now, later = kb.page_data()
    now, later = unpacked(packed(now)), unpacked(packed(later))
    names = {row[0] for row in now["relations"]}
    proofs = kb.proofs(relation=names)
    assert len(now["relations"]) == len(proofs) > 40
    for row in now["relations"]:
        found = proof_of(later, row[4])
        assert proofs[found.predicate, *map(str, found.args)] == found
        assert row[5] == found.text


def test_margins_are_those_of_the_relations(kb: KnowledgeBase) -> None:
    now, later = kb.page_data()
    margins = {
        (one.relation, one.figure, one.reference, *([one.view] if one.view else [])): one.margin
        for one in kb.relations(relation={row[0] for row in now["relations"]})
    }
    for row in now["relations"]:
        proof = proof_of(later, row[4])
        assert row[3] == margins[proof.predicate, *map(str, proof.args)]


def test_what_lights_up_is_what_was_measured(kb: KnowledgeBase) -> None:
    _, later = kb.page_data()
    checked = 0
    for row in later["steps"]:
        if len(row) < 12 or row[11] is None:
            continue
        things, points, plane = later["sights"][row[11]]
        assert set(things) <= set(kb.facts.ids)
        values = {later["words"][name]: value for name, value, _ in row[9]}
        if plane is not None and later["words"][row[1]] == "halfspace":
            point, normal, bound = plane
            assert np.dot(normal, np.subtract(points[0], point)) == pytest.approx(values["margin"], abs=5e-4)
            assert bound in BOUNDS
            checked += 1
        elif plane is None and "separation" in values:
            length = np.linalg.norm(np.subtract(*points))
            assert length == pytest.approx(abs(values["separation"]), abs=5e-4)
            checked += 1
    assert checked > 10


def test_rules_of_ones_own_are_on_the_page() -> None:
    with KnowledgeBase.from_scene(SCENES / "inspection.json", rules=["safety"]) as kb:
        now, _ = kb.page_data()
    found = [row for row in now["relations"] if row[0] == "violation"]
    assert "the sweater is a fire hazard on or against the electric heater" in [row[5] for row in found]
    names = [[now["things"][index][0] for index in row[1]] for row in found]
    assert ["sweater", "heater1"] in names


def test_large_shapes_are_cut_down_and_say_so() -> None:
    many = np.random.default_rng(1).random((20_000, 3)).tolist()
    small = {"id": "small", "label": "small", "points": many[:50]}
    large = {"id": "large", "label": "large", "points": many}
    faces = [[k, k + 1, k + 2] for k in range(FACES + 1)]
    mesh = {"id": "mesh", "label": "mesh", "mesh": {"vertices": many, "faces": faces}}
    own = {"id": "own", "label": "own", "mesh": {"vertices": many, "faces": faces[:2]}}
    regions = scene(small, large, mesh, own, box("box", (0, 0, 5), (1, 1, 1))).regions
    one, two, three, four, five = shapes(regions)
    assert one is not None
    assert set(one) == {"points"}
    assert two is not None
    assert (len(two["points"]), two["of"]) == (3 * POINTS, len(regions[1].points))
    assert three is not None
    assert (len(three["points"]), three["of"]) == (3 * POINTS, FACES + 1)
    assert four is not None
    assert (len(four["vertices"]), four["faces"]) == (4 * 3, [0, 1, 2, 1, 2, 3])
    assert five is None
    whole = shapes([regions[1]] * 100)
    assert sum(len(one["points"]) // 3 for one in whole if one) <= TOTAL
    assert whole[-1] is None


def test_large_data_are_deflated() -> None:
    data = {"words": ["wall " * PLAIN, HOSTILE]}
    assert len(packed(data)) < PLAIN
    assert unpacked(packed(data)) == data
    label = {"label": HOSTILE + "\u2028\u2029"}
    assert unpacked(packed(label)) == label
    assert not set("<\u2028\u2029") & set(packed(label))


@built
def test_only_its_own_script_may_run(kb: KnowledgeBase) -> None:
    page = kb.page()
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]+)"', page)
    policy = policy.replace("&#x27;", "'")
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    (style,) = re.findall(r"<style[^>]*>(.*?)</style>", page, re.DOTALL)
    for name, text in (("script", script), ("style", style)):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{name}-src 'sha256-{digest}';" in policy
    assert policy.startswith("default-src 'none';")
    assert "unsafe" not in policy
    assert not re.search(r"\beval\(|new Function\b", script)


@built
def test_the_page_is_small_and_names_its_licences() -> None:
    with KnowledgeBase.from_scene(scene()) as kb:
        page = kb.page()
    print(f"the page without data: {len(page.encode()) / 1e6:.2f} MB")
    assert len(page.encode()) < 1_600_000
    for words in ("three 0.", "cytoscape 3.", "Permission is hereby granted"):
        assert words in page


@built
def test_the_readme_s_command_writes_it(tmp_path: Path) -> None:
    (block,) = blocks("shell")
    first, second = block.text.splitlines()
    assert first.startswith("make page ")
    name, *words = shlex.split(second)
    assert (name, words[-1]) == ("deixis", "scene.html")
    result = run(*words[:-1], tmp_path / words[-1], cwd=ROOT)
    assert (result.code, result.out) == (0, "")
    assert (tmp_path / "scene.html").read_text(encoding="utf-8").endswith("</html>\n")


@built
def test_hostile_words_stay_words(tmp_path: Path) -> None:
    place = tmp_path / "scene.json"
    hostile = scene(floor(), box("a'b<i>", (0, 0, 0.5), (1, 1, 1), label=HOSTILE), name=HOSTILE)
    place.write_text(hostile.to_json(), encoding="utf-8")
    result = run("view", place, "-o", tmp_path / "scene.html")
    assert (result.code, result.out) == (0, "")
    page = (tmp_path / "scene.html").read_text(encoding="utf-8")
    assert page.count("<script") == 3
    assert page.count("</script>") == 3
    assert "alert(1)</" not in page


def test_without_the_bundle_it_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deixis.view.html, "_BUNDLE", tmp_path)
    deixis.view.html._parts.cache_clear()
    result = call("view", SCENES / "hans.json", "-o", tmp_path / "scene.html")
    assert result.code == 2
    assert "`make page`" in result.err
    assert not (tmp_path / "scene.html").exists()
    with KnowledgeBase.from_scene(SCENES / "hans.json") as kb:
        assert kb._repr_html_() is None


@built
def test_notebooks_show_it_in_a_frame_of_its_own() -> None:
    with KnowledgeBase.from_scene(SCENES / "hans.json") as kb:
        shown = kb._repr_html_()
        assert shown == framed(kb.page())
    assert shown is not None
    assert shown.startswith('<iframe sandbox="allow-scripts" srcdoc="&lt;!doctype html&gt;')
    assert '"' not in shown.split('srcdoc="')[1].split('" title=')[0]
    things = [box(f"thing{number}", (3 * number, 0, 0), (1, 1, 1)) for number in range(201)]
    assert KnowledgeBase.from_scene(scene(*things))._repr_html_() is None


@built
def test_an_empty_scene_has_a_page() -> None:
    with KnowledgeBase.from_scene(Scene("empty")) as kb:
        assert "Deixis" in page_html("empty", *kb.page_data())


def test_nothing_is_named_that_is_not_here() -> None:
    for place in sorted(PAGE.glob("*.*")):
        assert "http:" not in place.read_text(encoding="utf-8")
        assert "https:" not in place.read_text(encoding="utf-8")
    locked = json.loads((PAGE / "package-lock.json").read_text(encoding="utf-8"))
    whole = [one for name, one in locked["packages"].items() if name]
    assert all(one["integrity"].startswith("sha512-") for one in whole)
    assert all("resolved" not in one for one in whole)
