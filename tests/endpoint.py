"""A server for tests: in a process of its own, on a free port, spoken to byte by byte."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

HANS = Path(__file__).resolve().parent.parent / "kb" / "scenes" / "hans.json"
TOKEN = "let me in"  # noqa: S105 - a test's


@dataclass(frozen=True)
class Reply:
    """What a server answered."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def detail(self) -> str:
        return str(self.json["detail"])


@dataclass
class Server:
    """A running server."""

    port: int
    process: subprocess.Popen[bytes]

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def send(
        self, method: str, path: str, body: bytes | None = None, *, token: bool = False, **headers: str
    ) -> Reply:
        """Send a request with these headers and no others; ``content_type`` is Content-Type."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=60)
        given = {name.replace("_", "-"): value for name, value in headers.items()}
        if token:
            given["Authorization"] = f"Bearer {TOKEN}"
        try:
            connection.putrequest(method, path, skip_accept_encoding=True, skip_host="host" in given)
            if body is not None and "transfer-encoding" not in given:
                connection.putheader("Content-Length", str(len(body)))
            for name, value in given.items():
                connection.putheader(name, value)
            connection.endheaders(body)
            response = connection.getresponse()
            names = {name.lower(): value for name, value in response.getheaders()}
            return Reply(response.status, names, response.read())
        finally:
            connection.close()

    def query(self, text: str, accept: str = "application/sparql-results+json", **fields: str) -> Reply:
        """Send a query in the body."""
        path = "/sparql" + ("?" + urlencode(fields) if fields else "")
        return self.send("POST", path, text.encode(), content_type="application/sparql-query", accept=accept)

    def update(self, text: str, *, token: bool = True) -> Reply:
        """Send an update in the body."""
        return self.send(
            "POST", "/sparql", text.encode(), token=token, content_type="application/sparql-update"
        )

    def put(self, name: str, scene: Mapping[str, Any]) -> Reply:
        """Load a scene."""
        return self.send(
            "PUT", f"/scenes/{name}", json.dumps(scene).encode(), token=True, content_type="application/json"
        )

    def change(self, name: str, update: Mapping[str, Any], *, token: bool = True) -> Reply:
        """Update a scene."""
        body = json.dumps(update).encode()
        return self.send(
            "POST", f"/scenes/{name}/updates", body, token=token, content_type="application/json"
        )

    def family(self) -> list[int]:
        """Return the process ids of the server and all that descend from it."""
        found, known = [self.process.pid], children()
        for pid in found:
            found += known.get(pid, [])
        return found

    def kill(self) -> None:
        """End the server as a crash would."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def children() -> dict[int, list[int]]:
    """Return the children of each process."""
    found: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        found.setdefault(int(fields[1]), []).append(int(stat.parent.name))
    return found


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start(
    *arguments: str | Path,
    env: Mapping[str, str] | None = None,
    command: Sequence[str] = ("-m", "deixis", "serve"),
    port: int | None = None,
) -> Server:
    """Start a server and wait until it answers."""
    port = port or free_port()
    line = [sys.executable, "-W", "error", *command, *map(str, arguments), "--port", str(port)]
    process = subprocess.Popen(
        line, env=os.environ | {"DEIXIS_TOKEN": TOKEN} | (env or {}), stderr=subprocess.PIPE
    )
    server = Server(port, process)
    deadline = time.monotonic() + 60
    while True:
        try:
            if server.send("GET", "/health").status == 200:
                return server
        except OSError:
            if process.poll() is not None:
                assert process.stderr is not None
                with process.stderr:
                    said = process.stderr.read().decode()
                raise AssertionError(said) from None
            if time.monotonic() > deadline:
                process.kill()
                raise
            time.sleep(0.05)


@contextmanager
def serving(
    *arguments: str | Path,
    env: Mapping[str, str] | None = None,
    command: Sequence[str] = ("-m", "deixis", "serve"),
    port: int | None = None,
) -> Iterator[Server]:
    """Run a server for a block."""
    server = start(*arguments, env=env, command=command, port=port)
    try:
        yield server
    finally:
        server.process.terminate()
        try:
            server.process.wait(15)
        except subprocess.TimeoutExpired:
            server.kill()
        if server.process.stderr is not None:
            server.process.stderr.close()
