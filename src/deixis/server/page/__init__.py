"""The query page: YASGUI from this server alone, under a policy that lets it load nothing from elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from starlette.requests import Request
from starlette.responses import FileResponse, Response

from deixis.server.problems import Problem

_HERE: Final = Path(__file__).parent

_FILES: Final = {
    "": ("query.html", "text/html"),
    "query.css": ("query.css", "text/css"),
    "query.js": ("query.js", "text/javascript"),
    "examples.json": ("examples.json", "application/json"),
    "vendor/yasgui.min.js": ("vendor/yasgui.min.js", "text/javascript"),
    "vendor/yasgui.min.css": ("vendor/yasgui.min.css", "text/css"),
    "vendor/LICENSES.txt": ("vendor/LICENSES.txt", "text/plain"),
}
"""All there is, by its address: no path of a client's leads into the file system."""

# Styles of elements are set by the editor itself; scripts come from files only.
_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "font-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


async def page(request: Request) -> Response:
    """Return a file of the query page."""
    found = _FILES.get(request.path_params.get("file", ""))
    if found is None:
        raise Problem(404, "the query page has no such file")
    name, media = found
    if not (_HERE / "vendor" / "yasgui.min.js").exists():
        raise Problem(
            404, "the query page is not part of this installation: in a checkout, `make page` adds it"
        )
    return FileResponse(_HERE / name, media_type=media, headers={"Content-Security-Policy": _POLICY})
