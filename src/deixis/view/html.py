"""One file of everything: the page's own text, script and style, and the data, under a strict policy."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import zlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from deixis.errors import MissingDependency

_HERE: Final = Path(__file__).parent / "page"
_BUNDLE: Final = _HERE / "vendor"

PLAIN: Final = 1 << 16
"""Characters of JSON up to which it is left readable; what is larger is deflated."""

_ESCAPES: Final = {ord("<"): "\\u003c", 0x2028: "\\u2028", 0x2029: "\\u2029"}
"""In JSON these stand only in strings: written so, no text ends the element that it is in."""


def available() -> bool:
    """Return whether the script of the page is here."""
    return (_BUNDLE / "view.js").is_file()


def ready() -> None:
    """Raise :class:`MissingDependency` unless the script of the page is here."""
    if not available():
        raise MissingDependency(
            "the page's script is not part of this installation: in a checkout, `make page` adds it"
        )


def page_html(title: str, now: Mapping[str, Any], later: Mapping[str, Any]) -> str:
    """Return the page with its data.

    Parameters
    ----------
    title : str
        Text, whatever is in it.
    now, later : mapping
        Of :func:`deixis.view.page_data`.

    Raises
    ------
    MissingDependency
        The script of the page was not bundled.
    """
    return page_text(title, packed(now), packed(later))


def page_text(title: str, now: str, later: str, *, follows: bool = False) -> str:
    """Return the page with its data, which are packed already; see :func:`page_html`.

    Parameters
    ----------
    title : str
    now, later : str
        Of :func:`packed`.
    follows : bool
        Whether it may ask the server that it comes from for what changed, as ``event`` in the data bids it.
    """
    script, style, licences = _parts()
    page = (_HERE / "view.html").read_text(encoding="utf-8")
    # Split first: what is put in is never looked at again.
    filled = {
        "title": html.escape(title),
        "policy": html.escape(policy_of(follows=follows)),
        "style": style,
        "now": now,
        "later": later,
        "licences": html.escape(licences),
        "script": script,
    }
    first, *rest = page.split("{{")
    return first + "".join(filled[name] + after for name, _, after in (one.partition("}}") for one in rest))


def framed(page: str, height: int = 680) -> str:
    """Return an element that shows a page inside another, which it cannot reach.

    Parameters
    ----------
    page : str
    height : int
        Pixels.
    """
    return (
        f'<iframe sandbox="allow-scripts" srcdoc="{html.escape(page)}" title="Deixis" '
        f'style="width: 100%; height: {height}px; border: 0"></iframe>'
    )


def policy_of(*, follows: bool = False) -> str:
    """Return the page's content security policy: its own script and style by their hashes, and nothing else.

    Nothing can be loaded from anywhere, not even from where the page came from; only a page that follows a
    scene may ask that server for data.
    """
    script, style, _ = _parts()
    asks = "connect-src 'self'; " if follows else ""
    return (
        f"default-src 'none'; script-src {_hash(script)}; style-src {_hash(style)}; {asks}"
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


def packed(data: Mapping[str, Any]) -> str:
    r"""Return data as the text of a script element: JSON, or a JSON string of it deflated, in base 64.

    Examples
    --------
    >>> packed({"label": "</script>"})
    '{"label":"\\u003c/script>"}'
    """
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    if len(text) > PLAIN:
        squeezer = zlib.compressobj(9, zlib.DEFLATED, -15)
        deflated = squeezer.compress(text.encode()) + squeezer.flush()
        return json.dumps(base64.b64encode(deflated).decode())
    return text.translate(_ESCAPES)


@cache
def _parts() -> tuple[str, str, str]:
    """Return script, style and licences."""
    ready()
    script = (_BUNDLE / "view.js").read_text(encoding="utf-8")
    # A script that says so itself would end its own element; esbuild writes it as <\/script.
    if "</script" in script.lower() or "<!--" in script:
        raise MissingDependency("the page's script cannot be inlined: run `make page` again")
    style = (_HERE / "view.css").read_text(encoding="utf-8")
    return script, style, (_BUNDLE / "LICENSES.txt").read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
