"""Shown: what every explanation can be turned into, given its headings and steps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from deixis.render.dot import dot
from deixis.render.html import Part, fragment, page


class Shown(ABC):
    """An explanation that can be drawn; a notebook shows it as HTML."""

    __slots__ = ()

    @abstractmethod
    def parts(self) -> Sequence[Part]:
        """Return the headings of the explanation, each with the steps below it."""

    def to_html(self, title: str = "Why", language: str = "en") -> str:
        """Return a whole page that opens step by step and needs nothing else."""
        return page(title, self.parts(), language)

    def to_dot(self) -> str:
        """Return a graph in the DOT language, from conclusions to reasons."""
        return dot(step for _, steps in self.parts() for step in steps)

    def _repr_html_(self) -> str:
        return fragment(self.parts())
