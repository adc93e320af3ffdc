"""Messages between the server and its children: a header in JSON and a body of bytes.

Each begins with two lengths of four bytes, big-endian. A file descriptor may come with the first byte.
"""

from __future__ import annotations

import json
import os
import socket
import struct
from collections.abc import Mapping
from typing import Any, Final

LENGTHS: Final = struct.Struct(">II")
"""Of the header and of the body, bytes."""

_BLOCK: Final = 1 << 18


def packed(header: Mapping[str, Any], body: bytes = b"") -> bytes:
    r"""Return a message as bytes.

    Examples
    --------
    >>> packed({"do": "end"}, b"!")
    b'\x00\x00\x00\r\x00\x00\x00\x01{"do": "end"}!'
    """
    text = json.dumps(header).encode()
    return LENGTHS.pack(len(text), len(body)) + text + body


class Closed(Exception):
    """The other side is gone."""


class Channel:
    """A child's end of a socket: one message is read, answered, and then the next.

    Parameters
    ----------
    end : socket
    """

    def __init__(self, end: socket.socket) -> None:
        self.end = end
        self._buffer = bytearray()
        self._descriptors: list[int] = []

    def receive(self) -> tuple[dict[str, Any], bytes, int | None]:
        """Return the next header and body, and the descriptor that came with them.

        Raises
        ------
        Closed
            There is no next.
        """
        head, size = LENGTHS.unpack(self._take(LENGTHS.size))
        header = json.loads(self._take(head))
        body = self._take(size)
        return header, body, self._descriptors.pop() if self._descriptors else None

    def send(self, header: Mapping[str, Any], body: bytes = b"") -> None:
        """Send one message."""
        self.end.sendall(packed(header, body))

    def close(self) -> None:
        """Give up the socket and what came unasked for."""
        self.end.close()
        while self._descriptors:
            os.close(self._descriptors.pop())

    def _take(self, size: int) -> bytes:
        while len(self._buffer) < size:
            data, descriptors, _, _ = socket.recv_fds(self.end, _BLOCK, 1)
            self._descriptors += descriptors
            if not data:
                raise Closed
            self._buffer += data
        taken = bytes(self._buffer[:size])
        del self._buffer[:size]
        return taken
