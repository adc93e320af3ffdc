"""What measures a scene: the kernel, or PostGIS by the operators that the paper names."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from deixis.errors import QueryError

if TYPE_CHECKING:
    from deixis.facts import Facts
    from deixis.scene import Scene


class Grounding(StrEnum):
    """What measures a scene."""

    KERNEL = "kernel"
    POSTGIS = "postgis"


GroundingOption = Annotated[
    Grounding,
    typer.Option(
        "--grounding", help="What measures: our own kernel, or PostGIS, slowly, by Table 1 of the paper."
    ),
]


def measured(scene: Scene, grounding: Grounding, region: str, database: str | None) -> Facts | None:
    """Return the facts of a scene where something else than the kernel is to measure it.

    Raises
    ------
    QueryError
        PostGIS is to measure, and no PostgreSQL database is given, or something else than boxes is asked for.
    """
    if grounding is Grounding.KERNEL:
        return None
    if region != "box":
        raise QueryError(
            f"PostGIS measures boxes, and --region {region} asks for more: use --grounding kernel"
        )
    if database is None or not database.startswith(("postgresql://", "postgres://")):
        given = "none is given" if database is None else "--db names none"
        raise QueryError(f"PostGIS measures in a PostgreSQL database, and {given}: use --db postgresql://...")
    from deixis.postgis import ground

    return ground(database, scene)
