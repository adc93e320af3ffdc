"""Where SWI-Prolog is looked for, and what is said when it is not there."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from deixis.errors import MissingDependency, PrologNotFoundError
from deixis.prolog import find

GOOD = {"PLVERSION": "90004", "PLSHARED": "yes", "PLBASE": "/home", "PLLIBSWIPL": "", "PLSOEXT": "so"}


def program(directory: Path, **told: str) -> Path:
    """Write a ``swipl`` that tells these variables."""
    directory.mkdir(parents=True, exist_ok=True)
    lines = "".join(f'{name}="{value}";\n' for name, value in {**GOOD, **told}.items())
    path = directory / "swipl"
    path.write_text(f"#!/bin/sh\ncat <<'END'\n{lines}END\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def library(tmp_path: Path) -> Path:
    path = tmp_path / "libswipl.so.9"
    path.touch()
    return path


@pytest.fixture(autouse=True)
def nothing_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Leave an empty PATH and an empty Python prefix."""
    place = tmp_path / "bin"
    # The stand-in programs need cat; the shell that runs them is named in full.
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "cat").symlink_to("/bin/cat")
    monkeypatch.setenv("PATH", f"{place}:{tmp_path / 'tools'}")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "prefix"))
    monkeypatch.setattr(find, "_MAC_APP", tmp_path / "no-app")
    return place


def test_on_the_path(nothing_installed: Path, library: Path) -> None:
    swipl = program(nothing_installed, PLLIBSWIPL=str(library))
    found = find.locate(None, None)
    assert found == find.Installation(swipl, library, Path("/home"), (9, 0, 4))


def test_below_swi_home_dir_first(nothing_installed: Path, library: Path, tmp_path: Path) -> None:
    program(nothing_installed, PLLIBSWIPL=str(library))
    inside = program(tmp_path / "swi" / "bin" / "x86_64-linux", PLLIBSWIPL=str(library))
    assert find.locate(str(tmp_path / "swi"), None).executable == inside


def test_beside_this_python(library: Path, tmp_path: Path) -> None:
    beside = program(tmp_path / "prefix" / "bin", PLLIBSWIPL=str(library))
    assert find.locate(None, None).executable == beside


def test_library_by_pattern_and_by_variable(nothing_installed: Path, library: Path, tmp_path: Path) -> None:
    program(nothing_installed, PLLIBDIR=str(tmp_path))
    assert find.locate(None, None).library == library
    other = tmp_path / "other.so"
    other.touch()
    assert find.locate(None, str(other)).library == other


def test_missing_lists_what_was_tried_and_the_commands(tmp_path: Path) -> None:
    with pytest.raises(PrologNotFoundError) as caught:
        find.locate(str(tmp_path / "nowhere"), None)
    message = str(caught.value)
    for words in (
        f"SWI_HOME_DIR={tmp_path / 'nowhere'}: not there",
        "swipl on the PATH: not there",
        "sudo apt-get install swi-prolog-nox",
        "conda install -c conda-forge swi-prolog",
        "brew install swi-prolog",
        "Check: deixis doctor",
    ):
        assert words in message


@pytest.mark.parametrize(
    ("told", "reason"),
    [
        ({"PLVERSION": "80423"}, "version 8.4.23: too old"),
        ({"PLSHARED": "no"}, "has no shared library"),
        ({"PLLIBSWIPL": "/gone.so"}, "has no shared library"),
        ({"PLVERSION": "?"}, "does not tell its version"),
    ],
)
def test_unfit_says_why(nothing_installed: Path, told: dict[str, str], reason: str) -> None:
    program(nothing_installed, **told)
    with pytest.raises(PrologNotFoundError, match=reason):
        find.locate(None, None)


def test_wrong_libswipl_path_says_so(nothing_installed: Path, library: Path) -> None:
    program(nothing_installed, PLLIBSWIPL=str(library))
    with pytest.raises(PrologNotFoundError, match=r"no shared library at LIBSWIPL_PATH=/gone\.so"):
        find.locate(None, "/gone.so")


def test_a_program_that_fails_is_passed_over(nothing_installed: Path, library: Path, tmp_path: Path) -> None:
    broken = program(nothing_installed)
    broken.write_text("#!/bin/sh\nexit 3\n")
    with pytest.raises(PrologNotFoundError, match="does not run"):
        find.locate(None, None)
    beside = program(tmp_path / "prefix" / "bin", PLLIBSWIPL=str(library))
    assert find.locate(None, None).executable == beside


def test_pyswip_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(MissingDependency, match="pip install pyswip"):
        find.find_pyswip()
