"""The JSON interface says what Python says, and its description is true."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any
from urllib.parse import quote

import jsonschema
import pytest

from deixis.knowledge import KnowledgeBase
from deixis.render import explanation_schema
from deixis.scene import Scene
from endpoint import HANS, Reply, Server, serving


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(HANS, "--timeout", "5") as running:
        yield running


@pytest.fixture(scope="module")
def kb() -> Iterator[KnowledgeBase]:
    with KnowledgeBase.from_scene(HANS) as opened:
        yield opened


def ask(server: Server, goal: str, limit: int = 1000) -> Reply:
    body = json.dumps({"goal": goal, "limit": limit}).encode()
    return server.send("POST", "/scenes/hans/ask", body, content_type="application/json")


def test_relations_are_python_s(server: Server, kb: KnowledgeBase) -> None:
    found = server.send("GET", "/scenes/hans/relations").json
    assert found["relations"] == [one.to_dict() for one in kb.relations()]
    assert found["withheld"] == [one.to_dict() for one in kb.withheld]
    assert (found["total"], found["next"]) == (len(kb.relations()), None)


@pytest.mark.parametrize(
    ("query", "passes"),
    [
        ("relation=on_top_of&relation=near", lambda one: one.relation in ("on_top_of", "near")),
        ("figure=sweater", lambda one: one.figure == "sweater"),
        ("reference=wall&view=v1", lambda one: one.reference == "wall" and one.view in (None, "v1")),
        ("margin=0.05", lambda one: one.margin is None or one.margin >= 0.05),
        ("label=radiator", lambda one: "radiator" in (one.figure, one.reference)),
    ],
)
def test_relations_are_filtered(server: Server, kb: KnowledgeBase, query: str, passes: object) -> None:
    assert callable(passes)
    found = server.send("GET", f"/scenes/hans/relations?{query}").json["relations"]
    expected = [one.to_dict() for one in kb.relations() if passes(one)]
    assert found == expected != []


@pytest.mark.parametrize("query", ["margin=nan", "margin=inf", "margin=x", "limit=0", "view=v9", "figure=x"])
def test_a_filter_that_means_nothing_is_refused(server: Server, query: str) -> None:
    assert server.send("GET", f"/scenes/hans/relations?{query}").status in (400, 422)


def test_pages_follow_one_another(server: Server) -> None:
    whole = server.send("GET", "/scenes/hans/relations").json["relations"]
    found, path = [], "/scenes/hans/relations?limit=7"
    while path:
        page = server.send("GET", path).json
        assert len(page["relations"]) <= 7
        found += page["relations"]
        path = page["next"] and f"/scenes/hans/relations?limit=7&cursor={page['next']}"
    assert found == whole
    assert server.send("GET", "/scenes/hans/relations?cursor=nonsense").status == 400


def test_goals_are_answered_as_by_prolog(server: Server, kb: KnowledgeBase) -> None:
    for goal in (
        "on_top_of(X, Y)",
        "left_of(X, radiator, V), \\+ leans_on(X, wall)",
        "near(X, Y), \\+ touches(X, Y)",
        "on_top_of(sweater, heater)",
    ):
        expected = {tuple(sorted(row.items())) for row in map(dict, kb.ask(goal).bindings)}
        reply = ask(server, goal).json
        assert {tuple(sorted(row.items())) for row in reply["bindings"]} == expected - {()}
        assert (reply["holds"], reply["truncated"]) == (bool(expected), False)
    assert ask(server, "on_top_of(X, Y)", limit=1).json["truncated"] is True


def test_a_name_that_nothing_has_is_told_beside_the_answer(server: Server) -> None:
    for goal, names in (
        ("on_top_of(X, heeter)", ["heeter"]),
        ("on_top_of(X, heater), \\+ (touches(X, flor), near(X, flor))", ["flor"]),
        ("on_top_of(X, heater), label(X, jumper, _)", []),
    ):
        reply = ask(server, goal)
        assert (reply.status, len(reply.json["notes"])) == (200, len(names))
        assert all(
            f"nothing is called '{one}'" in note for one, note in zip(names, reply.json["notes"], strict=True)
        )
    assert ask(server, "on_top_of(X, heeter)").json["holds"] is False


@pytest.mark.parametrize(
    "goal",
    [
        "shell(ls)", "X = 1", "on_top_of(X, Y), !", "p(X) :- touches(X, Y)", "touches(X, Y), X",
        "touches(X, Y). evil(X) :- touches(X, X)", ":- initialization(halt)", "on_top_of(X)", "nonsense(X)",
        "findall(X, touches(X, Y), L)", "touches(" + "(" * 3000, "touches(X, 'unclosed", "",
        ", ".join(["near(_, _)"] * 30),
    ],
)  # fmt: skip
def test_goals_outside_the_subset_are_refused(server: Server, goal: str) -> None:
    reply = ask(server, goal)
    assert (reply.status, "Traceback" in reply.detail) == (400, False)


def test_a_goal_that_multiplies_is_stopped(server: Server) -> None:
    goal = ", ".join(f"pair(A{n}, B{n}, _, _, _, _, _, _, _)" for n in range(16))
    reply = ask(server, goal)
    assert reply.status in (500, 503)
    assert server.send("GET", "/scenes/hans/relations?limit=1").status == 200


def test_reasons_are_python_s(server: Server, kb: KnowledgeBase) -> None:
    for goal in ("leans_on(extinguisher2, wall)", "on_top_of(extinguisher2, wall)"):
        found = server.send("GET", f"/scenes/hans/why?goal={quote(goal)}").json
        assert found["text"] == kb.why(goal).to_dict()["text"]
        assert str(HANS.parent.parent.parent) not in json.dumps(found)
    assert server.send("GET", "/scenes/hans/why?goal=halt").status == 400


def test_reasons_have_their_evidence_and_are_as_the_schema_says(server: Server) -> None:
    for goal in ("leans_on(extinguisher2, wall)", "on_top_of(extinguisher2, wall)"):
        found = server.send("GET", f"/scenes/hans/why?goal={quote(goal)}").json
        jsonschema.validate(found, explanation_schema())
        assert '"granularity"' in json.dumps(found["proof"] or found["nearest"])


LEANS, AFFIXED = "leans_on(extinguisher2, wall)", "affixed_on(extinguisher2, wall)"


def get(server: Server, question: str, **given: str) -> Any:
    query = "&".join(f"{name}={quote(value)}" for name, value in given.items())
    return server.send("GET", f"/scenes/hans/{question}?{query}").json


def as_json(told: Any) -> Any:
    return json.loads(json.dumps(told))


def test_each_question_for_reasons_is_python_s(server: Server, kb: KnowledgeBase) -> None:
    assert get(server, "why", goal=LEANS) == as_json({"goal": LEANS, **kb.evidence(kb.why(LEANS)).to_dict()})
    found_all = kb.evidence(kb.why_all("near(X, Y)", limit=2))
    every = as_json({"goal": "near(X, Y)", **found_all.to_dict()})
    assert get(server, "why-all", goal="near(X, Y)", limit="2") == every
    assert every["truncated"]
    refusal = kb.evidence(kb.why_not(AFFIXED))
    told = {"goal": AFFIXED, "sentence": refusal.sentence(), **refusal.to_dict()}
    assert get(server, "why-not", goal=AFFIXED) == as_json(told)
    found = kb.evidence(kb.contrast(LEANS, AFFIXED))
    told = {"goal": LEANS, "rather_than": AFFIXED, "sentence": found.sentence(), **found.to_dict()}
    assert get(server, "contrast", goal=LEANS, rather_than=AFFIXED) == as_json(told)
    assert "because the floor touches it." in told["sentence"]
    change = kb.change("on_top_of(sweater, heater)")
    assert change is not None
    assert get(server, "change", goal="on_top_of(sweater, heater)") == as_json(
        {"goal": "on_top_of(sweater, heater)", "change": change.to_dict()}
    )
    assert get(server, "names")["names"] == kb.names()
    assert get(server, "names", view="v0")["names"] == kb.names(view="v0")


def what_if(server: Server, body: object) -> Reply:
    text = json.dumps(body).encode()
    return server.send("POST", "/scenes/hans/what-if", text, content_type="application/json")


def test_what_if_is_python_s(server: Server, kb: KnowledgeBase) -> None:
    moves = {"sweater": (0.0, 0.0, 0.1)}
    assert what_if(server, {"moves": moves}).json == as_json(kb.consequences(moves).to_dict())
    far = {"sweater": (-1.0, 0.3, 0.0)}
    cut = what_if(server, {"moves": far, "limit": 1}).json
    assert (len(cut["gained"]) + len(cut["lost"]), cut["truncated"]) == (1, True)
    assert what_if(server, {"moves": {"sweater": (0.0, 0.0, 0.0)}}).json["lost"] == []


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"moves": {}}, 422), ({}, 422), ({"moves": {"sweater": [0, 0]}}, 422),
        ({"moves": {"sweater": [0, 0, "x"]}}, 422), ({"moves": {"sweater": [0, 0, 1e9]}}, 422),
        ({"moves": {f"t{n}": [0, 0, 0] for n in range(101)}}, 422), ({"moves": {"none": [0, 0, 1]}}, 400),
        ({"moves": {"sweater": [0, 0, 1]}, "limit": 0}, 422),
        ({"moves": {"sweater": [0, 0, 1]}, "limit": 10**6}, 422),
    ],
)  # fmt: skip
def test_moves_that_mean_nothing_are_refused(server: Server, body: object, status: int) -> None:
    assert what_if(server, body).status == status


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("why-not?goal=halt", 400), ("why-not", 422), ("why-all?goal=near(X,Y)&limit=0", 422),
        ("why-all?goal=near(X,Y)&limit=100000", 422), ("why-all?goal=shell(ls)", 400),
        (f"contrast?goal={quote(LEANS)}", 422), ("contrast?goal=near(X,Y)&rather_than=halt", 400),
        ("contrast?goal=near(sign,wall)&rather_than=near(sign,nothing)", 400), ("change?goal=halt", 400),
        ("change?goal=near(X,Y)", 400), ("names?view=v9", 400),
        ("why?goal=" + "x" * 5000, 422), ("why-not?goal=" + "x" * 5000, 422),
    ],
)  # fmt: skip
def test_questions_for_reasons_that_mean_nothing_are_refused(server: Server, path: str, status: int) -> None:
    reply = server.send("GET", f"/scenes/hans/{path}")
    assert (reply.status, "Traceback" in reply.detail) == (status, False)


@pytest.mark.parametrize(
    ("method", "path", "allowed", "detail"),
    [
        ("POST", "why", "GET", "GET it, with ?goal=...: /scenes/hans/why takes GET, not POST"),
        ("POST", "contrast", "GET", "GET it, with ?goal=...&rather_than=...: "),
        ("POST", "names", "GET", "GET it: /scenes/hans/names takes GET, not POST"),
        ("GET", "ask", "POST", "POST it, with JSON in the body: /scenes/hans/ask takes POST, not GET"),
        ("GET", "what-if", "POST", "POST it, with JSON in the body: "),
        ("GET", "updates", "POST", "POST it, with JSON in the body: "),
        ("POST", "", "GET, PUT, DELETE", "/scenes/hans takes GET, PUT or DELETE, not POST"),
        ("PATCH", "sparql", "GET, HEAD, POST", "/sparql takes GET or POST, not PATCH"),
    ],
)
def test_a_wrong_method_is_answered_with_the_right_one(
    server: Server, method: str, path: str, allowed: str, detail: str
) -> None:
    whole = "/sparql" if path == "sparql" else f"/scenes/hans/{path}".rstrip("/")
    reply = server.send(method, whole, b"" if method == "POST" else None)
    assert (reply.status, reply.headers["allow"]) == (405, allowed)
    assert reply.headers["content-type"] == "application/problem+json"
    assert reply.detail.startswith(detail)


def test_scenes_are_whole(server: Server) -> None:
    found = server.send("GET", "/scenes/hans").json
    assert Scene.from_dict(found).to_dict() == Scene.load(HANS).to_dict()
    (told,) = server.send("GET", "/scenes").json["scenes"]
    assert (told["id"], told["objects"], told["graphs"]["view:v0"]) == (
        "hans",
        8,
        "urn:deixis:scene:hans:view:v0",
    )


def test_the_description_names_every_path(server: Server) -> None:
    told = server.send("GET", "/openapi.json").json
    assert told["openapi"].startswith("3.")
    assert set(told["paths"]) == {
        "/scenes", "/scenes/{scene}", "/scenes/{scene}/objects", "/scenes/{scene}/relations",
        "/scenes/{scene}/ask", "/scenes/{scene}/names", "/scenes/{scene}/why", "/scenes/{scene}/why-all",
        "/scenes/{scene}/why-not", "/scenes/{scene}/contrast", "/scenes/{scene}/change",
        "/scenes/{scene}/what-if", "/scenes/{scene}/view", "/scenes/{scene}/view/data",
        "/scenes/{scene}/updates", "/scenes/{scene}/changes",
    }  # fmt: skip
    relation = told["components"]["schemas"]["RelationTold"]["properties"]
    assert set(relation) == {"relation", "figure", "reference", "view", "margin"}


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/scenes/none/relations", 404), ("/scenes/hans/relations?view=v9", 400), ("/nothing", 404),
        ("/scenes/hans/relations?relation=on_topp_of", 400), ("/scenes/hans/relations?figure=none", 400),
        ("/scenes/hans/relations?limit=0", 422), ("/scenes/hans/why", 422), ("/docs", 404),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(server: Server, path: str, status: int) -> None:
    reply = server.send("GET", path)
    assert (reply.status, reply.headers["content-type"]) == (status, "application/problem+json")
    assert reply.detail
