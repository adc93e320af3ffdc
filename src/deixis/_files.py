"""Where ``rules/`` and ``kb/`` are, in the package or at the top of the checkout; and files written whole."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path
from typing import Final

from deixis.errors import QueryError, RuleError

_PACKAGE: Final = Path(__file__).resolve().parent


def rules_dir() -> Path:
    """Return the directory of the rule files.

    Raises
    ------
    RuleError
        It is at neither of the two places; the message names both.

    Examples
    --------
    >>> rules_dir().name
    'rules'
    """
    return _find("rules", _PACKAGE)


def kb_dir() -> Path:
    """Return the directory of the ontology, the sample scenes and the decision records.

    Raises
    ------
    RuleError
        It is at neither of the two places; the message names both.

    Examples
    --------
    >>> kb_dir().name
    'kb'
    """
    return _find("kb", _PACKAGE)


def write_whole(place: Path, text: bytes) -> None:
    """Write a file whole or not at all: an interrupted write leaves the old one, and nothing beside it.

    A link is followed, and a file that is replaced keeps its mode. What is no file, a pipe or a device, is
    written to as it is.
    """
    if place.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(place))
    if place.exists() and not place.is_file():
        with place.open("wb") as sink:
            sink.write(text)
        return
    place = place.resolve()
    draft = place.with_name(f".{place.name}.{os.getpid()}.part")
    try:
        with draft.open("wb") as sink:
            sink.write(text)
            sink.flush()
            # Else a machine that goes down may leave the new name on an empty file.
            os.fsync(sink.fileno())
        if place.exists():
            shutil.copymode(place, draft)
        draft.replace(place)
    except BaseException:  # someone's Ctrl-C among them
        draft.unlink(missing_ok=True)
        raise


def _find(name: str, package: Path) -> Path:
    # An editable install leaves a frozen copy in site-packages. It is never seen here: `package` is
    # where this file lies, and that is src/ of the checkout, which holds no copy.
    packaged, checkout = package / name, package.parent.parent / name
    for place in (packaged, checkout):
        if place.is_dir():
            return place
    raise RuleError(f"no {name}/ at {packaged} or {checkout}: reinstall deixis, or use a whole checkout")


def languages() -> tuple[str, ...]:
    """Return the languages that sentences can be in.

    Examples
    --------
    >>> languages()
    ('de', 'en')
    """
    return tuple(sorted(path.stem for path in (rules_dir() / "lang").glob("*.pl")))


def theory_files(language: str = "en") -> tuple[Path, ...]:
    """Return the rule files of the theory, in loading order, with the words of a language if not English.

    Raises
    ------
    QueryError
        There is no file of that language.
    """
    rules = rules_dir()
    if language not in languages():
        raise QueryError(f"no language {language!r}: known are {', '.join(languages())}")
    names = ("facts", "topology", "direction", "commonsense", "axioms", "explain")
    spoken = () if language == "en" else (rules / "lang" / f"{language}.pl",)
    return (*(rules / f"{name}.pl" for name in names), *spoken)


def datalog_files() -> tuple[Path, ...]:
    """Return the rule files of the theory that are in the subset every engine runs, in loading order."""
    return tuple(rules_dir() / f"{name}.pl" for name in ("facts", "topology", "direction", "commonsense"))
