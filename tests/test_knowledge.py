"""The facade: what a knowledge base answers, refuses, starts and stops."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import deixis
from deixis import KnowledgeBase, Scene
from deixis._files import theory_files
from deixis.errors import DeixisError, EngineError, QueryError, QueryTimeout, RuleError, SceneError
from deixis.relations import Relation
from deixis.vocabulary import BASE, RELATIONS
from scenes import ROBOT, box, floor, scene, wall

CUP_ON_TABLE = scene(
    floor(),
    box("table", (0, 0, 0.36), (1.2, 0.8, 0.72)),
    box("cup", (0.2, 0.1, 0.77), (0.08, 0.08, 0.1)),
    name="cup on table",
)


@pytest.fixture(scope="module")
def kb(root: Path) -> Iterator[KnowledgeBase]:
    with KnowledgeBase.from_scene(root / "kb" / "scenes" / "hans.json") as running:
        yield running


def rows(found: tuple[Relation, ...]) -> list[tuple[str | None, ...]]:
    return [(one.relation, one.figure, one.reference, one.view) for one in found]


# Coming and going


def test_a_scene_comes_as_itself_or_as_a_path(root: Path, figure_3: Scene) -> None:
    path = root / "kb" / "scenes" / "hans.json"
    by_path, by_text = KnowledgeBase.from_scene(path), KnowledgeBase.from_scene(str(path))
    assert KnowledgeBase.from_scene(figure_3).scene is figure_3
    assert by_path.scene.to_dict() == by_text.scene.to_dict() == figure_3.to_dict()
    with pytest.raises(SceneError, match=r"none\.json' does not exist"):
        KnowledgeBase.from_scene(root / "none.json")


def test_facts_need_no_prolog(monkeypatch: pytest.MonkeyPatch) -> None:
    def started(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("deixis.prolog.PrologEngine", started)
    kb = KnowledgeBase(CUP_ON_TABLE)
    assert kb.facts.ids == ("floor", "table", "cup")
    assert kb.facts is kb.facts
    assert kb.withheld == ()
    assert "figure_reference('cup','table')" in kb.facts_text()
    kb.close()


def test_prolog_ends_with_the_block_and_may_begin_anew() -> None:
    with KnowledgeBase(CUP_ON_TABLE) as kb:
        first = kb.engine
        assert kb.engine is first
        assert kb.ask("on_top_of(cup, table)")
    with pytest.raises(EngineError, match="closed"):
        first.ask("true")
    assert kb.ask("on_top_of(cup, table)")
    assert kb.engine is not first
    kb.close()
    kb.close()


def test_prolog_ends_with_the_block_that_fails() -> None:
    kb = KnowledgeBase(CUP_ON_TABLE)
    engine = kb.engine
    with pytest.raises(QueryError), kb:
        kb.ask("on_top_of(cup")
    with pytest.raises(EngineError, match="closed"):
        engine.ask("true")


def test_several_at_once_do_not_mix() -> None:
    shelf = box("shelf", (0, 0, 0.5), (1, 1, 1))
    books = [box(f"book{number}", (0, 0, 1.1), (0.05, 0.1, 0.2)) for number in range(3)]
    bases = [KnowledgeBase(scene(floor(), shelf, book)) for book in books]
    try:
        for _ in range(2):
            for number, kb in enumerate(bases):
                assert [one["X"] for one in kb.ask("on_top_of(X, shelf)").bindings] == [f"book{number}"]
        with ThreadPoolExecutor(len(bases)) as pool:
            found = list(pool.map(lambda kb: kb.relations(relation=["on_top_of"]), bases))
        assert [one[0].figure for one in found] == ["book0", "book1", "book2"]
        bases[0].close()
        assert bases[1].ask("on_top_of(book1, shelf)")
    finally:
        for kb in bases:
            kb.close()


def test_the_package_offers_what_it_says() -> None:
    assert {name: getattr(deixis, name) for name in deixis.__all__} == {
        "KnowledgeBase": KnowledgeBase,
        "Scene": Scene,
        "__version__": deixis.__version__,
    }
    with pytest.raises(AttributeError, match="no attribute 'Kb'"):
        _ = deixis.Kb


# Relations


def test_relations_are_those_people_speak_in_in_order(kb: KnowledgeBase) -> None:
    found = kb.relations()
    order = [term.name for term in RELATIONS]
    keys = [(order.index(one.relation), one.figure, one.reference, one.view or "") for one in found]
    assert keys == sorted(set(keys))
    assert found == kb.relations(relation=order)
    views = {term.name for term in RELATIONS if term.view}
    assert all((one.view is not None) == (one.relation in views) for one in found)


def test_figure_and_reference_are_never_reversed(kb: KnowledgeBase) -> None:
    """A surface is no figure, nothing stands to itself, and a floor has no left."""
    for one in kb.relations():
        assert one.figure not in ("wall", "floor")
        assert one.figure != one.reference
        assert not (one.reference == "floor" and one.view)


def test_base_relations_come_when_named(kb: KnowledgeBase) -> None:
    found = kb.relations(relation=["touches", "on_top_of", "touches"])
    assert {one.relation for one in found} == {"touches", "on_top_of"}
    assert len(found) == len(set(rows(found)))
    pairs = {(one.figure, one.reference) for one in found if one.relation == "touches"}
    assert ("wall", "sign") in pairs
    assert pairs == {(b, a) for a, b in pairs}
    kb.relations(relation=[term.name for term in BASE])


def test_a_view_leaves_out_what_others_see(kb: KnowledgeBase) -> None:
    everything = kb.relations()
    for view in ("v0", "v1"):
        assert kb.relations(view=view) == tuple(one for one in everything if one.view in (None, view))


def test_a_relation_can_be_passed_on(kb: KnowledgeBase) -> None:
    (found,) = kb.relations(relation=["left_of"])
    assert found.to_prolog() == "left_of('extinguisher2','radiator','v0')"
    assert Relation(**found.to_dict()) == found
    assert kb.ask(found.to_prolog())


def test_margins_are_metres_to_the_edge(kb: KnowledgeBase) -> None:
    """A cup hovering over a table touches it up to D = 2 cm, so what is left of D is the margin."""
    table = box("table", (0, 0, 0.36), (1.2, 0.8, 0.72))
    for gap in (0.0, 0.004, 0.0155):
        cup = box("cup", (0.2, 0.1, 0.77 + gap), (0.08, 0.08, 0.1))
        with KnowledgeBase(scene(table, cup)) as other:
            (found,) = other.relations(relation=["on_top_of"])
        assert found.margin == pytest.approx(0.02 - gap, abs=1e-9)
    assert all(one.margin is not None and one.margin >= 0.0 for one in kb.relations())


def test_withheld_says_why() -> None:
    inside = {**ROBOT, "position": [0.1, 0.0, 0.3]}
    in_plane = {**ROBOT, "id": "v1", "position": [2.0, 5.0, 0.3]}
    kb = KnowledgeBase(scene(floor(), wall(), CUP_ON_TABLE.to_dict()["objects"][1], views=[inside, in_plane]))
    assert {(one.view, one.reference, one.reason.split(",")[0]) for one in kb.withheld} == {
        ("v0", "floor", "the view stands within the footprint of this reference"),
        ("v0", "table", "the view stands within the footprint of this reference"),
        ("v1", "wall", "the view stands in the plane of this surface"),
    }


# Questions


def test_answers_tell_whether_there_are_more(kb: KnowledgeBase) -> None:
    some, every = kb.ask("near(X, wall)", limit=2), kb.ask("near(X, wall)")
    assert (len(some.bindings), some.truncated, every.truncated) == (2, True, False)
    assert some.bindings == every.bindings[:2]
    assert not kb.ask("on_top_of(wall, X)")


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ("on_top(X, Y)", "did you mean on_top_of/2"),
        ("on_top_of(X", "syntax error"),
        ("", "empty"),
        ("halt", "not allowed"),
    ],
)
def test_a_bad_question_is_refused_and_does_no_harm(goal: str, words: str, kb: KnowledgeBase) -> None:
    with pytest.raises(QueryError, match=words):
        kb.ask(goal)
    with pytest.raises(QueryError, match=words):
        kb.why(goal)
    assert kb.ask("on_top_of(sweater, heater)")


def test_one_relation_may_be_given_as_it_is(kb: KnowledgeBase) -> None:
    assert kb.relations(relation="on_top_of") == kb.relations(relation=["on_top_of"]) != ()
    assert kb.proofs(relation="leans_on") == kb.proofs(relation=["leans_on"]) != {}
    with pytest.raises(QueryError, match="no relation 'ontop': did you mean 'on_top_of'"):
        kb.relations(relation="ontop")
    with KnowledgeBase(kb.scene, rules="support") as one:
        assert one.relations(relation="supported_by")


def test_unknown_names_are_refused_with_what_may_be_meant(kb: KnowledgeBase) -> None:
    with pytest.raises(QueryError, match="no relation 'ontop': did you mean 'on_top_of'"):
        kb.relations(relation=["near", "ontop"])
    with pytest.raises(QueryError, match="no view 'v2' in scene 'hans'"):
        kb.relations(view="v2")
    with pytest.raises(QueryError, match="'radiatr' in scene 'hans': did you mean 'radiator'"):
        kb.why("near(sign, radiatr)")
    with KnowledgeBase(scene(views=())) as empty, pytest.raises(QueryError, match="there are none"):
        empty.relations(view="v0")


def test_a_time_out_leaves_the_knowledge_base_usable(kb: KnowledgeBase) -> None:
    with pytest.raises(QueryTimeout, match=r"no answer within 0\.1 s"):
        kb.ask("between(1, inf, X), X < 0", timeout=0.1)
    assert kb.ask("on_top_of(sweater, heater)")


# Rules of one's own


def test_rules_of_ones_own_are_asked_and_explained_like_ours(figure_3: Scene, tmp_path: Path) -> None:
    rules = tmp_path / "drying.pl"
    rules.write_text(
        "% A thing that lies on something warm dries.\n"
        "dries(Thing) :-\n"
        "    on_top_of(Thing, Warm),\n"
        "    label(Warm, 'electric heater', Score),\n"
        "    Score >= 0.5.\n",
        encoding="utf-8",
    )
    with KnowledgeBase.from_scene(figure_3, rules=[rules]) as kb:
        assert [one["X"] for one in kb.ask("dries(X)").bindings] == ["sweater"]
        proof = kb.why("dries(sweater)").proof
        assert proof is not None
        assert (proof.rule.file, proof.rule.line, proof.axiom) == ("drying.pl", 2, None)
        assert proof.margin == pytest.approx(0.02)
        assert not kb.why("dries(radiator)")
        assert rows(kb.relations()) == rows(KnowledgeBase(figure_3).relations())


def test_rules_that_do_not_load_are_refused(figure_3: Scene, tmp_path: Path) -> None:
    with pytest.raises(RuleError, match="no rule file"):
        KnowledgeBase(figure_3, rules=[tmp_path / "none.pl"]).relations()
    for text, words in (("p(X) :- q(X", "bad.pl:1"), ("p(X) :- near(X, Y).\n", "Singleton")):
        bad = tmp_path / "bad.pl"
        bad.write_text(text, encoding="utf-8")
        kb = KnowledgeBase(figure_3, rules=[bad])
        with pytest.raises(RuleError, match=words):
            kb.relations()
        kb.close()


def test_all_rule_files_of_the_theory_are_there() -> None:
    files = theory_files()
    assert all(file.is_file() for file in files)
    assert {"facts", "topology", "direction", "commonsense"} <= {file.stem for file in files}


def test_errors_are_of_one_family() -> None:
    for kind in (SceneError, QueryError, QueryTimeout, RuleError, EngineError):
        assert issubclass(kind, DeixisError)
