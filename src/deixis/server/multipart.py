"""Forms of several files (multipart/form-data, RFC 7578): the Graph Store Protocol takes graphs so."""

from __future__ import annotations

import re
from typing import Final

from deixis.server.problems import Problem

_MOST_PARTS: Final = 100

_BOUNDARY: Final = re.compile(r';\s*boundary=(?:"([^"\r\n]{1,70})"|([\w\'()+,\-./:=?]{1,70}))', re.IGNORECASE)


def parts_of(body: bytes, content_type: str) -> list[tuple[str, bytes]]:
    r"""Return Content-Type and content of each part.

    Raises
    ------
    Problem
        The form is not well formed, or has too many parts.

    Examples
    --------
    >>> form = b'--x\r\nContent-Type: text/turtle\r\n\r\n<urn:a> a <urn:b> .\r\n--x--\r\n'
    >>> parts_of(form, "multipart/form-data; boundary=x")
    [('text/turtle', b'<urn:a> a <urn:b> .')]
    """
    found = _BOUNDARY.search(content_type)
    if found is None:
        raise Problem(400, "multipart/form-data needs a boundary: say so in Content-Type")
    mark = b"\r\n--" + (found[1] or found[2]).encode()
    before, *rest = (b"\r\n" + body).split(mark, _MOST_PARTS + 2)
    if len(rest) > _MOST_PARTS + 1:
        raise Problem(400, f"the form has more than {_MOST_PARTS} parts: send fewer at a time")
    if before.strip() or not rest or not rest[-1].startswith(b"--"):
        raise Problem(400, "the form is not well formed: it ends before its last boundary")
    return [_part(one) for one in rest[:-1]]


def _part(text: bytes) -> tuple[str, bytes]:
    # After the boundary the line may hold spaces; then come headers, an empty line, and the content.
    head, empty, content = text.partition(b"\r\n\r\n")
    if not empty:
        raise Problem(400, "a part of the form has no empty line between its headers and its content")
    for line in head.split(b"\r\n")[1:]:
        name, _, value = line.partition(b":")
        if name.strip().lower() == b"content-type":
            return value.strip().decode("latin-1"), content
    raise Problem(400, "a part of the form has no Content-Type: say text/turtle")
