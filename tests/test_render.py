"""Renderers: JSON by its schema, HTML, DOT; and whatever a label says, it is shown as text."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from commands import call
from deixis.explain import Proof, Refusal
from deixis.knowledge import KnowledgeBase
from deixis.render import explanation_schema
from deixis.render.steps import visible
from scenes import box, floor, scene
from test_golden import SCENES

KB = Path(__file__).resolve().parent.parent / "kb"
HANS = KB / "scenes" / "hans.json"

VALIDATOR = jsonschema.Draft202012Validator(explanation_schema())

HOSTILE = [
    "<script>alert(1)</script>",
    "'); halt.",
    'he said "mug" & left \\N \\G \\l &lt;b&gt;',
    "]]> --> </style></details> {{7*7}} ${x} %s",
    "ⅷ̈ テーブル 🪑",
]

UNSEEN = ["two\nlines\r", "left\u202eright\u2066", "bell\x07 \x1b[31m red \u2028 end"]


class Page(HTMLParser):
    """The elements of a page in their order, and its text."""

    VOID = frozenset({"meta", "br"})

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.open: list[str] = []
        self.data: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert {name for name, _ in attrs} <= {
            "class", "open", "lang", "charset", "http-equiv", "content", "name",
        }  # fmt: skip
        self.tags.append(tag)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["style"]:
            self.data.append(data)

    @property
    def text(self) -> str:
        return " ".join(self.data)


ELEMENTS = {
    "html", "head", "meta", "title", "body", "main", "div", "style", "h2", "ul", "li", "details", "summary",
    "span", "small", "dl", "dt", "dd",
}  # fmt: skip


def leaf(text: str) -> Proof:
    return Proof("fact", "gap", ("a",), text, 0.01, None, None, True, ())


def labels_of(graph: str) -> list[str]:
    """Return the labels that Graphviz reads in a graph."""
    read = subprocess.run(["dot", "-Tjson0"], input=graph, capture_output=True, text=True, check=True)
    return [node["label"] for node in json.loads(read.stdout)["objects"]]


# JSON


def test_the_exported_schema_is_current() -> None:
    text = json.dumps(explanation_schema(), indent=1) + "\n"
    file = KB / "explanation.schema.json"
    assert file.read_text(encoding="utf-8") == text, "export explanation_schema() to kb again"


def test_the_schema_is_one_and_closed() -> None:
    schema = explanation_schema()
    jsonschema.Draft202012Validator.check_schema(schema)

    def objects(part: Any) -> list[Any]:
        if isinstance(part, list):
            return [one for child in part for one in objects(child)]
        if not isinstance(part, dict):
            return []
        own = [part] if part.get("type") == "object" else []
        return own + [one for child in part.values() for one in objects(child)]

    assert all("additionalProperties" in one and "description" in one for one in objects(schema))


@pytest.mark.parametrize("name", SCENES)
def test_every_explanation_is_as_the_schema_says(name: str) -> None:
    with KnowledgeBase.from_scene(SCENES[name]) as kb:
        for one in kb.relations():
            VALIDATOR.validate(kb.evidence(kb.why(one.to_prolog())).to_dict())
            turned = one.to_prolog().replace(one.relation, "on_top_of" if one.view is None else "behind", 1)
            VALIDATOR.validate(kb.evidence(kb.why_not(turned)).to_dict())
            VALIDATOR.validate(kb.evidence(kb.why(turned)).to_dict())
        VALIDATOR.validate(kb.evidence(kb.check()).to_dict())


def test_the_schema_refuses_what_is_not_one() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        told = kb.evidence(kb.why("leans_on(extinguisher2, wall)")).to_dict()
    assert VALIDATOR.is_valid(told)
    for change in (
        {"colour": "red"},
        {"holds": "yes"},
        {"proof": told["proof"] | {"kind": "guess"}},
        {"proof": told["proof"] | {"evidence": {"values": []}}},
    ):
        assert not VALIDATOR.is_valid(told | change)


# HTML


@pytest.mark.parametrize("goal", ["leans_on(extinguisher2, wall)", "on_top_of(sign, heater)"])
def test_a_page_opens_step_by_step(goal: str) -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        answer = kb.evidence(kb.why(goal))
        refusal = kb.evidence(kb.why_not(goal))
    for found in (answer, refusal):
        page = Page(found.to_html("Why"))
        assert set(page.tags) <= ELEMENTS
        proof = answer.proof or answer.nearest
        if proof is None or isinstance(found, Refusal):
            continue
        assert proof.text in page.text
        assert {"measured between", "granularity", "measured as"} <= set(page.data)
        assert page.tags.count("details") == page.tags.count("summary") > 5
    assert answer._repr_html_().startswith('<div class="deixis-why">')


def test_a_page_needs_nothing_else() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        text = kb.evidence(kb.check()).to_html("Check")
    assert not re.search(r"https?:|src=|href=|url\(|@import|<script|\son\w+=", text)
    assert "default-src 'none'" in text


@pytest.mark.parametrize("label", HOSTILE)
def test_a_hostile_label_is_text_everywhere(label: str) -> None:
    made = scene(box("cup", [0, 0, 0.05], [0.1, 0.1, 0.1], label=label), floor())
    with KnowledgeBase(made) as kb:
        answer = kb.evidence(kb.why("on_top_of(cup, floor)"))
    assert answer.proof is not None
    assert label in json.loads(json.dumps(answer.to_dict()))["text"]
    page = Page(answer.to_html(label))
    assert set(page.tags) <= ELEMENTS
    assert f"the {label} is on top of the floor" in page.data
    assert label in page.data
    if shutil.which("dot"):
        drawn = labels_of(answer.to_dot())
        assert any(squeezed(label) in squeezed(undone(one)) for one in drawn)


@pytest.mark.parametrize("text", [*HOSTILE, *UNSEEN])
def test_whatever_a_step_says_is_shown(text: str) -> None:
    step = leaf(text)
    page = Page(step.to_html())
    assert set(page.tags) <= ELEMENTS
    assert visible(text) in page.data
    assert all(one.isprintable() or one == "\n" for one in step.to_html())
    if shutil.which("dot"):
        (drawn,) = labels_of(step.to_dot())
        assert squeezed(undone(drawn)).startswith(squeezed(visible(text)))


def undone(label: str) -> str:
    r"""Return what Graphviz draws for a label: \n ends a line, \\ is a backslash, references are undone."""
    lines = re.sub(r"\\(.)", lambda found: " " if found[1] == "n" else found[1], label)
    return lines.replace("&amp;", "&")


def squeezed(text: str) -> str:
    return re.sub(r"\s+", "", text)


# DOT


@pytest.mark.skipif(not shutil.which("dot"), reason="Graphviz is not installed")
def test_graphviz_draws_every_step_that_a_person_needs() -> None:
    with KnowledgeBase.from_scene(HANS, rules=["safety"]) as kb:
        for proof in kb.proofs().values():
            drawn = [squeezed(undone(one)) for one in labels_of(proof.to_dot())]
            for line in proof.outline().splitlines():
                said = squeezed(line.split("  [axiom")[0])
                assert any(one.startswith(said) for one in drawn)


def test_a_step_that_serves_twice_is_drawn_once() -> None:
    shared = Proof("rule", "touches", ("a", "b"), "a touches b", None, None, None, True, ())
    both = Proof("rule", "both", ("a",), "both", None, None, None, True, (shared, shared))
    assert both.to_dot().count("a touches b") == both.to_dot().count("->") == 1


# The commands


@pytest.mark.parametrize(
    "command",
    [
        ("why", str(HANS), "leans_on(extinguisher2, wall)"),
        ("why-not", str(HANS), "affixed_on(extinguisher2, wall)"),
        ("check", str(HANS)),
    ],
)
@pytest.mark.parametrize("form", ["text", "json", "html", "dot"])
def test_commands_write_every_form(command: tuple[str, ...], form: str, tmp_path: Path) -> None:
    printed = call(*command, "--format", form)
    file = tmp_path / "out"
    written = call(*command, "--format", form, "-o", file)
    assert (written.code, written.out, written.err) == (printed.code, "", "")
    assert file.read_text(encoding="utf-8") == printed.out
    if form == "json":
        VALIDATOR.validate(json.loads(printed.out))
    if form == "html":
        assert set(Page(printed.out).tags) <= ELEMENTS
    if form == "dot":
        assert printed.out.startswith('digraph "why" {\n')


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    found = call("why", HANS, "near(sweater, heater)", "-o", tmp_path / "no" / "such" / "why.html")
    assert (found.code, found.out) == (2, "")
    assert "cannot be written" in found.err
