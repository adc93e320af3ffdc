"""Where SWI-Prolog is on this machine: its shared library, its home directory and its version."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from deixis.errors import MissingDependency, PrologNotFoundError

OLDEST: Final = (9, 0, 0)
"""The oldest SWI-Prolog that the rules and the bridge are written for."""

_MAC_APP: Final = Path("/Applications/SWI-Prolog.app/Contents/MacOS/swipl")

_REMEDY: Final = """\
Install it with one of
  Debian, Ubuntu: sudo apt-get install swi-prolog-nox
  conda:          conda install -c conda-forge swi-prolog
  macOS:          brew install swi-prolog
Check: deixis doctor"""

_ANSWERS_WITHIN: Final = 20.0


@dataclass(frozen=True)
class Installation:
    """One usable SWI-Prolog.

    Attributes
    ----------
    executable : Path
        The ``swipl`` program.
    library : Path
        The shared library, ``libswipl``.
    home : Path
        The directory of its own Prolog library.
    version : tuple of int
        Major, minor, patch.
    """

    executable: Path
    library: Path
    home: Path
    version: tuple[int, int, int]


@cache
def find_prolog() -> Installation:
    """Return the SWI-Prolog of this machine, looked for once in a process.

    The first ``swipl`` that serves is taken from: below the directory ``SWI_HOME_DIR``, the ``PATH``,
    beside this Python, the macOS application. ``LIBSWIPL_PATH`` names a shared library to use with it.

    Raises
    ------
    PrologNotFoundError
        There is none, or each is too old or without a shared library. The message lists what was tried
        and the command that installs it.

    Examples
    --------
    >>> find_prolog().library.name.startswith("libswipl")
    True
    """
    return locate(os.environ.get("SWI_HOME_DIR"), os.environ.get("LIBSWIPL_PATH"))


def locate(home: str | None, library: str | None) -> Installation:
    """Do what :func:`find_prolog` promises, for given values of the two variables and without memory."""
    tried: list[str] = []
    for program, origin in _programs(home):
        found = _judge(program, library)
        if isinstance(found, Installation):
            return found
        tried.append(f"{origin}: {found}")
    attempts = "\n".join(f"  - {line}" for line in tried)
    oldest = ".".join(map(str, OLDEST))
    raise PrologNotFoundError(
        f"SWI-Prolog {oldest} or newer with a shared library was not found. Tried:\n{attempts}\n{_REMEDY}"
    )


def find_pyswip() -> Path:
    """Return the directory that holds the package pyswip, without importing it (that would start Prolog).

    Raises
    ------
    MissingDependency
        pyswip is not installed beside this Python.

    Examples
    --------
    >>> (find_pyswip() / "pyswip").is_dir()
    True
    """
    from importlib.util import find_spec

    spec = find_spec("pyswip")
    if spec is None or spec.origin is None:
        raise MissingDependency(
            "the Python package pyswip was not found: pip install pyswip\nCheck: deixis doctor"
        )
    return Path(spec.origin).parent.parent


def _programs(home: str | None) -> list[tuple[Path | None, str]]:
    """Return the places to ask, each with the words that name it."""
    places: list[tuple[Path | None, str]] = []
    if home:
        inside = [path for path in sorted(Path(home).glob("bin/**/swipl")) if path.is_file()]
        places.append((inside[0] if inside else None, f"SWI_HOME_DIR={home}"))
    on_path = shutil.which("swipl")
    places.append((Path(on_path) if on_path else None, "swipl on the PATH"))
    beside = Path(sys.prefix, "bin", "swipl")
    places.append((beside if beside.is_file() else None, str(beside)))
    if sys.platform == "darwin":
        places.append((_MAC_APP if _MAC_APP.is_file() else None, str(_MAC_APP)))
    return places


def _judge(program: Path | None, library: str | None) -> Installation | str:
    """Return the installation a program belongs to, or why it cannot be used."""
    if program is None:
        return "not there"
    try:
        asked = subprocess.run(
            [program, "--dump-runtime-variables"],
            capture_output=True,
            stdin=subprocess.DEVNULL,
            timeout=_ANSWERS_WITHIN,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        return f"{program} does not run ({error})"
    told = _variables(asked.stdout.decode(errors="replace"))
    if not told.get("PLVERSION", "").isdecimal():
        return f"{program} does not tell its version"
    number = int(told["PLVERSION"])
    version = (number // 10000, number // 100 % 100, number % 100)
    if version < OLDEST:
        return f"{program} is version {'.'.join(map(str, version))}: too old"
    shared = Path(library) if library else _library(told)
    if shared is None or not shared.is_file():
        return f"{program} has no shared library" + (f" at LIBSWIPL_PATH={library}" if library else "")
    return Installation(program, shared, Path(told.get("PLBASE", "")), version)


def _variables(text: str) -> dict[str, str]:
    """Return the ``NAME="value";`` lines of a program's answer."""
    pairs = (line.rstrip(";\r").partition("=") for line in text.splitlines())
    return {name: value.strip('"') for name, equals, value in pairs if equals}


def _library(told: dict[str, str]) -> Path | None:
    """Return the shared library; a program linked statically names none that exists."""
    if told.get("PLSHARED") != "yes":
        return None
    named = Path(told.get("PLLIBSWIPL", ""))
    if named.is_file():
        return named
    pattern = f"libswipl*.{told.get('PLSOEXT', 'so')}*"
    return next(iter(sorted(Path(told.get("PLLIBDIR", "")).glob(pattern))), None)
