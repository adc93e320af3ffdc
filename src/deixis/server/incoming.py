"""Requests read with bounds: how much, how long, in which encoding, and by whom."""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Sequence
from typing import Final
from urllib.parse import parse_qsl

from starlette.requests import ClientDisconnect, Request

from deixis.server.problems import Gone, Problem
from deixis.server.settings import Settings

Fields = Sequence[tuple[str, str]]

_LINGER: Final = 4 << 20
"""Bytes of a body that is too large which are read and forgotten all the same."""

_LINGER_SECONDS: Final = 5.0
"""How long that may take."""


async def body_of(request: Request, settings: Settings, most: int | None = None) -> bytes:
    """Return what was sent: at most so many bytes, by default the server's limit.

    Raises
    ------
    Problem
        It is too large (413), comes too slowly (408) or is compressed (415).
    """
    limits = settings.limits
    most = limits.body if most is None else most
    if request.headers.get("content-encoding", "identity") != "identity":
        raise Problem(415, "send it without Content-Encoding: compressed bodies are not read")
    too_large = Problem(413, f"the body is larger than {most} bytes: send less", {"Connection": "close"})
    declared = request.headers.get("content-length", "0")
    if not declared.isascii() or not declared.isdigit() or int(declared[:20]) > most:
        if declared.isascii() and declared.isdigit() and int(declared[:20]) <= _LINGER:
            await _forget(request)
        raise too_large
    parts, size = [], 0
    try:
        async with asyncio.timeout(limits.upload_seconds):
            async for part in request.stream():
                size += len(part)
                if size > most:
                    raise too_large
                parts.append(part)
    except TimeoutError:
        message = f"the body did not come within {limits.upload_seconds:g} s"
        raise Problem(408, message, {"Connection": "close"}) from None
    except ClientDisconnect:
        raise Gone("the client closed the connection") from None
    return b"".join(parts)


async def _forget(request: Request) -> None:
    """Read what is still being sent: a client that is cut off in mid-sentence does not read the answer."""
    left = _LINGER
    try:
        async with asyncio.timeout(_LINGER_SECONDS):
            async for part in request.stream():
                left -= len(part)
                if left < 0:
                    return
    except (TimeoutError, ClientDisconnect):
        return


def media_of(request: Request) -> str:
    """Return the media type of what was sent, or the empty string.

    Raises
    ------
    Problem
        Its character set is not UTF-8 (415).
    """
    return media_type(request.headers.get("content-type", ""))


def media_type(content_type: str) -> str:
    """Return the media type that a Content-Type names; see :func:`media_of`."""
    media, _, rest = content_type.partition(";")
    for parameter in rest.split(";"):
        name, _, value = parameter.strip().partition("=")
        if name.lower() == "charset" and value.strip('"').lower() not in ("utf-8", "utf8"):
            raise Problem(415, f"the character set {value[:40]!r} is not read: send UTF-8")
    return media.strip().lower()


def text_of(data: bytes) -> str:
    """Return bytes as text, or raise :class:`Problem` where they are none."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Problem(400, f"byte {error.start} is no UTF-8: send UTF-8") from None


def fields_of(data: bytes) -> Fields:
    """Return the fields of a form or of a query string, in order."""
    try:
        return parse_qsl(
            data.decode("ascii", "strict"), keep_blank_values=True, errors="strict", max_num_fields=100
        )
    except ValueError:
        raise Problem(400, "the parameters are not well formed: percent-encode them as UTF-8") from None


def must_show_token(request: Request, settings: Settings) -> None:
    """Raise :class:`Problem` unless the client has the token."""
    if settings.token is None:
        raise Problem(403, "this server changes nothing: start it with a token to allow it")
    scheme, _, shown = request.headers.get("authorization", "").partition(" ")
    right = hmac.compare_digest(shown.strip().encode(), settings.token.encode())
    if scheme.lower() != "bearer" or not right:
        raise Problem(
            401,
            "changing anything needs the token: Authorization: Bearer TOKEN",
            {"WWW-Authenticate": "Bearer"},
        )


def must_be_writable(request: Request, settings: Settings) -> None:
    """Raise :class:`Problem` unless graphs can be written, and by this client."""
    if not settings.writable:
        raise Problem(403, "this server is read-only: start it with --writable to allow updates")
    must_show_token(request, settings)
