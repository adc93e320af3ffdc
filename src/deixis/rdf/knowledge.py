"""What an export asks of a knowledge base or of a map, so that this layer need not know those above it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from deixis.facts import Facts, RegionModel, SolidModel
from deixis.ruleset import Ruleset
from deixis.scene import Scene
from deixis.steps import Step


class Relates(Protocol):
    """A relation of two things, in a view where that matters."""

    @property
    def relation(self) -> str: ...  # noqa: D102
    @property
    def figure(self) -> str: ...  # noqa: D102
    @property
    def reference(self) -> str: ...  # noqa: D102
    @property
    def view(self) -> str | None: ...  # noqa: D102


class Holds(Relates, Protocol):
    """One that holds: see :class:`deixis.knowledge.Relation`."""

    @property
    def margin(self) -> float | None: ...  # noqa: D102


class Lasts(Relates, Protocol):
    """One while it held: see :class:`deixis.semantic_map.Interval`."""

    @property
    def since(self) -> float: ...  # noqa: D102
    @property
    def until(self) -> float | None: ...  # noqa: D102


class Notice(Protocol):
    """What a view withholds of a reference: see :class:`deixis.knowledge.Withheld`."""

    @property
    def view(self) -> str: ...  # noqa: D102
    @property
    def reference(self) -> str: ...  # noqa: D102
    @property
    def reason(self) -> str: ...  # noqa: D102


class Knowledge(Protocol):
    """A scene with all that follows from it: see :class:`deixis.knowledge.KnowledgeBase`."""

    scene: Scene
    region: RegionModel

    @property
    def facts(self) -> Facts: ...  # noqa: D102
    @property
    def rule_files(self) -> Sequence[Path]: ...  # noqa: D102
    @property
    def ruleset(self) -> Ruleset: ...  # noqa: D102
    @property
    def measured_as(self) -> Mapping[str, SolidModel]: ...  # noqa: D102
    @property
    def withheld(self) -> Sequence[Notice]: ...  # noqa: D102
    def relations(  # noqa: D102
        self, *, view: str | None = ..., relation: Iterable[str] | None = ...
    ) -> Sequence[Holds]: ...
    def proofs(  # noqa: D102
        self, *, relation: Iterable[str] | None = ..., evidence: bool = ...
    ) -> Mapping[tuple[str, ...], Step]: ...
