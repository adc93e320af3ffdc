"""The commands together: what is wrong with one of their values is said in our words."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperGroup

_THEIRS = "Value error, "
"""What pydantic, which newer versions of Typer read values with, puts in front of what is wrong."""


class Group(TyperGroup):
    """A group of commands."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message = error.message.removeprefix(_THEIRS)
            raise
