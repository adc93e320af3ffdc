"""``deixis serve``: scenes over HTTP."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer


def serve(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENE]...",
            help="Scene files, or maps with their history (FILE.duckdb, postgresql://...).",
        ),
    ] = None,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen on.")] = 7878,
    token: Annotated[
        str | None,
        typer.Option(
            envvar="DEIXIS_TOKEN", help="What clients must show to change scenes.", show_default=False
        ),
    ] = None,
    writable: Annotated[
        bool,
        typer.Option(
            "--writable", help="Take updates of scenes and graphs too, from clients with the token."
        ),
    ] = False,
    store: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Keep scenes here: they outlive the server.")
    ] = None,
    allow_host: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A name by which the server may be called.")
    ] = None,
    cors: Annotated[
        list[str] | None, typer.Option(metavar="ORIGIN", help="Web pages that may read answers; * for any.")
    ] = None,
    timeout: Annotated[float, typer.Option(min=0.001, help="Seconds a question may take.")] = 10.0,
    rows: Annotated[int, typer.Option(min=1, help="Rows or triples of an answer.")] = 10_000,
    memory: Annotated[int, typer.Option(min=64, help="MiB a question may take beside the data.")] = 1024,
) -> None:
    """Serve scenes over HTTP: SPARQL at /sparql, graphs at /graphs, JSON at /scenes."""
    from deixis.errors import MissingDependency
    from deixis.server import Limits, Settings

    try:
        from deixis.server.serve import serve as run
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing in ("", "deixis"):
            raise
        raise MissingDependency(f"deixis serve needs {missing}: pip install 'deixis[server]'") from None
    limits = Limits(timeout=timeout, rows=rows, memory=memory << 20)
    hosts, origins = tuple(allow_host or ()), tuple(cors or ())

    def ready() -> None:
        print(f"deixis: serving http://{host}:{port}/sparql and /scenes; stop with Ctrl-C", file=sys.stderr)

    run(scenes or [], Settings(host, port, token or None, writable, store, hosts, origins, limits), ready)
