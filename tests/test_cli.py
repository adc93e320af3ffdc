"""The command line: what each command prints, where, and with which exit code; and what it refuses."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from commands import Result, call, run
from deixis import Scene, __version__
from deixis.cli.commands import app
from deixis.errors import DeixisError
from deixis.prolog.find import find_prolog
from deixis.scene import scene_schema
from deixis.vocabulary import RELATIONS
from scenes import ROBOT, box, floor

YES, NO, ERROR, TIME_OUT = 0, 1, 2, 3

Write = Callable[..., Path]


@pytest.fixture(scope="session")
def hans(root: Path) -> Path:
    return root / "kb" / "scenes" / "hans.json"


@pytest.fixture(scope="session")
def strange(root: Path) -> Path:
    """Return a scene whose ids look like code."""
    return root / "tests" / "golden" / "names_are_only_names.json"


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes a scene file of some objects."""

    def file(*objects: dict[str, Any], name: str = "scene.json", **rest: Any) -> Path:
        path = tmp_path / name
        scene = {"deixis": 1, "id": "test", "objects": list(objects), "views": [ROBOT], **rest}
        path.write_text(json.dumps(scene), encoding="utf-8")
        return path

    return file


def refused(result: Result, *words: str) -> str:
    """Check that nothing but one message of an error was printed, and return it."""
    assert (result.code, result.out) == (ERROR, "")
    assert result.err.startswith("deixis: ")
    assert "Traceback" not in result.err
    for word in words:
        assert word in result.err
    return result.err


# Help


def test_without_a_command_all_are_listed() -> None:
    result = run()
    assert (result.code, result.out) == (ERROR, "")
    for command in app.registered_commands:
        name = command.name or command.callback.__name__
        assert re.search(rf"^  {name}  +[A-Z]", result.err, re.MULTILINE)
    assert "0 yes, 1 no, 2 error, 3 time-out" in result.err


def test_help_and_version_are_data(root: Path) -> None:
    shown = run("relations", "-h")
    assert (shown.code, shown.err) == (YES, "")
    assert all(option in shown.out for option in ("SCENE", "--view", "--relation", "--format", "--timeout"))
    script = Path(sys.executable).with_name("deixis")
    told = subprocess.run([script, "--version"], cwd=root, capture_output=True, text=True, check=True)
    assert told.stdout == f"deixis {__version__}\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ["frob"],
        ["relations"],
        ["relations", "hans.json", "--format", "xml"],
        ["relations", "hans.json", "--timeout", "0"],
        ["ask", "hans.json", "true", "--limit", "0"],
        ["why", "hans.json"],
        ["import", "ithor", "rooms.jsonl"],
    ],
    ids=" ".join,
)
def test_wrong_use_is_an_error(arguments: list[str]) -> None:
    result = call(*arguments)
    assert (result.code, result.out) == (ERROR, "")
    assert "Usage: deixis" in result.err


# relations


def test_relations_as_json(hans: Path) -> None:
    result = call("relations", hans, "--format", "json")
    assert (result.code, result.err) == (YES, "")
    said = json.loads(result.out)
    assert list(said) == ["scene", "measured_as", "relations", "withheld"]
    assert said["measured_as"]["sweater"] == "box"
    assert said["scene"] == "hans"
    order = {term.name: position for position, term in enumerate(RELATIONS)}
    keys = []
    for one in said["relations"]:
        assert list(one) == ["relation", "figure", "reference", "view", "margin"]
        assert one["margin"] >= 0.0
        keys.append((order[one["relation"]], one["figure"], one["reference"], one["view"] or ""))
    assert keys == sorted(set(keys))
    assert {(one["reference"], one["view"]) for one in said["withheld"]} == {("floor", "v0"), ("floor", "v1")}


def test_relations_as_csv_and_as_a_table_are_those_as_json(hans: Path, tmp_path: Path) -> None:
    said = json.loads(call("relations", hans, "--format", "json").out)["relations"]
    plain = list(csv.DictReader(io.StringIO(call("relations", hans, "--format", "csv").out)))
    assert plain == [{name: str(value or "") for name, value in one.items()} for one in said]
    table = call("relations", hans)
    head, *lines = table.out.splitlines()
    columns = [found.start() for found in re.finditer(r"\w+", head)]
    cells = [
        [line[start:end].strip() for start, end in zip(columns, [*columns[1:], None], strict=True)]
        for line in lines
    ]
    names = ("relation", "figure", "reference", "view")
    assert cells == [[*(one[name] or "" for name in names), f"{one['margin']:.3f}"] for one in said]
    assert table.err == ""
    robot = json.loads(hans.read_text(encoding="utf-8"))
    unsteady = tmp_path / "unsteady.json"
    unsteady.write_text(json.dumps(robot | {"thresholds": {"pose_noise": 0.05}}), encoding="utf-8")
    noise = [one for one in said if one["margin"] < 0.05]
    told = f"deixis: {len(noise)} of {len(said)} hold by less than the pose noise of 5 cm\n"
    assert call("relations", unsteady).err == told


def test_relations_of_one_view_and_of_some_names(hans: Path) -> None:
    options = ("--relation", "left_of", "--relation", "on_top_of", "--relation", "touches", "--format", "csv")
    robot = call("relations", hans, "--view", "v0", *options)
    person = call("relations", hans, "--view", "v1", *options)
    rows = [tuple(row[:4]) for row in csv.reader(io.StringIO(robot.out))][1:]
    assert {row[0] for row in rows} == {"touches", "left_of", "on_top_of"}
    assert ("left_of", "extinguisher2", "radiator", "v0") in rows
    assert [line for line in robot.out.splitlines() if "left_of" not in line] == person.out.splitlines()


def test_no_relation_is_no(write: Write) -> None:
    alone = write(box("cup", (0, 0, 0), (0.1, 0.1, 0.1)))
    for output, text in (
        ("table", "relation  figure  reference  view  margin\n"),
        ("csv", "relation,figure,reference,view,margin\n"),
        ("pl", ""),
    ):
        assert call("relations", alone, "--format", output) == Result(NO, text, "")
    result = call("relations", alone, "--format", "json")
    assert (result.code, json.loads(result.out)["relations"]) == (NO, [])


def test_an_empty_scene_is_a_scene(write: Write) -> None:
    assert call("relations", write(), "--format", "csv").code == NO
    assert json.loads(call("facts", write(), "--format", "json").out)["facts"] == []


# facts


def test_facts_as_json_and_csv(hans: Path) -> None:
    result = call("facts", hans, "--format", "json")
    assert (result.code, result.err) == (YES, "")
    said = json.loads(result.out)
    assert said["thresholds"]["granularity"] == 0.02
    touching = {(one["figure"], one["reference"]) for one in said["facts"] if one["touches"]}
    assert {("sweater", "heater"), ("heater", "sweater"), ("extinguisher2", "wall")} <= touching
    plain = list(csv.DictReader(io.StringIO(call("facts", hans, "--format", "csv").out)))
    assert [list(one) for one in plain] == [list(one) for one in said["facts"]]
    for ours, theirs in zip(plain, said["facts"], strict=True):
        assert (ours["figure"], ours["reference"]) == (theirs["figure"], theirs["reference"])
        assert float(ours["separation"]) == theirs["separation"]
    table = call("facts", hans)
    assert len(table.out.splitlines()) == 1 + len(said["facts"])


# Prolog text, read by an ordinary swipl


def swipl(tmp_path: Path, goal: str, *files: Path) -> str:
    """Return what a plain SWI-Prolog prints, to which any warning is an error."""
    told = subprocess.run(
        [
            find_prolog().executable,
            "--on-warning=status",
            "-q",
            "-f",
            "none",
            "-g",
            goal,
            "-t",
            "halt",
            *files,
        ],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert (told.returncode, told.stderr) == (0, "")
    return told.stdout


def test_relations_as_prolog_can_be_consulted(strange: Path, tmp_path: Path) -> None:
    result = call("relations", strange, "--format", "pl")
    assert (result.code, result.err) == (YES, "")
    assert all(line.endswith(").") for line in result.out.splitlines())
    (tmp_path / "found.pl").write_text(result.out, encoding="utf-8")
    printed = swipl(tmp_path, r'forall(on_top_of(X, Y), format("~w\t~w~n", [X, Y]))', tmp_path / "found.pl")
    table = Scene.load(strange).objects[0].id
    assert printed == "".join(f"{cup}\t{table}\n" for cup in ("'). halt. %", "1.0", "null"))


def test_facts_as_prolog_can_be_consulted(strange: Path, tmp_path: Path) -> None:
    result = call("facts", strange, "--format", "pl")
    assert (result.code, result.err) == (YES, "")
    assert all(line.endswith(".") for line in result.out.splitlines())
    (tmp_path / "facts.pl").write_text(result.out, encoding="utf-8")
    printed = swipl(
        tmp_path, r'forall(label(X, Y, Z), format("~w\t~w\t~w~n", [X, Y, Z]))', tmp_path / "facts.pl"
    )
    assert printed == "".join(
        f"{thing.id}\t{thing.label}\t1.0\n" for thing in Scene.load(strange).objects if thing.label
    )


# ask


def test_answers_as_text(hans: Path) -> None:
    assert call("ask", hans, "on_top_of(X, floor)") == Result(YES, "X = extinguisher2\nX = heater\n", "")
    assert call("ask", hans, "on_top_of(sweater, heater).") == Result(YES, "true\n", "")
    assert call("ask", hans, "on_top_of(sweater, floor)") == Result(NO, "false\n", "")
    assert call("ask", hans, "forall(on_top_of(X, Y), touches(X, Y))") == Result(YES, "true\n", "")


def test_answers_as_json(hans: Path) -> None:
    result = call("ask", hans, "threshold(granularity, D), X = at(D, [cup])", "--format", "json")
    assert (result.code, result.err) == (YES, "")
    assert json.loads(result.out) == {
        "goal": "threshold(granularity, D), X = at(D, [cup])",
        "answers": [{"D": 0.02, "X": {"functor": "at", "args": [0.02, ["cup"]]}}],
        "truncated": False,
        "timed_out": False,
        "output": "",
        "notes": [],
    }
    none = call("ask", hans, "on_top_of(sweater, floor)", "--format", "json")
    assert (none.code, json.loads(none.out)["answers"]) == (NO, [])


def test_what_an_option_may_be_is_said_plainly(hans: Path) -> None:
    told = call("relations", hans, "--format", "xml").err
    assert "Invalid value for '--format': 'xml' is not one of 'table', " in told
    assert "Value error" not in told + call("rules", "graph", "--format", "xml").err


def test_a_scene_without_things_is_described(tmp_path: Path) -> None:
    empty = tmp_path / "empty.json"
    empty.write_text('{"deixis": 1, "id": "empty"}')
    assert call("describe", empty) == Result(NO, "There is nothing to describe here.\n", "")


@pytest.mark.parametrize(
    ("goal", "code", "out", "names"),
    [
        ("on_top_of(X, heeter)", NO, "false\n", [("heeter", "heater")]),
        ("touches(sweter, floor)", NO, "false\n", [("sweter", "sweater")]),
        ("left_of(X, radiatr, v1)", NO, "false\n", [("radiatr", "radiator")]),
        (
            "near(X, heeter) ; touches(flor, X), \\+ near(X, heeter)",
            NO,
            "false\n",
            [("heeter", "heater"), ("flor", "floor")],
        ),
        ("maplist(near(heeter), [X])", NO, "false\n", [("heeter", "heater")]),
        (
            "once(on_top_of(X, floor)), \\+ near(X, heeter)",
            YES,
            "X = extinguisher2\n",
            [("heeter", "heater")],
        ),
        ("label(X, cupboard, S)", NO, "false\n", []),
        ("view_label(V, me)", NO, "false\n", []),
        ("X = heeter, near(X, Y)", NO, "false\n", []),
    ],
)
def test_a_name_that_nothing_has_is_told_beside_the_answer(
    hans: Path, goal: str, code: int, out: str, names: list[tuple[str, str]]
) -> None:
    notes = [f"nothing is called {name!r} in scene 'hans': did you mean {meant!r}?" for name, meant in names]
    assert call("ask", hans, goal) == Result(code, out, "".join(f"deixis: {note}\n" for note in notes))
    assert json.loads(call("ask", hans, goal, "--format", "json").out)["notes"] == notes


def test_a_cut_off_answer_says_so(hans: Path) -> None:
    result = call("ask", hans, "near(X, Y)", "--limit", "2")
    assert (result.code, len(result.out.splitlines())) == (YES, 2)
    assert result.err == "deixis: there are more answers than the 2 printed\n"
    assert json.loads(call("ask", hans, "near(X, Y)", "--limit", "2", "--format", "json").out)["truncated"]


def test_a_time_out_says_so(hans: Path) -> None:
    result = call("ask", hans, "between(1, inf, X), X < 0", "--timeout", "0.2", "--format", "json")
    said = json.loads(result.out)
    assert (result.code, said["timed_out"], said["truncated"], said["answers"]) == (TIME_OUT, True, True, [])
    assert result.err.startswith("deixis: no answer within 0.2 s")


def test_what_a_question_prints_is_shown(hans: Path) -> None:
    result = call("ask", hans, 'on_top_of(sweater, X), format("on ~w\\x1b\\[31m~n", [X])')
    assert result == Result(YES, "on heater\\x1b[31m\nX = heater\n", "")


# why


def test_reasons_as_text(hans: Path) -> None:
    result = call("why", hans, "leans_on(extinguisher2, wall)")
    assert (result.code, result.err) == (YES, "")
    first, *reasons = result.out.splitlines()
    assert first == "the fire extinguisher on the floor leans on the wall  [axiom 37]"
    assert all(line.startswith("  ") for line in reasons)
    assert "    0 cm is at most 2 cm (2 cm to spare)" in reasons


def test_reasons_as_json(hans: Path) -> None:
    result = call("why", hans, "leans_on(extinguisher2, wall)", "--format", "json")
    said = json.loads(result.out)
    assert (result.code, list(said)) == (YES, ["goal", "holds", "text", "proof", "nearest", "measured_as"])
    assert (said["holds"], said["nearest"]) == (True, None)
    proof = said["proof"]
    assert (proof["predicate"], proof["args"], proof["axiom"]) == ("leans_on", ["extinguisher2", "wall"], 37)
    assert proof["rule"]["file"] == "commonsense.pl"


def test_what_does_not_hold_is_told_by_how_much(hans: Path) -> None:
    result = call("why", hans, "left_of(extinguisher2, radiator, v1)")
    assert (result.code, result.err) == (NO, "")
    assert re.fullmatch(
        r"No: .* is not left of the radiator from where you stand \(short by .* cm\)\.\n", result.out
    )
    said = json.loads(call("why", hans, "left_of(extinguisher2, radiator, v1)", "--format", "json").out)
    assert (said["holds"], said["proof"]) == (False, None)
    assert said["nearest"]["margin"] < 0.0


# shell


def test_shell_is_prolog_with_the_scene_in_it(strange: Path, tmp_path: Path) -> None:
    private = tmp_path / "private"
    private.mkdir()
    told = run(
        "shell",
        strange,
        stdin="once(on_top_of(null, X)).\nwhy(on_top_of(null, X)).\n",
        env={"TMPDIR": str(private)},
    )
    assert (told.code, told.err) == (YES, "")
    assert told.out.startswith("Deixis: 4 objects, 0 surfaces, 1 views, ")
    assert "X = 'O\\'Hara\\'s \"table\", {0} ~w \\\\'" in told.out
    assert "[axiom 36]" in told.out
    assert list(private.iterdir()) == []


# import, schema, doctor, demo


def test_import_writes_a_scene(hans: Path, tmp_path: Path) -> None:
    target = tmp_path / "copy.json"
    result = call("import", "deixis", hans, "-o", target)
    assert result == Result(YES, "", f"{target}: 8 objects, 2 views\n")
    assert Scene.load(target).to_dict() == Scene.load(hans).to_dict()


def test_import_converts(tmp_path: Path) -> None:
    place = {"center": [1.0, 2.0, 3.0], "size": [0.1, 0.2, 0.3]}
    node = {"id": 7, "class_name": "plate", "category": "Props", "bounding_box": place}
    (tmp_path / "home.json").write_text(json.dumps({"nodes": [node], "edges": []}), encoding="utf-8")
    target = tmp_path / "scene.json"
    result = call("import", "virtualhome", tmp_path / "home.json", "-o", target)
    assert (result.code, result.out) == (YES, "")
    (thing,) = Scene.load(target).objects
    assert thing.label == "plate"
    assert result.err.endswith(f"{target}: 1 object, 0 views\n")


def test_import_of_something_else_writes_nothing(hans: Path, tmp_path: Path) -> None:
    target = tmp_path / "scene.json"
    refused(call("import", "ithro", hans, "-o", target), "unknown format 'ithro': did you mean 'ithor'?")
    refused(call("import", "ithor", hans, "-o", target), "'hans.json'")
    refused(call("import", "deixis", tmp_path / "none", "-o", target), "does not exist")
    refused(call("import", "deixis", hans, "-o", tmp_path / "none" / "scene.json"), "cannot be written")
    assert list(tmp_path.iterdir()) == []


def test_schema_is_the_schema() -> None:
    result = call("schema")
    assert (result.code, result.err) == (YES, "")
    assert json.loads(result.out) == scene_schema()


def test_doctor_finds_all_well() -> None:
    result = call("doctor")
    assert (result.code, result.err) == (YES, "")
    assert all(line.startswith("ok    ") for line in result.out.splitlines())
    assert "SWI-Prolog" in result.out


def test_demo_gives_relations_and_reasons() -> None:
    result = call("demo")
    assert (result.code, result.err) == (YES, "")
    assert re.search(r"^left_of +extinguisher2 +radiator +v0", result.out, re.MULTILINE)
    assert result.out.count("\nWhy ") == 3
    assert result.out.count(", because it ") == 3


# What is refused


BOX = '{"center": [0, 0, 0], "size": [1, 1, 1]}'
ESCAPE = "\\u001b[31m"

BAD = {
    "NaN": ('{"id": "cup", "box": {"center": [NaN, 0, 0], "size": [1, 1, 1]}}', "NaN"),
    "infinite": ('{"id": "cup", "box": {"center": [0, 0, 0], "size": [Infinity, 1, 1]}}', "Infinity"),
    "too large": ('{"id": "cup", "box": {"center": [1e999, 0, 0], "size": [1, 1, 1]}}', "1e999"),
    "far": ('{"id": "cup", "box": {"center": [1e9, 0, 0], "size": [1, 1, 1]}}', "object 'cup': box.center"),
    "quaternion": (
        '{"id": "cup", "box": {"center": [0, 0, 0], "size": [1, 1, 1], "quaternion": [0, 0, 0, 0]}}',
        "object 'cup': unknown key 'quaternion'",
    ),
    "negative size": (
        '{"id": "cup", "box": {"center": [0, 0, 0], "size": [1, -1, 1]}}',
        "object 'cup': box.size[1] is -1",
    ),
    "a number as text": (
        '{"id": "cup", "box": {"center": [0, 0, 0], "size": [1, "1", 1]}}',
        "object 'cup': box.size[1] is the string '1': give a number",
    ),
    "two values": (
        '{"id": "cup", "box": {"center": [0, 0], "size": [1, 1, 1]}}',
        "object 'cup': box.center has 2 entries: give exactly 3",
    ),
    "duplicate id": (", ".join([f'{{"id": "cup", "box": {BOX}}}'] * 2), "object 'cup' is given more than"),
    "empty cloud": ('{"id": "cup", "points": []}', "object 'cup': points has 0 entries"),
    "empty cloud file": ('{"id": "cup", "points": "empty.ply"}', "object 'cup': "),
    "missing cloud file": ('{"id": "cup", "points": "none.ply"}', "object 'cup': "),
    "file elsewhere": ('{"id": "cup", "points": "../../etc/passwd.ply"}', "object 'cup': "),
    "empty mesh": ('{"id": "cup", "mesh": {"vertices": [], "faces": []}}', "object 'cup': mesh.vertices"),
    "flat polygon": (
        '{"id": "wall", "kind": "surface", "polygon": [[0, 0, 0], [1, 0, 0], [2, 0, 0]]}',
        "object 'wall': ",
    ),
    "no region": ('{"id": "cup"}', "object 'cup' has no region"),
    "no labels": (f'{{"id": "cup", "labels": [], "box": {BOX}}}', "object 'cup': labels has 0 entries"),
    "misspelt key": (f'{{"id": "cup", "lable": "a", "box": {BOX}}}', "did you mean 'label'?"),
    "no id": (f'{{"box": {BOX}}}', "object number 1: id is missing"),
    "line end in an id": (f'{{"id": "a\\nb", "box": {BOX}}}', "U+000A"),
    "escape in an id": (f'{{"id": "{ESCAPE}", "box": {BOX}}}', "U+001B"),
    "escape in a label": (f'{{"id": "cup", "label": "{ESCAPE}", "box": {BOX}}}', "object 'cup': label"),
    "reversed text": (f'{{"id": "\\u202ecup", "box": {BOX}}}', "U+202E"),
    "half a character": (f'{{"id": "\\ud800", "box": {BOX}}}', "object"),
    "no JSON": ('{"id": "cup",,}', "not JSON at line 1"),
    "a key twice": (f'{{"id": "cup", "id": "mug", "box": {BOX}}}', "the key 'id' is given twice"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_object_is_one_clear_error(name: str, tmp_path: Path) -> None:
    objects, words = BAD[name]
    header = ["ply", "format ascii 1.0", "element vertex 0", *(f"property float {axis}" for axis in "xyz")]
    (tmp_path / "empty.ply").write_text("\n".join([*header, "end_header", ""]), encoding="ascii")
    path = tmp_path / "scene.json"
    path.write_text(f'{{"deixis": 1, "id": "test", "objects": [{objects}]}}', encoding="utf-8")
    message = refused(call("relations", path), words, "'scene.json'")
    assert message.count("\n") == 1
    assert message[:-1].isprintable()


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ({"views": [{"id": "world", "position": [0, 0, 0]}]}, "view 'world'"),
        ({"views": [{"id": "v", "position": [0, 0, 0]}] * 2}, "view 'v' is given more than once"),
        ({"views": [{"id": "v", "position": [0, 0]}]}, "view 'v': position has 2 entries: give exactly 3"),
        ({"thresholds": {"granularity": -1.0}}, "granularity"),
        ({"thresholds": {"granularity": 0.5}}, "penetration"),
        ({"thresholds": {"granulrity": 0.1}}, "did you mean 'granularity'?"),
        ({"deixis": 2}, "reads version 1"),
        ({"frame": "y-up"}, "unknown key 'frame'"),
    ],
    ids=str,
)
def test_a_bad_scene_is_one_clear_error(rest: dict[str, Any], words: str, write: Write) -> None:
    assert refused(call("relations", write(**rest)), words).count("\n") == 1


@pytest.mark.parametrize(
    "command",
    [["relations"], ["facts"], ["ask", "true"], ["why", "near(cup, cup)"], ["shell"]],
    ids=lambda words: words[0],
)
def test_every_command_refuses_a_bad_scene(command: list[str], tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(
        f'{{"deixis": 1, "id": "test", "objects": [{BAD["negative size"][0]}]}}', encoding="utf-8"
    )
    refused(call(command[0], path, *command[1:]), "object 'cup': box.size[1]")


@pytest.mark.parametrize(
    "content",
    [b"", b"\x00\xff\xfe", b"[]", b"null", b"[" * 100_000, b'{"a": 1'],
    ids=lambda text: repr(text[:9]),
)
def test_a_file_that_is_no_scene_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_bytes(content)
    assert refused(call("relations", path)).count("\n") == 1


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    refused(call("relations", tmp_path / "none.json"), "none.json' does not exist")
    refused(call("relations", tmp_path), "is not a file")
    message = refused(call("relations", tmp_path / "\x1b[31m.json"))
    assert "\x1b" not in message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["relations", "--view", "v9"], "no view 'v9' in scene 'hans': known are v0, v1"),
        (["relations", "--relation", "on_top"], "no relation 'on_top': did you mean 'on_top_of'?"),
        (["relations", "--relation", "on_top_of(X)"], "no relation 'on_top_of(X)'"),
        (["ask", "on_top(X, Y)"], "on_top/2: did you mean on_top_of/2?"),
        (["ask", "left_of(X, Y)"], "left_of/2: did you mean left_of/3"),
        (["ask", "on_top_of(X,"], "syntax error"),
        (["ask", " "], "the question is empty"),
        (["ask", "near(X, Y). halt"], "more than one question"),
        (["ask", "halt"], "halt/0 is not allowed"),
        (["ask", "shell(ls)"], "not allowed"),
        (["ask", "assertz(facts:surface(cup))"], "not allowed"),
        (["ask", "open('/etc/passwd', read, S)"], "not allowed"),
        (["ask", "\x1b[31m"], "syntax error"),
        (["ask", "x" * 70_000], "longer than"),
        (["why", "on_top_of(swetter, heater)"], "'swetter' in scene 'hans': did you mean 'sweater'?"),
        (["why", "on_top(sweater, heater)"], "on_top/2: did you mean on_top_of/2?"),
        (["why", "near(sign, X), near(X, Y)"], "ask for the reasons of one relation"),
        (["why", "'). halt. %"], "syntax error"),
        (["why", ""], "the question is empty"),
    ],
    ids=lambda value: " ".join(value)[:40] if isinstance(value, list) else "",
)
def test_what_is_unknown_or_not_allowed_is_an_error(arguments: list[str], words: str, hans: Path) -> None:
    command, *rest = arguments
    assert "\x1b" not in refused(call(command, hans, *rest), words)


def test_exit_codes_are_those_of_the_errors() -> None:
    def leaves(kind: type[DeixisError]) -> set[type[DeixisError]]:
        return {kind}.union(*(leaves(one) for one in kind.__subclasses__()))

    codes = {kind.__name__: kind.exit_code for kind in leaves(DeixisError)}
    assert codes.pop("QueryTimeout") == TIME_OUT
    assert set(codes.values()) == {ERROR}


@pytest.mark.parametrize(
    "arguments",
    [
        ["ask", "between(1, inf, X), X < 0", "--timeout", "0.2"],
        ["why", "near(X, Y)", "--timeout", "0.001"],
        ["relations", "--timeout", "0.001"],
        ["relations", "--engine", "prolog", "--timeout", "0.001"],
    ],
    ids=" ".join,
)
def test_what_takes_too_long_is_stopped(arguments: list[str], root: Path) -> None:
    command, *rest = arguments
    result = call(command, root / "kb" / "scenes" / "kitchen.json", *rest)
    assert (result.code, result.out) == (TIME_OUT, "")
    assert result.err.startswith("deixis: no answer within 0.")


# What ids and labels may do to a terminal, a spreadsheet, a shell: nothing


def test_a_spreadsheet_runs_no_id(write: Write) -> None:
    formulas = ["=1+1", "+1", "-1", "@SUM(A1)"]
    path = write(floor(), *(box(name, (k, 0, 0.1), (0.2, 0.2, 0.2)) for k, name in enumerate(formulas)))
    options = ("--relation", "on_top_of")
    rows = list(csv.reader(io.StringIO(call("relations", path, *options, "--format", "csv").out)))
    assert sorted(row[1] for row in rows[1:]) == sorted(f"'{name}" for name in formulas)
    said = json.loads(call("relations", path, *options, "--format", "json").out)
    assert sorted(one["figure"] for one in said["relations"]) == sorted(formulas)
    facts = list(csv.DictReader(io.StringIO(call("facts", path, "--format", "csv").out)))
    assert not {one["figure"][:1] for one in facts} & set("=+-@")


def test_a_terminal_obeys_no_id(write: Write) -> None:
    # Characters that are let in at the door but not shown as they are: no-break and zero-width spaces.
    path = write(floor(), box("a\u200bb", (0, 0, 0.1), (0.2, 0.2, 0.2), label="mug\u00a0\u00e9"))
    for arguments in (["relations"], ["ask", "on_top_of(X, floor)"], ["why", "on_top_of(X, floor)"]):
        shown = call(arguments[0], path, *arguments[1:]).out
        assert shown.replace("\n", "").isprintable()
    assert "a\\u200bb" in call("relations", path).out
    assert "the mug\\xa0\u00e9 is on top of the floor" in call("why", path, "on_top_of(X, floor)").out


def test_output_is_utf_8_whatever_the_locale(write: Write) -> None:
    path = write(floor(), box("T\u00fcr \U0001f6aa", (0, 0, 1), (0.9, 0.1, 2), label="T\u00fcr"))
    result = run("ask", path, "on_top_of(X, floor)", env={"PYTHONIOENCODING": "ascii", "LC_ALL": "C"})
    assert result == Result(YES, "X = 'T\u00fcr \\U0001f6aa'\n", "")


def test_odd_scenes_are_answered_with_a_warning(write: Write) -> None:
    path = write(floor(), box("cup", (0, 0, 0.1), (0.2, 0.2, 0.2), yaw=90.0))
    result = call("relations", path, "--relation", "on_top_of", "--format", "pl")
    assert (result.code, result.out) == (YES, "on_top_of('cup','floor').\n")
    assert result.err == "deixis: object 'cup': yaw 90 is more than a full turn: is the unit degrees?\n"


# Pipes, full disks, missing programs


def test_a_reader_that_goes_away_is_no_error(root: Path) -> None:
    """As `deixis facts ... | head -1`."""
    command = [sys.executable, "-m", "deixis", "facts", root / "kb" / "scenes" / "kitchen.json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stderr is not None
        assert child.stdout.readline().startswith("figure")
        child.stdout.close()
        assert (child.stderr.read(), child.wait(60)) == ("", YES)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_a_full_disk_is_an_error(hans: Path) -> None:
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "deixis", "facts", hans]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == ERROR
    assert done.stderr == "deixis: cannot go on: [Errno 28] No space left on device\n"


def test_without_prolog_the_remedy_is_named(hans: Path, tmp_path: Path) -> None:
    nowhere = {"PATH": str(tmp_path), "SWI_HOME_DIR": "", "LIBSWIPL_PATH": ""}
    for command in (["ask", hans, "true"], ["relations", hans, "--engine", "prolog"], ["shell", hans]):
        message = refused(
            run(*command, env=nowhere),
            "swipl on the PATH: not there",
            "sudo apt-get install swi-prolog-nox",
            "conda install -c conda-forge swi-prolog",
            "brew install swi-prolog",
        )
    assert os.environ.get("HOME", "~") not in message
    # What needs no Prolog works without it.
    assert run("facts", hans, env=nowhere).code == YES
    assert run("relations", hans, env=nowhere).code == YES
    ill = run("doctor", env=nowhere)
    assert ill.code == ERROR
    assert "\nFAIL  SWI-Prolog" in ill.out


def test_nothing_is_left_behind(strange: Path, tmp_path: Path) -> None:
    private = tmp_path / "private"
    private.mkdir()
    result = run("relations", strange, "--format", "json", env={"TMPDIR": str(private)})
    assert (result.code, result.err) == (YES, "")
    assert len(json.loads(result.out)["relations"]) > 3
    assert list(private.iterdir()) == []


def test_a_cold_start_loads_nothing_heavy(hans: Path) -> None:
    """Boxes and polygons need no meshes, colours or Prolog in this process: what stays out costs no time."""
    heavy = ["pyswip", "rich", "scipy", "trimesh"]
    script = (
        "import sys; from deixis.cli import main; code = main(); "
        f"sys.exit(code or [name for name in {heavy} if name in sys.modules] or 0)"
    )
    command = [sys.executable, "-c", script, "relations", hans, "--format", "csv"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (YES, "")


def test_a_variable_that_is_a_name_but_for_its_capital_is_told(hans: Path) -> None:
    said = "deixis: {} is a variable, which stands for anything: did you mean {!r}?\n"
    on, near = "on_top_of(Sweater, heater)", "near(X, Wall)"
    told = call("why", hans, on)
    assert (told.code, told.err) == (YES, said.format("Sweater", "sweater"))
    assert call("why-not", hans, on + ".").err == said.format("Sweater", "sweater")
    assert call("why", hans, "left_of(X, Radiator, V0)").err == said.format(
        "Radiator", "radiator"
    ) + said.format("V0", "v0")
    both = said.format("Sweater", "sweater") + said.format("Wall", "wall")
    assert call("contrast", hans, on, "--rather-than", near).err == both
    change = call("change", hans, on)
    assert change.code == ERROR
    assert change.err.startswith(said.format("Sweater", "sweater"))
    for goal in (
        "on_top_of(Thing, heater)",
        "on_top_of(sweater, 'Heater')",
        "on_top_of(_, heater)",
        "near(X,",
    ):
        assert "is a variable" not in call("why", hans, goal).err


# What would be if things stood elsewhere


def test_the_smallest_change(hans: Path) -> None:
    found = call("change", hans, "inside(sweater, heater)", "--format", "json")
    assert found.code == YES
    change = json.loads(found.out)["change"]
    assert (change["move"], change["holds"]) == ("sweater", True)
    assert change["offset"] == pytest.approx([0, 0, -0.04], abs=2e-4)
    assert change["collides"] == ["heater"]
    said = call("change", hans, "inside(sweater, heater)").out
    assert said.endswith("There it would share space with heater.\n")
    assert "no longer holds" in call("change", hans, "touches(extinguisher1, wall)").out
    far = call("change", hans, "above(extinguisher1, sweater)")
    assert (far.code, far.out) == (NO, "No move within three metres was found that changes it.\n")
    refused(call("change", hans, "above(extinguisher1, swaeter)"), "did you mean 'sweater'")


def test_what_if_things_stood_elsewhere(hans: Path) -> None:
    result = call("what-if", hans, "--move", "sweater=0,0,0.1", "--move", "sign=0,-0.5,0", "--format", "json")
    assert result.code == YES
    said = json.loads(result.out)
    assert said["moves"] == {"sweater": [0.0, 0.0, 0.1], "sign": [0.0, -0.5, 0.0]}
    lost = {(one["relation"], one["figure"], one["reference"]): one["because"] for one in said["lost"]}
    assert "short by 8 cm" in lost["on_top_of", "sweater", "heater"]
    assert ("affixed_on", "sign", "wall") in lost
    assert all(one["margin"] is not None for one in said["gained"])
    same = call("what-if", hans, "--move", "sweater=0,0,0.0001")
    assert (same.code, same.out) == (NO, "")
    refused(call("what-if", hans, "--move", "sweater"), "is no move")
    refused(call("what-if", hans, "--move", "sweater=1,2"), "is no move")
    refused(call("what-if", hans, "--move", "cap=0,0,1"), "no object 'cap'")
    refused(call("what-if", hans, "--move", "sweater=nan,0,0"), "is not x, y, z")


def test_why_not(hans: Path) -> None:
    result = call("why-not", hans, "affixed_on(extinguisher2, wall)")
    told = "not affixed on the wall, because the floor touches it.\n"
    assert (result.code, result.out.endswith(told)) == (YES, True)
    said = json.loads(call("why-not", hans, "beside(extinguisher2, radiator, v1)", "--format", "json").out)
    assert (said["holds"], len(said["misses"])) == (False, 2), "one for each of its two rules"
    margins = [one["derivation"]["margin"] for one in said["misses"]]
    assert margins == sorted(margins, reverse=True)
    assert call("why-not", hans, "on_top_of(sweater, heater)").code == NO
    swapped = call("why-not", hans, "near(heater, sweater)").out
    assert "is the reference of the two" in swapped
    refused(call("why-not", hans, "near(heater, swaeter)"), "did you mean 'sweater'")


def test_contrast(hans: Path) -> None:
    question = ("contrast", hans, "leans_on(extinguisher2, wall)", "--rather-than")
    result = call(*question, "affixed_on(extinguisher2, wall)")
    assert (result.code, result.out.count(".")) == (YES, 1)
    assert "leans on the wall" in result.out
    assert "because the floor touches" in result.out
    both = call(*question, "near(extinguisher2, wall)")
    assert (both.code, both.out[:10]) == (NO, "Both hold:")
    neither = call("contrast", hans, "on_top_of(sign, heater)", "--rather-than", "near(sign, heater)")
    assert neither.code == NO


def test_what_is_written_goes_through_links_and_pipes_and_keeps_its_mode(tmp_path: Path) -> None:
    from deixis._files import write_whole

    kept, link, pipe = tmp_path / "kept", tmp_path / "link", tmp_path / "pipe"
    kept.write_bytes(b"old")
    kept.chmod(0o600)
    link.symlink_to(kept)
    write_whole(link, b"new")
    assert (link.is_symlink(), kept.read_bytes(), kept.stat().st_mode & 0o777) == (True, b"new", 0o600)
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert pipe.is_fifo()
    for place in (tmp_path, Path(), Path("/")):
        with pytest.raises(IsADirectoryError):
            write_whole(place, b"")


def test_a_write_that_is_interrupted_leaves_nothing_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from deixis._files import write_whole

    def interrupt(_: int) -> None:
        raise KeyboardInterrupt

    (tmp_path / "kept").write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "kept", b"new")
    assert [(one.name, one.read_bytes()) for one in tmp_path.iterdir()] == [("kept", b"old")]
