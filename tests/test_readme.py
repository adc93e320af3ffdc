"""README.md and the guide are true: commands and examples give the output shown, links lead somewhere.

The text block after a command is that command's output; ``...`` in it stands for anything. Where output has
changed for a good reason, ``DEIXIS_BLESS=1 pytest tests/test_readme.py`` writes blocks without ``...`` anew.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

import pyoxigraph as ox
import pytest

import deixis.cli.words  # noqa: F401 - adds its commands
import vocabulary_page
from bags_written import kitchen
from commands import run
from deixis import Scene
from deixis.cli import bags, batch, live, maps, questions, tiles, view, words  # noqa: F401 - for their commands
from deixis.cli.commands import app
from draw import PICTURE, SCENE, figure_3
from endpoint import serving
from postgis_server import PostgisUnavailable, postgis
from readme import PAGES, README, Block, blocks, check, shown_after

EXAMPLES = json.loads(
    (README.parent / "src" / "deixis" / "server" / "page" / "examples.json").read_text(encoding="utf-8")
)


COMMANDS = README.parent / "kb" / "guide" / "README.md"
"""The guide's first page, with the table of all commands."""

RULES = COMMANDS.with_name("rules.md")


@pytest.mark.parametrize("block", blocks("sh"), ids=str)
def test_commands_print_what_is_shown(block: Block, root: Path) -> None:
    printed = ""
    for line in block.text.splitlines():
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


@pytest.mark.parametrize("block", blocks("python"), ids=str)
def test_python_prints_what_is_shown(block: Block, root: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", block.text],
        cwd=root,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    check(shown_after(block), done.stdout)


@pytest.mark.parametrize(
    "shell", [one for one in blocks("bash") if one.text.startswith("deixis serve")], ids=str
)
def test_the_server_answers_what_is_shown(shell: Block, root: Path) -> None:
    """The first line starts the server, which here is on another port; what follows are its clients."""
    first, commands = shell.text.split("\n", 1)
    _, name, *scenes, _ = first.split()
    assert name == "serve"
    clients = [(shell, ["sh", "-e", "-c", commands])]
    clients += [(one, [sys.executable, "-c", one.text]) for one in blocks("py", shell.page)]
    with serving(*(root / scene for scene in scenes)) as server:
        for block, command in clients:
            command[-1] = command[-1].replace("http://localhost:7878", server.url)
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stderr) == (0, "")
            # Each answer of curl's ends as the server sent it; a terminal shows it as lines.
            check(
                shown_after(block),
                done.stdout.replace("\r\n", "\n").replace("}{", "}\n{").rstrip("\n") + "\n",
            )


def test_a_living_scene_is_followed_as_is_shown(root: Path, tmp_path: Path) -> None:
    (block,) = (one for one in blocks("bash") if one.text.startswith("export DEIXIS_TOKEN"))
    token, first, commands = block.text.split("\n", 2)
    _, _, *arguments, scene, _ = first.split()
    with serving(*arguments, root / scene, env={"DEIXIS_TOKEN": token.partition("=")[2]}) as server:
        script = f"{token}\n{commands.replace('http://localhost:7878', server.url)}wait"
        done = subprocess.run(
            ["sh", "-e", "-c", script], capture_output=True, text=True, cwd=tmp_path, check=False
        )
    assert (done.returncode, done.stderr) == (0, "")
    check(shown_after(block), done.stdout)


def test_the_map_tells_what_is_shown(root: Path, tmp_path: Path) -> None:
    """The commands are run where they may leave files; the query is asked of what they export."""
    (tmp_path / "kb").symlink_to(root / "kb")
    tools = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for block in (one for one in blocks("bash") if "deixis map" in one.text):
        done = subprocess.run(
            ["sh", "-e", "-c", block.text],
            cwd=tmp_path,
            env=tools,
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=False,
        )
        assert done.returncode == 0, done.stderr
        check(shown_after(block), done.stdout.expandtabs())
    store = ox.Store()
    store.load(path=tmp_path / "hall.trig")
    (query,) = blocks("sparql")
    found = store.query(query.text, prefixes=EXAMPLES["prefixes"], use_default_graph_as_union=True)
    check(shown_after(query), "".join(" | ".join(one.value for one in row) + "\n" for row in found))


def test_a_recording_tells_what_is_shown(tmp_path: Path) -> None:
    (block,) = (one for one in blocks("bash") if one.text.startswith("deixis bag"))
    kitchen(tmp_path / "kitchen")
    check(shown_after(block), run(*shlex.split(block.text)[1:], cwd=tmp_path).out)


def test_the_data_set_tells_what_is_shown(root: Path, tmp_path: Path) -> None:
    (block,) = (one for one in blocks("bash") if one.text.startswith("deixis batch"))
    (tmp_path / "kb").symlink_to(root / "kb")
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    done = subprocess.run(
        ["sh", "-e", "-c", block.text],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "deixis: relations: 4 scenes, 1,500 relations\n")
    check(shown_after(block), done.stdout.replace("\n\n", "\n"))


def test_postgis_measures_what_is_shown(root: Path) -> None:
    (block,) = (one for one in blocks("bash") if one.text.startswith("deixis relations"))
    try:
        with postgis() as address:
            home = quote(address.split()[0].removeprefix("host="), safe="")
            place = f"postgresql://deixis@/postgres?host={home}"
            command = block.text.replace("postgresql:///robot", place)
            check(shown_after(block), run(*shlex.split(command)[1:], cwd=root).out)
    except PostgisUnavailable as reason:
        pytest.skip(str(reason))


def test_prolog_answers_what_is_shown(root: Path) -> None:
    rule, _, own, _ = blocks("prolog", RULES)
    for block, name in ((rule, "commonsense"), (own, "safety"), (*blocks("prolog", README), "commonsense")):
        assert f"\n{block.text}\n" in (root / "rules" / f"{name}.pl").read_text(encoding="utf-8")
    command, *dialogue = shown_after(rule).text.splitlines()
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


def test_rules_of_ones_own_are_checked_as_is_shown(tmp_path: Path) -> None:
    _, own, _, breach = blocks("prolog", RULES)
    (tmp_path / "my.pl").write_text(own.text, encoding="utf-8")
    assert run("relations", SCENE, "--rules", tmp_path / "my.pl", "--relation", "rests_on").code == 0
    (tmp_path / "my.pl").write_text(own.text.replace("on_top_of", "on_topof", 1), encoding="utf-8")
    result = run("rules", "check", "my.pl", cwd=tmp_path)
    assert (result.code, result.err) == (1, "")
    check(shown_after(own), result.out)
    (tmp_path / "drying.pl").write_text(breach.text, encoding="utf-8")
    found = run("check", SCENE, "--rules", tmp_path / "drying.pl")
    assert found.code == 1
    check(shown_after(breach), found.out)


def test_the_table_of_commands_is_complete() -> None:
    table = dict(
        re.findall(r"^\| `deixis ([\w-]+)(.*) \|$", COMMANDS.read_text(encoding="utf-8"), re.MULTILINE)
    )
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    commands |= {group.name for group in app.registered_groups}
    assert table.keys() == commands
    for command, row in table.items():
        options = re.findall(r"--[a-z]+", row)
        shown = run(command, "-h").out if options else ""
        assert [option for option in options if option not in shown] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    inside = [link for link in links if not link.startswith("https://")]
    assert [link for link in inside if not (page.parent / link).exists()] == []


def test_the_list_of_what_can_be_said_is_current() -> None:
    assert vocabulary_page.PAGE.read_text(encoding="utf-8") == vocabulary_page.page()


def test_every_page_of_the_guide_is_named_in_it() -> None:
    for index in (README, COMMANDS):
        text = index.read_text(encoding="utf-8")
        assert [page.name for page in PAGES if page not in (README, COMMANDS) and page.name not in text] == []


def test_the_picture_is_drawn_from_the_scene() -> None:
    drawn = figure_3(Scene.load(SCENE))
    assert PICTURE.read_text(encoding="utf-8") == drawn, "draw it anew: python tests/draw.py"
    assert len(drawn.encode()) < 15_000
    assert "http" not in drawn.replace("http://www.w3.org/2000/svg", "")
