"""Those who follow a scene that changes: what they are told and why, how fast, and for how long."""

from __future__ import annotations

import io
import json
import math
import os
import pickle
import random
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.job import room
from commands import run
from deixis.cli.live import _lines
from deixis.errors import QueryError, SceneError
from deixis.knowledge import KnowledgeBase
from deixis.living import kept, living
from deixis.living.kept import Kept
from deixis.prolog import PrologEngine
from deixis.scene import Scene
from deixis.updates import Changes, Update
from memory import MOST
from scenes import box, floor, scene

HANS = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "hans.json"
LIFTED = {"moves": {"sweater": [0, 0, 0.1]}}


def lifted(kb: KnowledgeBase, height: float) -> Update:
    """Return the update that lifts the sweater off the heater, or lets it down."""
    return Update.from_dict({"moves": {"sweater": [0, 0, height]}}, kb.scene)


def test_whoever_fails_the_others_are_told() -> None:
    told: list[str] = []

    def fails(name: str) -> Any:
        def subscriber(_: Changes) -> None:
            told.append(name)
            raise ValueError(name)

        return subscriber

    with KnowledgeBase.from_scene(HANS) as kb:
        kb.subscribe(fails("one"))
        kb.subscribe(lambda _: told.append("two"))
        stop = kb.subscribe(fails("three"))
        with pytest.raises(ExceptionGroup, match="2 subscribers failed") as caught:
            kb.update(Update.from_dict(LIFTED, kb.scene))
        assert told == ["one", "two", "three"]
        assert [str(error) for error in caught.value.exceptions] == ["one", "three"]
        stop()
        with pytest.raises(ValueError, match="one"):
            kb.update(Update())
        assert told[3:] == ["one", "two"]
        assert kb.scene.objects[kb.scene.index("sweater")].region.center[2] > 0.6


def test_what_a_subscriber_changes_is_told_after_what_it_is_told_of() -> None:
    """To all in the same order; and whoever follows ends with what holds."""
    first: list[Changes] = []
    second: list[Changes] = []
    with KnowledgeBase.from_scene(HANS) as kb:

        def lift_again(changes: Changes) -> None:
            first.append(changes)
            if len(first) == 1:
                assert kb.update(lifted(kb, -0.1)).gained
                assert second == []

        kb.subscribe(lift_again)
        kb.subscribe(second.append)
        assert kb.update(lifted(kb, 0.1)).lost
    assert first == second
    assert [bool(one.gained) for one in second] == [False, True]


def test_two_threads_are_told_of_in_the_order_of_their_updates() -> None:
    """One subscriber takes its time over the first, and meanwhile there is a second update."""
    with KnowledgeBase.from_scene(HANS) as kb:
        mirror = {one.to_prolog() for one in kb.kept}
        entered, going_on = threading.Event(), threading.Event()

        def slow(_: Changes) -> None:
            entered.set()
            assert going_on.wait(20.0)

        def follow(changes: Changes) -> None:
            mirror.difference_update(one.to_prolog() for one in changes.lost)
            mirror.update(one.to_prolog() for one in changes.gained)

        kb.subscribe(slow)
        kb.subscribe(follow)
        one = threading.Thread(target=kb.update, args=(lifted(kb, 0.1),))
        one.start()
        assert entered.wait(20.0)
        kb.update(lifted(kb, -0.1))
        going_on.set()
        one.join(20.0)
        assert mirror == {one.to_prolog() for one in kb.kept}


def test_a_subscription_that_is_ended_twice_ends_no_other() -> None:
    told: list[Changes] = []
    with KnowledgeBase.from_scene(HANS) as kb:
        ends = [kb.subscribe(told.append) for _ in range(2)]
        ends[0]()
        ends[0]()
        kb.update(lifted(kb, 0.1))
    assert len(told) == 1


def test_what_interrupts_a_subscriber_leaves_the_others_to_be_told_of_the_next() -> None:
    told: list[Changes] = []
    with KnowledgeBase.from_scene(HANS) as kb:

        def interrupted(_: Changes) -> None:
            raise KeyboardInterrupt

        end = kb.subscribe(interrupted)
        with pytest.raises(KeyboardInterrupt):
            kb.update(lifted(kb, 0.1))
        end()
        kb.subscribe(told.append)
        kb.update(lifted(kb, -0.1))
    assert len(told) == 1


def test_a_subscriber_may_end_it_while_it_is_told() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        told: list[int] = []
        stop = kb.subscribe(lambda _: (told.append(1), stop()))
        kb.subscribe(lambda _: told.append(2))
        kb.update(Update.from_dict(LIFTED, kb.scene))
        kb.update(Update.from_dict(LIFTED, kb.scene))
        assert told == [1, 2, 2]


def test_reasons_are_those_of_the_scene_just_after_the_update() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        lifted = kb.update(Update.from_dict(LIFTED, kb.scene))
        (lost,) = lifted.lost
        short = "The sweater is not on top of the electric heater (short by 8 cm)."
        assert lifted.because(lost) == short
        back = kb.update(Update.from_dict({"moves": {"sweater": [0, 0, -0.1]}}, kb.scene))
        gone = kb.update(Update.from_dict({"removed": ["heater"]}, kb.scene))
        # The scene is another by now, twice.
        assert lifted.because(lost) == short
        assert (
            back.explained().gained[0].because.startswith("The sweater is on top of the electric heater, be")
        )
        cut = gone.explained(limit=1)
        assert (cut.lost[0].because, len(cut.gained) + len(cut.lost), cut.truncated) == (
            "heater gone",
            1,
            True,
        )
        with pytest.raises(QueryError, match=r"on_top_of\('sweater','heater'\) is not among these changes"):
            Update().applied(kb.scene) and kb.update(Update()).because(lost)


def test_reasons_of_ones_own_rules(tmp_path: Path) -> None:
    rules = tmp_path / "own.pl"
    rules.write_text("%!  marked(?A, ?B) is nondet.\nmarked(A, here) :- on_top_of(A, 'heater').\n", "utf-8")
    with KnowledgeBase.from_scene(HANS, rules=[rules]) as kb:
        changes = kb.update(Update.from_dict(LIFTED, kb.scene))
        told = {one.relation.relation: one.because for one in changes.explained().lost}
        assert told.keys() == {"on_top_of", "marked"}
        assert "8 cm" in told["marked"]


def test_what_shares_its_id_with_a_view_that_is_gone_is_not_gone() -> None:
    things = floor(), box("cup", (0, 0, 0.1), (0.2, 0.2, 0.2))
    views = [{"id": "cup", "position": [0, -2, 1]}]
    with KnowledgeBase(scene(*things, views=views)) as kb:
        told = {"moves": {"cup": [0, 0, 0.1]}, "removed_views": ["cup"]}
        lost = kb.update(Update.from_dict(told, kb.scene)).explained().lost
        assert [one.because for one in lost] == ["The cup is not on top of the floor (short by 8 cm)."]


def test_what_was_seen_in_a_view_that_is_gone_forgets_it() -> None:
    """Else it would name a view that is not there, which no scene file may."""
    things = [
        {**box(f"o{at}", (at, 0, 0.1), (0.2, 0.2, 0.2)), "seen_in": ["v0", "v1"][at:]} for at in range(2)
    ]
    views = [{"id": f"v{at}", "position": [0, -2, 1]} for at in range(2)]
    kb = KnowledgeBase(scene(floor(), *things, views=views))
    new = {**box("o2", (2, 0, 0.1), (0.2, 0.2, 0.2)), "seen_in": ["v1"]}
    kb.update(Update.from_dict({"objects": [new], "removed_views": ["v1"]}, kb.scene))
    again = Scene.from_dict(json.loads(kb.scene.to_json()))
    assert {one.id: one.seen_in for one in again.objects[1:]} == {"o0": ("v0",), "o1": (), "o2": ()}
    assert kb.kept == KnowledgeBase(again).relations()


def test_what_is_kept_is_told_between_updates(monkeypatch: pytest.MonkeyPatch) -> None:
    kb = KnowledgeBase.from_scene(HANS)
    before, told = kb.kept, []
    asking = threading.Thread(target=lambda: told.append(kb.kept))
    original = living.Living._taken_over

    def taken_over(self: Any, *args: Any) -> Any:
        asking.start()
        asking.join(0.2)
        return original(self, *args)

    monkeypatch.setattr(living.Living, "_taken_over", taken_over)
    kb.update(Update.from_dict(LIFTED, kb.scene))
    asking.join()
    assert told == [kb.kept]
    assert told != [before]


def test_prolog_is_told_of_what_changes_while_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        original = PrologEngine.load

        def load(self: PrologEngine, facts: Any) -> int:
            monkeypatch.undo()
            kb.update(Update.from_dict(LIFTED, kb.scene))
            return original(self, facts)

        monkeypatch.setattr(PrologEngine, "load", load)
        # Whether this is answered before or after the update is open.
        kb.why("on_top_of(sweater, heater)")
        assert not kb.why("on_top_of(sweater, heater)")


def test_changes_go_to_other_processes_without_their_reasons() -> None:
    with KnowledgeBase.from_scene(HANS) as kb:
        changes = kb.update(Update.from_dict(LIFTED, kb.scene))
        sent = pickle.loads(pickle.dumps(changes))  # noqa: S301 - our own
        assert sent == changes
        with pytest.raises(QueryError, match="are a copy"):
            sent.explained()


@pytest.mark.parametrize("stamp", [math.nan, math.inf, -math.inf, "now", True, 10**400, [1], np.bool_(True)])
def test_a_stamp_is_a_finite_number(stamp: Any) -> None:
    with pytest.raises(SceneError, match="not a finite number"):
        Update(stamp=stamp)


def test_stamps_of_other_kinds_of_numbers_are_floats() -> None:
    told = [Update(stamp=stamp).stamp for stamp in (np.float32(1.5), np.int64(3), 2)]
    assert told == [1.5, 3.0, 2.0]
    assert all(type(one) is float for one in told)


def test_what_is_kept_is_compared_by_any_number_of_names(monkeypatch: pytest.MonkeyPatch) -> None:
    one = Kept(np.array([0, 0, 1]), np.array([[0, 1, 2], [3, 4, 5]]), np.zeros(3))
    other = Kept(np.array([0, 1, 1]), np.array([[1, 2, 2], [4, 5, 6]]), np.ones(3))
    for widest in (kept._WIDEST, 1):
        monkeypatch.setattr(kept, "_WIDEST", widest)
        mine, theirs = one.without(other, 7)
        assert (mine.args.T.tolist(), theirs.args.T.tolist()) == ([[0, 3]], [[2, 6]])


def test_names_of_what_is_gone_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(living, "_SPARE", 8)
    kb = KnowledgeBase(scene(floor(), *(box(f"o{at}", (at, 0, 0.1), (0.2, 0.2, 0.2)) for at in range(4))))
    for at in range(4, 40):
        thing = box(f"o{at}", (at % 4, 0, 0.1), (0.2, 0.2, 0.2))
        changes = kb.update(Update.from_dict({"objects": [thing], "removed": [f"o{at - 4}"]}, kb.scene))
        assert {one.figure for one in changes.gained if one.relation == "on_top_of"} == {f"o{at}"}
        assert {one.figure for one in changes.lost if one.relation == "on_top_of"} == {f"o{at - 4}"}
    assert len(kb._living._names) <= 2 * 5 + 8 + 8


# The command line


def test_lines_are_read_no_further_than_the_limit() -> None:
    text = b"12345\n\n" + b"x" * 200_000 + b"\n1234567890\n12345678901\n" + b"y" * 70_000
    assert list(_lines(io.BytesIO(text), 10)) == [
        (b"12345\n", True), (b"x" * 11, False), (b"1234567890\n", True), (b"12345678901", False),
        (b"y" * 11, False),
    ]  # fmt: skip


def test_a_line_without_end_is_refused_in_bounded_memory(tmp_path: Path) -> None:
    """Three hundred megabytes, of which no more than the limit is in memory."""
    script = tmp_path / "measured.py"
    script.write_text(
        f"{MOST}\nimport sys\nfrom deixis.cli import main\n"
        f"sys.argv = ['deixis', 'live', {str(HANS)!r}, '--brief']\ncode = main()\n"
        "print(most() >> 20)\nsys.exit(code)\n",
        "utf-8",
    )
    with subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for _ in range(300):
            process.stdin.write(b"[" * 1_000_000)
        process.stdin.write(b'\n{"moves": {"sweater": [0, 0, 0.1]}}\n')
        process.stdin.close()
        refused, changed, most = process.stdout.read().decode().splitlines()
    assert process.returncode == 2
    assert "the line is longer than 67,108,864 bytes" in refused
    assert "on_top_of" in changed
    assert int(most) < 300


def test_live_says_why() -> None:
    done = run("live", str(HANS), stdin='{"moves": {"sweater": [0, 0, 0.1]}}\n')
    assert '"because": "The sweater is not on top of the electric heater (short by 8 cm)."' in done.out


def test_live_goes_on_where_reasons_take_too_long(tmp_path: Path) -> None:
    script = tmp_path / "hurried.py"
    script.write_text(
        "import sys\nfrom deixis.cli import live, main\nlive._PATIENCE = 1e-6\n"
        f"sys.argv = ['deixis', 'live', {str(HANS)!r}]\nsys.exit(main())\n",
        "utf-8",
    )
    updates = "\n".join(json.dumps({"moves": {"sweater": [0, 0, way]}}) for way in (0.1, -0.1))
    done = subprocess.run(
        [sys.executable, str(script)], check=False, input=updates.encode(), stdout=subprocess.PIPE
    )
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0
    assert [len(one["gained"]) for one in told] == [0, 1]
    assert [one["because"] for one in told[0]["lost"] + told[1]["gained"]] == [None, None]


# For long


def resident() -> float:
    """Return the memory of this process in use, MiB."""
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def stream(count: int, moving: int, steps: int, capsys: pytest.CaptureFixture[str]) -> None:
    """Follow a room for some updates at ten a second, in which things move, come and go, and the robot too.

    The time between two is not waited for, unless DEIXIS_REAL_TIME=1. Times are printed, memory is asserted.
    """
    draw = random.Random(7)  # noqa: S311 - a test
    kb = KnowledgeBase(room(count))
    kb.update(Update())
    wait = os.environ.get("DEIXIS_REAL_TIME") == "1"
    taken, worked, memory, changed = [], [], [], 0
    begun = time.perf_counter()
    for step in range(steps):
        named = [one.id for one in kb.scene.objects if one.kind == "object"]
        view = kb.scene.views[0]
        told: dict[str, Any] = {
            "stamp": step / 10,
            "moves": {
                name: [draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1), 0.0]
                for name in draw.sample(named, min(moving, len(named)))
            },
            "views": [
                {"id": view.id, "position": [*(view.position[:2] + draw.uniform(-0.1, 0.1)).tolist(), 0.5]}
            ],
        }
        if step % 20 == 10:
            # Names are never used twice.
            told["objects"] = [
                box(f"new{step}", (draw.uniform(0, 9), draw.uniform(0, 9), 0.2), (0.3, 0.3, 0.4))
            ]
            told["removed"] = [named[draw.randrange(len(named))]]
            told["moves"].pop(told["removed"][0], None)
        if wait:
            time.sleep(max(begun + step / 10 - time.perf_counter(), 0.0))
        start, work = time.perf_counter(), time.thread_time()
        changes = kb.update(Update.from_dict(told, kb.scene))
        taken.append(1000 * (time.perf_counter() - start))
        worked.append(1000 * (time.thread_time() - work))
        changed += len(changes.gained) + len(changes.lost)
        if step % 50 == 0:
            memory.append(resident())
    kb.close()
    p50, p99 = np.percentile(taken, [50, 99])
    # What other programs on the machine take is not in this.
    own50, own99 = np.percentile(worked, [50, 99])
    early, late = (float(np.median(part)) for part in (memory[len(memory) // 10 :][:10], memory[-10:]))
    with capsys.disabled():
        print(
            f"\n{count} things, {moving} moved at a time, {steps} updates, {changed} changes: "
            f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, longest {max(taken):.1f} ms (processor time: p50 "
            f"{own50:.1f} ms, p99 {own99:.1f} ms); memory {early:.0f} MiB, at the end {late:.0f} MiB"
        )
    assert late - early < 16


@pytest.mark.long
@pytest.mark.parametrize("moving", [1, 10, 100])
def test_ten_minutes_at_ten_updates_a_second(moving: int, capsys: pytest.CaptureFixture[str]) -> None:
    stream(100, moving, 6000, capsys)


@pytest.mark.long
def test_a_thousand_things_for_a_minute(capsys: pytest.CaptureFixture[str]) -> None:
    stream(1000, 1, 600, capsys)
