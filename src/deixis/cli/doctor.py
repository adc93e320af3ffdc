"""What ``deixis doctor`` looks at: Python, the libraries, SWI-Prolog, the rules, and one real answer."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from deixis import __version__
from deixis._files import kb_dir, rules_dir
from deixis.errors import DeixisError

LIBRARIES = ("duckdb", "lark", "numpy", "scipy", "shapely", "trimesh", "pydantic", "pyswip", "typer")


def report() -> bool:
    """Print one line for each thing that Deixis needs; return whether all of them are well."""
    well = True
    print(f"ok    deixis {__version__} on Python {platform.python_version()}, {platform.system()}")
    for name in LIBRARIES:
        try:
            print(f"ok    {name} {version(name)}")
        except PackageNotFoundError:
            print(f"FAIL  {name} is not installed: pip install deixis")
            well = False
    for check in (_prolog, _files, _answer):
        try:
            print(f"ok    {check()}")
        except DeixisError as error:
            print(f"FAIL  {error}")
            well = False
    return well


def _prolog() -> str:
    from deixis.prolog.find import find_prolog

    found = find_prolog()
    return f"SWI-Prolog {'.'.join(map(str, found.version))}, {found.library}"


def _files() -> str:
    return f"rules in {rules_dir()}, knowledge in {kb_dir()}"


def _answer() -> str:
    from deixis.knowledge import KnowledgeBase

    with KnowledgeBase.from_scene(kb_dir() / "scenes" / "hans.json") as kb:
        return f"the sample scene has {len(kb.relations())} relations"
