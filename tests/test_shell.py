"""The shell: the real swipl, at a terminal and in a pipe, with what Deixis adds to it."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from commands import Result, call, run

SECONDS = 30.0


@pytest.fixture(scope="module")
def hans(root: Path) -> Path:
    return root / "kb" / "scenes" / "hans.json"


def ask(scene: Path, *goals: str, rules: tuple[str | Path, ...] = ()) -> Result:
    """Ask goals at the prompt, each for its first answer."""
    options = [word for one in rules for word in ("--rules", one)]
    return run("shell", scene, *options, stdin="".join(f"once(({goal})).\n" for goal in goals))


def test_the_banner_counts(hans: Path) -> None:
    told = ask(hans)
    assert (told.code, told.err) == (0, "")
    first = "Deixis: 6 objects, 2 surfaces, 2 views, 45 relations, 37 measured pairs.\n"
    assert told.out.startswith(first)
    assert len(json.loads(call("relations", hans, "--format", "json").out)["relations"]) == 45


def test_help_shows_axiom_text_and_rule(hans: Path, root: Path) -> None:
    told = ask(hans, "help(on_top_of)", "help(pair/9)", "help(violation)", rules=("safety",))
    assert (told.code, told.err) == (0, "")
    rules = (root / "rules" / "commonsense.pl").read_text(encoding="utf-8")
    (rule,) = re.findall(r"^on_top_of\(.*?\)\.$", rules, re.MULTILINE | re.DOTALL)
    assert "on_top_of/2  (axiom 36, commonsense.pl)" in told.out
    assert "Axiom 36. Figure is on top of Reference iff it is above it and touches it." in told.out
    assert rule in told.out
    assert "Separation: the distance, or minus the least translation" in told.out
    assert "violation/3  (safety.pl)" in told.out


def test_help_of_prolog_itself_is_the_manual(hans: Path) -> None:
    told = ask(hans, "help(append)", "X = done")
    assert told.code == 0
    assert "X = done" in told.out


def test_objects_and_axioms_are_listed(hans: Path) -> None:
    told = ask(hans, "objects", "axioms")
    assert re.search(r"^extinguisher2 +fire extinguisher *$", told.out, re.MULTILINE)
    assert re.search(r"^wall +wall +surface$", told.out, re.MULTILINE)
    assert re.search(r"^ 36  on_top_of/2 +Figure is on top of Reference iff", told.out, re.MULTILINE)
    assert told.err == ""


def test_the_view_that_is_looked_from(hans: Path) -> None:
    goal = "left_of(extinguisher2, radiator)"
    told = ask(
        hans, "view(V)", f"{goal}, X = one", "view(v1)", f"\\+ {goal}, X = two", f"why({goal})", "view(v9)"
    )
    assert "V = v0." in told.out
    assert "X = one" in told.out
    assert "X = two" in told.out
    assert "from where you stand (short by" in told.out
    assert told.err == "no view is called v9: known are [v0,v1]\n"


def test_why_and_why_not(hans: Path) -> None:
    told = ask(
        hans,
        "why(on_top_of(sweater, heater))",
        "why_not(on_top_of(sign, heater))",
        "why_not(on_top_of(sweater, heater))",
        "why(violation(fire_hazard, sweater, heater))",
        rules=("safety",),
    )
    assert (told.code, told.err) == (0, "")
    assert "the sweater is on top of the electric heater  [axiom 36]" in told.out
    assert "is not on top of the electric heater" in told.out
    assert "It does hold: the sweater is on top of" in told.out
    assert "cloth burns" in told.out


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ("on_topof(X, Y)", "no rule or fact is called on_topof/2: did you mean on_top_of/2?"),
        ("left_off(X, Y)", "no rule or fact is called left_off/2: did you mean left_of/3?"),
        ("on_top_of(X)", "no rule or fact is called on_top_of/1: did you mean on_top_of/2?"),
        ("on_top_of(swetter, Y)", "nothing is called swetter: did you mean sweater?"),
        ("near(hetaer, Y)", "nothing is called hetaer: did you mean heater?"),
        ("why(near(hetaer, Y))", "nothing is called hetaer: did you mean heater?"),
        ("near(X, Y), \\+ touches(X, flor)", "nothing is called flor: did you mean floor?"),
    ],
)
def test_unknown_names(hans: Path, goal: str, words: str) -> None:
    told = ask(hans, goal)
    assert words in told.err.splitlines()


def test_several_scenes_are_kept_apart(hans: Path, root: Path) -> None:
    other = root / "kb" / "scenes" / "inspection.json"
    goals = [
        "supported_by(hans_sweater, hans_heater), X = held",
        "aggregate_all(count, threshold(_, _), N)",
        "near(floor, X)",
    ]
    asked = "".join(f"once(({one})).\n" for one in goals)
    told = run("shell", hans, other, "--rules", "support", stdin=asked)
    assert told.code == 0
    assert told.out.startswith("Deixis: 16 objects, 5 surfaces, 4 views, ")
    assert "X = held." in told.out
    assert "N = 6." in told.out
    assert "did you mean hans_floor?" in told.err


def test_scenes_that_cannot_be_told_apart(hans: Path, tmp_path: Path) -> None:
    told = run("shell", hans, hans)
    assert (told.code, told.out) == (2, "")
    assert told.err == "deixis: two scenes are called 'hans': give one of them another id\n"
    box = {"center": [0, 0, 0], "size": [1, 1, 1]}

    def write(name: str, thing: str, **rest: object) -> Path:
        path = tmp_path / f"{name}.json"
        scene = {"deixis": 1, "id": name, "objects": [{"id": thing, "box": box}], **rest}
        path.write_text(json.dumps(scene), encoding="utf-8")
        return path

    told = run("shell", write("a", "b_c"), write("a_b", "c"))
    assert told.err == (
        "deixis: two things of these scenes would be called 'a_b_c': rename one of them, or its scene\n"
    )
    told = run("shell", write("a", "c"), write("d", "c", thresholds={"closeness": 2.0}))
    assert "are read with different thresholds" in told.err


def test_no_init_file_is_loaded(hans: Path, tmp_path: Path) -> None:
    """Case 94: what lies in the working directory or the home is not run."""
    for name in ("init.pl", ".swiplrc", "swipl.rc"):
        (tmp_path / name).write_text(":- writeln(sprung), halt(9).\n", encoding="utf-8")
    (tmp_path / ".config" / "swi-prolog").mkdir(parents=True)
    (tmp_path / ".config" / "swi-prolog" / "init.pl").write_text(":- halt(9).\n", encoding="utf-8")
    told = run("shell", hans, stdin="X = fine.\n", cwd=tmp_path, env={"HOME": str(tmp_path)})
    assert (told.code, "sprung" in told.out) == (0, False)
    assert "X = fine" in told.out


def test_hostile_ids_are_only_names(tmp_path: Path) -> None:
    """Cases 37 to 44 at the prompt: what a scene calls things is never run."""
    names = [
        "'). halt. %", 'x"))),shell("touch SPRUNG"),assertz((obj("y', "a> <b> <c> .", "'; DROP TABLE t;--",
        "%p ~w {0} \\", "_", "X", "[]", "-1", "true", "end_of_file", "None", "mod", "is", "dynamic",
        "ca\u0301", "\u0430", ":- halt.", "a1", "[a1]", "cup12", "o\u0661",
    ]  # fmt: skip
    box = {"center": [0, 0, 0], "size": [1, 1, 1]}
    path = tmp_path / "scene.json"
    scene = {"deixis": 1, "id": "s", "objects": [{"id": name, "label": name, "box": box} for name in names]}
    path.write_text(json.dumps(scene), encoding="utf-8")
    spell = 'write(row), forall(member(D, C), format(" ~d", [D])), nl'
    goal = f"forall((spatial_obj(X), atom_codes(X, C)), ({spell}))"
    told = run("shell", path, stdin=f"{goal}.\nobjects.\n", cwd=tmp_path)
    assert told.code == 0
    rows = [line.split()[1:] for line in told.out.splitlines() if line.startswith("row ")]
    assert ["".join(chr(int(code)) for code in row) for row in rows] == names
    assert not (tmp_path / "SPRUNG").exists()


# At a terminal


def terminal(scene: Path, talk: Callable[[Callable[[str], str], Callable[[str], None]], None]) -> int:
    """Run the shell at a pseudo-terminal and return its exit code."""
    pid, master = pty.fork()
    if pid == 0:
        os.environ["TERM"] = "dumb"
        os.execv(sys.executable, [sys.executable, "-m", "deixis", "shell", str(scene)])  # noqa: S606
    end = time.monotonic() + SECONDS

    def until(words: str) -> str:
        seen = ""
        while words not in seen:
            if not select.select([master], [], [], max(0.0, end - time.monotonic()))[0]:
                os.kill(pid, signal.SIGKILL)
                pytest.fail(f"no {words!r} in {seen!r}")
            seen += os.read(master, 4096).decode("utf-8", "replace")
        return seen

    try:
        talk(until, lambda text: (os.write(master, text.encode()), None)[1])
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    finally:
        os.close(master)


def test_at_a_terminal_it_is_swipl(hans: Path) -> None:
    def talk(until: Callable[[str], str], type_in: Callable[[str], None]) -> None:
        assert "Deixis: 6 objects" in until("?- ")
        type_in("on_top_of(sweater, What).\r")
        until("What = heater")
        type_in(";")
        until("false.")
        type_in("X = $What, Y = 1.\r")
        until("Y = 1")
        type_in("halt.\r")

    assert terminal(hans, talk) == 0
