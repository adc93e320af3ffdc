"""Catalogue case 77 and around it: clients that send slowly, too much, or never read hold up nobody."""

from __future__ import annotations

import http.client
import json
import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from endpoint import HANS, Server, serving

PROGRAM = (
    "import sys; from pathlib import Path; from deixis.server import Limits, Settings;"
    "from deixis.server.serve import serve;"
    "limits = Limits(head_seconds=1.0, upload_seconds=1.0, send_seconds=1.0, connections=20);"
    "serve([Path(sys.argv[1])], Settings(port=int(sys.argv[-1]), limits=limits))"
)
HEAD = b"GET /health HTTP/1.1\r\nHost: localhost\r\n"
POST = b"POST /sparql HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/sparql-query\r\n"


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(HANS, command=["-c", PROGRAM]) as running:
        yield running


@pytest.fixture(autouse=True)
def well(server: Server) -> Iterator[None]:
    yield
    assert server.send("GET", "/health").status == 200


def call(server: Server) -> socket.socket:
    return socket.create_connection(("127.0.0.1", server.port), timeout=10)


def rest(end: socket.socket) -> bytes:
    """Return what comes until the server hangs up."""
    got = b""
    try:
        while part := end.recv(1 << 16):
            got += part
    except ConnectionResetError:
        return got
    return got


def dribble(end: socket.socket, unit: bytes, most: float) -> float:
    """Send a little again and again until the server hangs up; return after how many seconds it did."""
    start = time.monotonic()
    if not unit:
        return 0.0
    while time.monotonic() - start < most:
        try:
            end.sendall(unit)
        except OSError:
            break
        time.sleep(0.05)
    return time.monotonic() - start


@pytest.mark.parametrize("unit", [b"X", b"X-A: b\r\n", b""])
def test_slow_heads_are_told_so(server: Server, unit: bytes) -> None:
    with call(server) as end:
        end.sendall(HEAD)
        assert dribble(end, unit, 5.0) < 3.0
        told = rest(end)
        assert not told or told.startswith(b"HTTP/1.1 408 ")


@pytest.mark.parametrize("unit", [b"", b"\r\n"])
def test_connections_without_a_request_are_closed(server: Server, unit: bytes) -> None:
    with call(server) as end:
        assert dribble(end, unit, 5.0) < 3.0
        assert rest(end) == b""
    with call(server) as end:
        end.sendall(HEAD + b"\r\n")
        assert end.recv(1 << 16).startswith(b"HTTP/1.1 200 ")
        assert dribble(end, unit, 5.0) < 3.0
        assert rest(end) in (b"", server.send("GET", "/health").body)


def test_slow_bodies_are_told_so(server: Server) -> None:
    with call(server) as end:
        end.sendall(POST + b"Content-Length: 100\r\n\r\n")
        dribble(end, b" ", 1.5)
        assert rest(end).startswith(b"HTTP/1.1 408 ")


def test_bodies_that_nobody_asked_for_are_not_waited_for(server: Server) -> None:
    with call(server) as end:
        end.sendall(HEAD + b"Content-Length: 1000\r\n\r\n")
        assert end.recv(1 << 16).startswith(b"HTTP/1.1 200 ")
        assert dribble(end, b" ", 6.0) < 4.0


@pytest.mark.parametrize(
    "head",
    [HEAD + b"X-Long: " + b"x" * 10_000_000, HEAD + b"X: y\r\n" * 1_000_000, b"GET /" + b"x" * 10_000_000],
)
def test_large_heads_are_refused(server: Server, head: bytes) -> None:
    with call(server) as end:
        try:
            end.sendall(head)
        except OSError:
            return
        told = rest(end)
        assert not told or told.startswith((b"HTTP/1.1 431 ", b"HTTP/1.1 400 "))


def test_what_follows_a_body_is_bounded(server: Server) -> None:
    """Extensions of chunks, and trailers, are in no body: they are counted all the same."""
    for more in (b"5;" + b"x" * 60_000_000, b"0\r\n" + b"X: y\r\n" * 10_000_000):
        with call(server) as end:
            end.sendall(POST + b"Transfer-Encoding: chunked\r\n\r\n")
            with pytest.raises(OSError, match=r"."):
                end.sendall(more)


def test_whoever_holds_connections_makes_room_for_others(server: Server) -> None:
    with ExitStack() as stack:
        for n in range(60):
            end = stack.enter_context(call(server))
            end.sendall(POST + b"Content-Length: 100\r\n\r\nA" if n % 2 else HEAD)
            start = time.monotonic()
            assert server.send("GET", "/health").status == 200
            assert server.query("ASK {}").status == 200
            assert time.monotonic() - start < 1.0


def test_who_never_reads_is_hung_up_on(server: Server) -> None:
    ask = b"GET /graphs HTTP/1.1\r\nHost: localhost\r\nAccept: application/n-quads\r\n\r\n"
    with ExitStack() as stack:
        ends = []
        for _ in range(10):
            end = socket.socket()
            end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            end.connect(("127.0.0.1", server.port))
            ends.append(stack.enter_context(end))
            end.sendall(ask * 20)
        time.sleep(4.0)
        for end in ends:
            end.settimeout(5)
            whole = len(rest(end))
            assert whole < 20 * 400_000


def test_a_question_of_any_size_is_not_read(server: Server) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.putrequest("POST", "/scenes/hans/ask")
    connection.putheader("Content-Length", str(1 << 30))
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()
    for size, status in ((60_000, 422), (1_000_000, 413)):
        assert server.send("POST", "/scenes/hans/ask", b"[" * size).status == status
    reply = server.send("POST", "/scenes/hans/ask", json.dumps({"goal": 1}).encode())
    assert (reply.status, bool(re.search("goal: .*string", reply.detail))) == (422, True)


@pytest.mark.parametrize(
    "text",
    [
        b"\x00\x01\x02\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"GET http:// HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET //[ HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /%00%ff HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /sparql?query=%ff HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /sparql?query=\xff\xfe HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /health HTTP/1.1\r\nHost: a\r\nHost: localhost\r\n\r\n",
        b"GET /health HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
        b"GET /health HTTP/1.1\r\nHost: [::1\r\n\r\n",
        b"GET /sparql HTTP/1.1\r\nHost: localhost:99999999\r\n\r\n",
        b"GET /sparql HTTP/1.1\r\nHost: localhost:x\r\n\r\n",
        b"GET /sparql HTTP/1.1\r\nHost: localhost:<>\r\n\r\n",
        b"GET /graphs/a%20b HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /scenes/%ed%a0%80 HTTP/1.1\r\nHost: localhost\r\n\r\n",
        POST + b"Content-Length: 5\r\nContent-Length: 6\r\n\r\nASK{}",
        POST + b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\nASK{}",
        POST + b"Content-Length: -1\r\n\r\n",
        POST + b"Content-Length: " + b"9" * 5000 + b"\r\n\r\n",
        POST + b"Transfer-Encoding: chunked\r\n\r\nzz\r\n",
        POST + b"Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n",
        b"OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"CONNECT localhost:1 HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n",
        b"TRACE /health HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"DELETE /scenes/hans HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer \xff\xfe\r\n\r\n",
    ],
)  # fmt: skip
def test_malformed_requests_are_no_errors_of_the_server(server: Server, text: bytes) -> None:
    with call(server) as end:
        end.sendall(text)
        told = rest(end)
        assert b" 500 " not in told.partition(b"\r\n")[0], told


@pytest.mark.parametrize("module", ["uvicorn", "fastapi", "httptools", "mimeparse"])
def test_without_the_extra_it_says_how_to_get_it(module: str) -> None:
    script = (
        f"import sys; sys.modules[{module!r}] = None; sys.argv = ['deixis', 'serve'];"
        "from deixis.cli import main; sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    remedy = f"deixis: deixis serve needs {module}: pip install 'deixis[server]'\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", remedy)
