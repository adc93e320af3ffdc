"""Steps of proofs, as those see them who write them down and stand below what makes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from deixis.evidence import Evidence


class Place(Protocol):
    """Where a rule stands: see :class:`deixis.explain.Rule`."""

    @property
    def file(self) -> str: ...  # noqa: D102
    @property
    def line(self) -> int: ...  # noqa: D102


class Step(Protocol):
    """One step of a proof: see :class:`deixis.explain.Proof`."""

    @property
    def kind(self) -> str: ...  # noqa: D102
    @property
    def predicate(self) -> str: ...  # noqa: D102
    @property
    def args(self) -> tuple[str | float | None, ...]: ...  # noqa: D102
    @property
    def text(self) -> str: ...  # noqa: D102
    @property
    def margin(self) -> float | None: ...  # noqa: D102
    @property
    def axiom(self) -> int | None: ...  # noqa: D102
    @property
    def rule(self) -> Place | None: ...  # noqa: D102
    @property
    def shown(self) -> bool: ...  # noqa: D102
    @property
    def evidence(self) -> Evidence | None: ...  # noqa: D102
    @property
    def children(self) -> Sequence[Step]: ...  # noqa: D102
