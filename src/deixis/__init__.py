"""Deixis: commonsense spatial relations of a 3D scene, derived from written axioms, each with its reasons."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from deixis.knowledge import KnowledgeBase
    from deixis.scene import Scene

__all__ = ["KnowledgeBase", "Scene", "__version__"]

__version__ = "0.1.0"

_HOMES: Final = {"KnowledgeBase": "deixis.knowledge", "Scene": "deixis.scene"}


def __getattr__(name: str) -> object:
    # Loaded on first use: the command line must not wait for what a command does not need.
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
