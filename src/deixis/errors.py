"""Every error Deixis raises on purpose: one base, one leaf for one kind of trouble.

A message names the object concerned and the remedy. Exit codes of the command line follow the class.
"""

from __future__ import annotations

from typing import ClassVar


class DeixisError(Exception):
    """Base of all errors that Deixis raises on purpose."""

    exit_code: ClassVar[int] = 2


class SceneError(DeixisError):
    """A scene, object, surface or view was refused at the door; nothing of it was asserted."""


class GeometryError(DeixisError):
    """A region cannot be grounded, or a scene asks for more pairs than the stated limit."""


class ReaderError(DeixisError):
    """A file cannot be read as the format it was said to be."""


class MapError(DeixisError):
    """A semantic map cannot be opened, read or written; what was told of it before is kept."""


class ThresholdError(DeixisError):
    """A threshold is not a finite number in its allowed range."""


class RuleError(DeixisError):
    """A rule file is missing or wrong."""


class QueryError(DeixisError):
    """A question is not well formed, or names something the scene or the rules do not know."""


class QueryTimeout(DeixisError):
    """A question took longer than its time limit and was stopped; there is no partial answer."""

    exit_code: ClassVar[int] = 3


class EngineError(DeixisError):
    """The logic engine failed or was lost; the knowledge base restarts it on the next question."""


class MissingDependency(DeixisError):
    """Something that must be installed beside Deixis was not found."""


class PrologNotFoundError(MissingDependency):
    """SWI-Prolog was not found, or is too old."""
