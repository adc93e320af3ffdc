"""The JSON interface says what Python says, and its description is true."""

from __future__ import annotations

import json
from collections.abc import Iterator
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
        "/scenes/{scene}/ask", "/scenes/{scene}/why", "/scenes/{scene}/view",
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
