"""The README is true: its commands and examples give the output it prints, its links lead somewhere.

The text block after a command is that command's output; ``...`` in it stands for anything. Where output has
changed for a good reason, ``DEIXIS_BLESS=1 pytest tests/test_readme.py`` writes blocks without ``...`` anew.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

import pytest

import deixis.cli.words  # noqa: F401 - adds its commands
from commands import run
from deixis import Scene
from deixis.cli import live, maps, questions, tiles, view, words  # noqa: F401 - they add their commands
from deixis.cli.commands import app
from draw import PICTURE, SCENE, figure_3
from endpoint import serving
from postgis_server import PostgisUnavailable, postgis
from readme import README, blocks, check, shown_after


@pytest.mark.parametrize("number", range(len(blocks("sh"))))
def test_commands_print_what_the_readme_shows(number: int, root: Path) -> None:
    block = blocks("sh")[number]
    printed = ""
    for line in block["text"].splitlines():
        typed = shlex.split(line, comments=True)
        if typed == ["make", "demo"]:
            typed = ["deixis", "demo"]
        if typed[0] == "make":
            assert re.search(rf"^{typed[1]}:", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
            continue
        assert typed[0] == "deixis"
        result = run(*typed[1:], cwd=root)
        assert result.code in (0, 1), result.err
        printed += result.out
    check(shown_after(block), printed)


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_python_prints_what_the_readme_shows(number: int, root: Path) -> None:
    block = blocks("python")[number]
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", block["text"]],
        cwd=root,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    check(shown_after(block), done.stdout)


def test_the_server_answers_what_the_readme_shows(root: Path) -> None:
    """The first line starts the server, which here is on another port."""
    (shell,) = (one for one in blocks("bash") if one["text"].startswith("deixis serve"))
    (client,) = blocks("py")
    first, commands = shell["text"].split("\n", 1)
    _, name, *scenes, _ = first.split()
    assert name == "serve"
    with serving(*(root / scene for scene in scenes)) as server:
        for block, command in (
            (shell, ["sh", "-e", "-c", commands]),
            (client, [sys.executable, "-c", client["text"]]),
        ):
            command[-1] = command[-1].replace("http://localhost:7878", server.url)
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stderr) == (0, "")
            # Each answer of curl's ends as the server sent it; a terminal shows it as lines.
            check(
                shown_after(block),
                done.stdout.replace("\r\n", "\n").replace("}{", "}\n{").rstrip("\n") + "\n",
            )


def test_the_map_tells_what_the_readme_shows(root: Path, tmp_path: Path) -> None:
    """The commands are run where they may leave a file."""
    (block,) = (one for one in blocks("bash") if one["text"].startswith("deixis map"))
    (tmp_path / "kb").symlink_to(root / "kb")
    results = [run(*shlex.split(line)[1:], cwd=tmp_path) for line in block["text"].splitlines()]
    assert {result.code for result in results} == {0}
    check(shown_after(block), "".join(result.out for result in results).expandtabs())


def test_postgis_measures_what_the_readme_shows(root: Path) -> None:
    (block,) = (one for one in blocks("bash") if one["text"].startswith("deixis relations"))
    try:
        with postgis() as address:
            home = quote(address.split()[0].removeprefix("host="), safe="")
            place = f"postgresql://deixis@/postgres?host={home}"
            command = block["text"].replace("postgresql:///robot", place)
            check(shown_after(block), run(*shlex.split(command)[1:], cwd=root).out)
    except PostgisUnavailable as reason:
        pytest.skip(str(reason))


def test_prolog_answers_what_the_readme_shows(root: Path) -> None:
    rule, _, own = blocks("prolog")
    for block, name in ((rule, "commonsense"), (own, "safety")):
        assert f"\n{block['text']}\n" in (root / "rules" / f"{name}.pl").read_text(encoding="utf-8")
    command, *dialogue = shown_after(rule)["text"].splitlines()
    # At a terminal, ; asks for the next answer; in a pipe it is a line of its own and not echoed.
    typed, answers = "", []
    for line in dialogue:
        if line.startswith("?- "):
            typed += line.removeprefix("?- ") + "\n"
        else:
            typed += ";\n" if line.endswith(" ;") else ""
            answers.append(line.removesuffix(" ;"))
    result = run(*shlex.split(command.removeprefix("$ deixis ")), stdin=typed, cwd=root)
    assert (result.code, result.err) == (0, "")
    printed = result.out
    for answer in answers:
        before, found, printed = printed.partition(answer)
        assert found, f"{answer!r} is not in {before!r}"


def test_rules_of_ones_own_are_checked_as_the_readme_shows(tmp_path: Path) -> None:
    _, own, _ = blocks("prolog")
    (tmp_path / "my.pl").write_text(own["text"], encoding="utf-8")
    assert run("relations", SCENE, "--rules", tmp_path / "my.pl", "--relation", "rests_on").code == 0
    (tmp_path / "my.pl").write_text(own["text"].replace("on_top_of", "on_topof", 1), encoding="utf-8")
    result = run("rules", "check", "my.pl", cwd=tmp_path)
    assert (result.code, result.err) == (1, "")
    check(shown_after(own), result.out)


def test_the_table_of_commands_is_complete() -> None:
    table = dict(
        re.findall(r"^\| `deixis ([\w-]+)(.*) \|$", README.read_text(encoding="utf-8"), re.MULTILINE)
    )
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    commands |= {group.name for group in app.registered_groups}
    assert table.keys() == commands
    for command, row in table.items():
        options = re.findall(r"--[a-z]+", row)
        shown = run(command, "-h").out if options else ""
        assert [option for option in options if option not in shown] == []


def test_links_lead_somewhere(root: Path) -> None:
    links = re.findall(r"\]\(([^)]+)\)", README.read_text(encoding="utf-8"))
    assert [link for link in links if not link.startswith("https://") and not (root / link).exists()] == []


def test_the_picture_is_drawn_from_the_scene() -> None:
    drawn = figure_3(Scene.load(SCENE))
    assert PICTURE.read_text(encoding="utf-8") == drawn, "draw it anew: python tests/draw.py"
    assert len(drawn.encode()) < 15_000
    assert "http" not in drawn.replace("http://www.w3.org/2000/svg", "")
