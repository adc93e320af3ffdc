"""Words: every language says everything, in both polarities; rules of one's own are put in words too."""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import asdict
from pathlib import Path

import pytest

from commands import call
from deixis import KnowledgeBase, Scene
from deixis._files import languages
from deixis.errors import QueryError
from deixis.vocabulary import BASE, RELATIONS
from deixis.wording import ENGLISH
from scenes import box, floor, scene

# Says each predicate of some arguments, with and without "not", and lists what else a language has words for.
PROBE = r"""
:- set_prolog_flag(encoding, utf8).
:- use_module(library(lists), [member/2]).

main :-
    current_prolog_flag(argv, [Language|Files]),
    load_files(Files, [imports([])]),
    maplist(assert_fact, [spatial_obj(a), spatial_obj(b), label(a, cup, 1.0), label(b, table, 1.0),
                          viewpoint(v), view_label(v, robot)]),
    words:language(Language),
    findall(Name/Arity, predicate(Name, Arity), Found),
    sort(Found, Predicates),
    forall(member(Name/Arity, Predicates), two(Name, Arity)),
    forall(member(rule(Rule, Arity), [rule(extinguisher_off_wall, 2), rule(extinguisher_without_sign, 2),
                                      rule(fire_hazard, 3), rule(fire_door_leant_on, 3),
                                      rule(heater_in_free_area, 3), rule(some_other_rule, 2),
                                      rule(some_other_rule, 3)]),
           two_of(Rule, Arity)),
    forall(Language:said(Name, Format), line([said, Name, Format])),
    forall(Language:connective(Name, Text), line([connective, Name, Text])),
    forall(Language:side(Side, _, _), line([side, Side, ''])),
    forall(Language:place(Place, _), line([place, Place, ''])),
    forall(Language:none(Goal, _), ( numbervars(Goal), line([none, Goal, '']) )),
    forall(Language:no_other(Goal, _, _), ( numbervars(Goal), line([no_other, Goal, '']) )),
    forall(Language:hindered(What, _), ( functor(What, Name, _), line([hindered, Name, '']) )).

assert_fact(Fact) :- assertz(facts:Fact).

predicate(Name, Arity) :-
    member(Module, [facts, topology, direction, commonsense, support, background]),
    module_property(Module, exports(Exports)),
    member(Name/Arity, Exports).
predicate(Name, Arity) :-
    member(Name/Arity, [recognised_as/2, is_a/2, burnable/2, hot/1, in_contact/2, on_wall/2, has_near/3,
                        leans_against/2, in_area/2]),
    current_predicate(user:Name/Arity).

two_of(Rule, Arity) :-
    functor(Goal, violation, Arity),
    arg(1, Goal, Rule),
    arg(2, Goal, a),
    ( Arity =:= 3 -> arg(3, Goal, b) ; true ),
    both(Rule/Arity, Goal).

two(Name, Arity) :-
    forall(member(Number, [0.5, -0.5]),
           ( functor(Goal, Name, Arity),
             Goal =.. [_|Args],
             filled(Name, Args, Number),
             both(Name/Arity, Goal)
           )).

filled(aspect, [v, a, b, N, N, N, N], N) :- !.
filled(Name, [a, b, 'Y+', v], _) :- memberchk(Name, [int_hs, cont_hs]), !.
filled(Name, [a, b, 'Y+', v, N], N) :- memberchk(Name, [halfspace, strict]), !.
filled(label, [a, cup, N], N) :- !.
filled(Name, [v|Rest], _) :- memberchk(Name, [viewpoint, view_label]), !, maplist(=(robot), Rest).
filled(withheld, [a, v, why], _) :- !.
filled(threshold, [granularity, N], N) :- !.
filled(pair, [a, b|Ns], N) :- !, maplist(=(N), Ns).
filled(_, [a], _) :- !.
filled(Name, [a, b, v], _) :- axioms:relation(Name/3), !.
filled(has_near, [a, cup, b], _) :- !.
filled(_, [a, b|Ns], N) :- maplist(=(N), Ns).

both(Predicate, Goal) :-
    verbalise:node_text(node(fact, Goal, inf, none, []), Yes),
    verbalise:denied_text(Goal, No),
    line([sentence, Predicate, Yes]),
    line([denial, Predicate, No]).

line([Kind, Name, Text]) :-
    format("~w\t~q\t~w~n", [Kind, Name, Text]).
"""

FILES = ("facts", "topology", "direction", "commonsense", "axioms", "support", "safety", "explain")


@pytest.fixture(scope="module")
def said(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[tuple[str, str, str]]]:
    """Return what each language says."""
    probe = tmp_path_factory.mktemp("probe") / "probe.pl"
    probe.write_text(PROBE, encoding="utf-8")
    found = {}
    for language in languages():
        names = [*FILES, f"lang/{language}"]
        result = subprocess.run(
            ["swipl", "-f", "none", "-g", "main", "-t", "halt", str(probe), "--", language]
            + [str(root / "rules" / f"{name}.pl") for name in names],
            capture_output=True,
            encoding="utf-8",
            timeout=60,
            check=False,
        )
        assert (result.returncode, result.stderr) == (0, ""), result.stderr
        rows = [line.split("\t") for line in result.stdout.splitlines()]
        found[language] = [(kind, name, text) for kind, name, text in rows]
    return found


def test_every_language_says_every_predicate_in_both_polarities(
    said: dict[str, list[tuple[str, str, str]]],
) -> None:
    for language, rows in said.items():
        yes = [row for row in rows if row[0] == "sentence"]
        no = [row for row in rows if row[0] == "denial"]
        assert {f"{one.name}/{one.arity}" for one in (*RELATIONS, *BASE)} <= {name for _, name, _ in yes}
        assert len(yes) > 130
        for (_, name, one), (_, _, other) in zip(yes, no, strict=True):
            assert one != other, (language, name)
            strange = r"\w\(|not so that|trifft nicht zu|  |_G?\d|~"
            assert not re.search(strange, one + other), (
                language,
                one,
                other,
            )
            assert one.strip() == one
            assert other.strip() == other


def test_every_language_has_words_for_the_same_things(said: dict[str, list[tuple[str, str, str]]]) -> None:
    def shapes(language: str) -> set[tuple[str, str, int]]:
        return {(kind, name, text.count("~w")) for kind, name, text in said[language]
                if kind not in ("sentence", "denial")}  # fmt: skip

    assert set(said) >= {"en", "de"}
    for language in said:
        # A pronoun is had where one fits every thing in every place.
        assert shapes(language) | {("said", "it", 0)} == shapes("en"), language


def test_the_words_in_python_are_those_of_english(said: dict[str, list[tuple[str, str, str]]]) -> None:
    connectives = {name: text for kind, name, text in said["en"] if kind == "connective"}
    assert {connectives[name.removesuffix("_")]: text for name, text in asdict(ENGLISH).items()} == {
        text: text for text in asdict(ENGLISH).values()
    }


def test_no_sentence_is_written_outside_the_language_files(root: Path) -> None:
    """What has no name of a template is punctuation or an amount's format."""
    for name in ("verbalise", "refusals", "naming", "amounts", "outline"):
        text = (root / "rules" / f"{name}.pl").read_text(encoding="utf-8")
        lines = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).splitlines()
        code = "\n".join(line.split("%")[0] for line in lines)
        assert [one for one in re.findall(r'"([^"\n]*)"', code) if re.search(r"[a-z]{2}", one)] == []


GERMAN = {
    "on_top_of(sweater, heater)": "„sweater“ ist auf „electric heater“",
    "left_of(extinguisher2, radiator, v0)":
        "„fire extinguisher“ auf „floor“ ist links von „radiator“ von „robot“ aus gesehen",
    "left_of(extinguisher2, radiator, v1)":
        "„fire extinguisher“ auf „floor“ ist nicht links von „radiator“ von dir aus gesehen "
        "(es fehlen 11 cm)",
}  # fmt: skip


def test_a_denial_that_leaves_open_what_a_thing_is_to_be_made_of_is_a_sentence(figure_3: Scene) -> None:
    said = {
        "en": [
            "contact with the electric heater and it is not made of anything which burns.",
            "The fire extinguisher sign is not made of anything which burns, because ",
        ],
        "de": [
            "und „radiator“ besteht aus nichts Brennbarem.",
            "„fire extinguisher sign“ besteht aus nichts",
        ],
    }
    for language, (hazard, sign) in said.items():
        with KnowledgeBase(figure_3, language=language, rules=["safety"]) as kb:
            assert kb.why_not("violation(fire_hazard, radiator, heater)").sentence().endswith(hazard)
            assert kb.why_not("burnable(sign, What)").sentence().startswith(sign)
            assert "close" not in kb.why("burnable(sign, What)").text
    with KnowledgeBase(figure_3, rules=["safety"]) as kb:
        # Where something else is open, that is said, and not that there is none.
        assert "something is made of cork which burns" in kb.why("burnable(Thing, cork)").text
        assert kb.why("on_wall(extinguisher2, Wall)").text.startswith("no wall holds the fire extinguisher")


def test_german(figure_3: Scene) -> None:
    with KnowledgeBase(figure_3, language="de") as kb:
        for goal, text in GERMAN.items():
            assert kb.why(goal).text == text
        assert kb.names()["extinguisher2"] == "„fire extinguisher“ auf „floor“"
        for one in kb.relations():
            proof = kb.why(one.to_prolog()).proof
            assert proof is not None
            told = f"{proof.full()} {proof.sentence()} {proof.brief()}"
            words = set(re.findall(r"[a-z]+", re.sub(r"„.*?“|\[.*?\]", "", told)))
            assert not words & {"the", "is", "not", "and", "because", "short", "by", "seen", "closest"}
        other = kb.why_not("affixed_on(extinguisher2, wall)").sentence()
        assert ", denn „floor“ berührt „fire extinguisher“ auf „floor“." in other
        assert "aber" in kb.contrast("leans_on(extinguisher2, wall)", "affixed_on(extinguisher2, wall)").text
        assert (
            kb.check().violations[-1].text == "„sweater“ ist eine Brandgefahr auf oder an „electric heater“"
        )
        with kb.what_if({"sweater": (0.0, 0.0, 0.1)}) as then:
            assert then.why("on_top_of(sweater, heater)").text.endswith("(es fehlen 8 cm)")
    with pytest.raises(QueryError, match="known are de, en"):
        KnowledgeBase(figure_3, language="../en")


def test_german_at_the_command_line(root: Path) -> None:
    hans = root / "kb" / "scenes" / "hans.json"
    told = call("why", hans, "on_top_of(sweater, heater)", "--lang", "de", "--length", "brief")
    assert told.out.startswith("„sweater“ ist auf „electric heater“, denn ")
    for command, *rest in (
        ("why-not", "on_top_of(sign, heater)"),
        ("contrast", "near(sign, wall)", "--rather-than", "near(sign, heater)"),
        ("what-if", "--move", "sweater=0,0,0.1"),
        ("check",),
    ):
        told = call(command, hans, *rest, "--lang", "de")
        assert told.err == ""
        assert "„" in told.out
    assert call("why", hans, "near(sign, wall)", "--lang", "fr").code == 2


RULES = """
%!  rests_on(?Figure, ?Reference) is nondet.
%   Figure stands on Reference, directly or by way of other things.
rests_on(Figure, Reference) :-
    on_top_of(Figure, Reference).
rests_on(Figure, Reference) :-
    on_top_of(Figure, Other),
    rests_on(Other, Reference).

gap_to(A, B, Gap) :- distance(A, B, Gap), Gap > 0.1.

violation(too_high, Thing) :- rests_on(Thing, table), gap_to(Thing, floor, Gap), Gap > 0.5.

says(rests_on, '{1} rests on {2}', '{1} does not rest on {2}').
says(gap_to, '{1} is {3} from {2}', '{1} is not {3} from {2}').
says(too_high, '{1} is too high up', '{1} is not too high up').
"""

MORE = """
seen_left(A, B, View) :- left_of(A, B, View).
says(seen_left, 'from {3}: {1}, then {2} {9}', 'not {3}').
"""


def test_rules_of_ones_own_are_put_in_words(tmp_path: Path) -> None:
    first, second = tmp_path / "first.pl", tmp_path / "second.pl"
    first.write_text(RULES, encoding="utf-8")
    second.write_text(MORE, encoding="utf-8")
    table = box("table", (0.0, 0.0, 0.35), (0.8, 1.6, 0.7))
    room = scene(
        floor(), table, box("tray", (0, 0, 0.71), (0.4, 0.4, 0.02)), box("cup", (0, 0, 0.77), (0.1,) * 3)
    )
    with KnowledgeBase(room, rules=[first, second]) as kb:
        assert kb.why("rests_on(cup, floor)").text == "the cup rests on the floor"
        assert kb.why_not("rests_on(floor, cup)").text == "the floor does not rest on the cup"
        assert kb.why("gap_to(cup, floor, N)").text == "the cup is 72 cm from the floor"
        assert kb.why("violation(too_high, cup)").text == "the cup is too high up"
        assert kb.why_not("seen_left(cup, table, v0)").text == "not as seen from the robot"
        assert {one.figure for one in kb.relations(relation=["rests_on"])} == {"cup", "table", "tray"}
    assert call("rules", "check", first, second).code == 0


PRONOUNS = """
kept_off(A, B) :- near(A, B), \\+ touches(B, A).
sure(A, B) :- label(A, _, S), \\+ ( label(A, _, More), More > S ), near(A, B).
bare(A, B) :- near(A, B), \\+ on_top_of(_, B).
says(sure, '{1} is surely by {2}', '{1} is not surely by {2}').
says(bare, '{1} is by {2}, which is bare', '{1} is by {2}, which is not bare').
"""


def test_it_stands_for_what_was_named_and_for_nothing_else(tmp_path: Path) -> None:
    rules = tmp_path / "own.pl"
    rules.write_text(PRONOUNS, encoding="utf-8")
    table = box("table", (0.0, 0.0, 0.35), (0.8, 1.6, 0.7))
    cup, mug = (box(name, (0.0, y, 0.8), (0.1,) * 3) for name, y in (("cup", -0.3), ("mug", 2.2)))
    with KnowledgeBase(scene(table, cup, mug), rules=[rules]) as kb:

        def because(goal: str) -> str:
            proof = kb.why(goal).proof
            assert proof is not None
            return proof.sentence().partition(", because ")[2]

        # A conclusion that no template says has named nothing.
        assert because("kept_off(cup, table)").startswith("the cup is near the table and the table does not ")
        assert "touch the cup (short by 3 cm)" in because("kept_off(cup, table)")
        # What is not said between two reasons takes nothing from the second.
        assert because("sure(cup, table)").endswith(" with a score of 1 and it is near the table.")
        assert "it is near the table" in because("bare(cup, table)")
        assert "(the closest is the cup, short by 3 cm)" in because("bare(cup, table)")
        # After the fact "it" would be the table.
        assert (
            "the mug is not on top of the cup" in kb.contrast("near(cup, table)", "on_top_of(mug, cup)").text
        )
        assert "but it is not on top of" in kb.contrast("near(cup, table)", "on_top_of(cup, table)").text


HOSTILE = ("<script>alert(1)</script>", "'). halt. %", "~w ~p ~@", "{1}", "%d", 'say "hi"', "„x“")


@pytest.mark.parametrize("language", ["en", "de"])
def test_labels_are_text(language: str) -> None:
    things = [
        box(f"t{number}", (0.0, 0.0, 0.05 + 0.1 * number), (0.1, 0.1, 0.1), label=label)
        for number, label in enumerate(HOSTILE)
    ]
    with KnowledgeBase(scene(floor(), *things), language=language) as kb:
        names = kb.names()
        for number, label in enumerate(HOSTILE):
            assert label in names[f"t{number}"]
            if number:
                for told in (
                    kb.why(f"on_top_of(t{number}, t{number - 1})").told("full"),
                    kb.why_not(f"on_top_of(t{number - 1}, t{number})").sentence(),
                    kb.contrast(f"near(t{number}, floor)", f"inside(t{number}, floor)").sentence(),
                    json.dumps(kb.why(f"near(t{number}, floor)").to_dict(), ensure_ascii=False).replace(
                        '\\"', '"'
                    ),
                ):
                    assert label in told


def test_three_lengths(figure_3: Scene) -> None:
    with KnowledgeBase(figure_3) as kb:
        proof = kb.why("affixed_on(extinguisher1, wall)").proof
        assert proof is not None
        assert proof.told() == proof.outline()
        assert proof.told("brief") == proof.brief()
        assert proof.brief().count("because") == 1
        assert "\n" not in proof.brief()
        full = proof.told("full").splitlines()
        assert len(full) > len(proof.outline().splitlines())
        assert re.search(r"\[axiom 38, commonsense.pl:\d+, margin 0.02 m\]$", full[0])
        assert any(line.strip().startswith("the threshold granularity is 0.02  [threshold(") for line in full)
        assert any(re.search(r"\[0 =< 0.02, margin 0.02 m\]$", line) for line in full)
        assert any(re.search(r"margin -0.27 m, fails\]$", line) for line in full)


def test_all_proofs(figure_3: Scene) -> None:
    with KnowledgeBase(figure_3) as kb:
        one = kb.why("on_top_of(sweater, heater)").proof
        every = kb.why_all("on_top_of(sweater, heater)")
        assert (every.proofs, every.truncated) == ((one,), False)
        cut = kb.why_all("near(X, Y)", limit=3)
        assert (len(cut.proofs), cut.truncated) == (3, True)
        assert cut.proofs[0] == kb.why("near(X, Y)").proof
        assert len(kb.why_all("near(X, Y)", limit=1).proofs) == 1
        assert not kb.why_all("near(sign, heater)")
        with pytest.raises(QueryError, match="limit is 0"):
            kb.why_all("near(X, Y)", limit=0)


def test_a_thing_in_contact_in_two_ways_has_two_proofs() -> None:
    board = scene(
        floor(),
        {"id": "wall", "kind": "surface", "label": "wall",
         "polygon": [[2, -3, 0], [2, 3, 0], [2, 3, 2.5], [2, -3, 2.5]]},
        box("board", (1.98, 0.5, 0.615), (0.04, 0.8, 1.2)),
        box("brick", (1.9, 0.5, 0.0), (0.2, 0.1, 0.03)),
    )  # fmt: skip
    with KnowledgeBase(board) as kb:
        found = kb.why_all("leans_on(board, wall)")
        best = kb.why("leans_on(board, wall)").proof
    assert len(found.proofs) == 2
    assert found.proofs[0] == best
