"""What goes wrong, as HTTP says it: a status, and a body of RFC 9457 that names the thing and the remedy."""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus
from typing import Final

from fastapi.routing import APIRoute
from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.routing import Match, Route

from deixis import errors
from deixis.hints import either
from deixis.rdf.evaluator import Refused, TooLarge
from deixis.server.children import Lost
from deixis.server.screening import Forbidden


class Problem(errors.DeixisError):
    """A request that is answered with a status of its own."""

    def __init__(self, status: int, detail: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(detail)
        self.status, self.headers = status, dict(headers or {})


class Overloaded(errors.DeixisError):
    """There are more questions than this server answers at the same time."""


class Gone(errors.DeixisError):
    """The client did not wait for the answer."""


_STATUS: Final[tuple[tuple[type[Exception], int], ...]] = (
    (Forbidden, 403),
    (Refused, 409),
    (TooLarge, 413),
    (Overloaded, 429),
    (Gone, 499),
    (errors.QueryTimeout, 503),
    (Lost, 503),
    (errors.QueryError, 400),
    (errors.SceneError, 400),
    (errors.GeometryError, 400),
    (errors.RuleError, 400),
    (errors.ThresholdError, 400),
    (errors.DeixisError, 500),
)

_TYPES: Final = ((errors.QueryTimeout, "timeout"), (Lost, "lost"), (Overloaded, "overloaded"))
"""What a program may want to tell apart."""

_NAMED: Final[dict[str, type[errors.DeixisError]]] = {
    kind.__name__: kind for kind, _ in _STATUS if issubclass(kind, errors.DeixisError)
}

_METHODS: Final = ("GET", "HEAD", "POST", "PUT", "DELETE")

_AFTER: Final = {429: {"Retry-After": "1"}, 503: {"Retry-After": "5"}}


def raised(name: str, text: str) -> errors.DeixisError:
    """Return the error that a child told of."""
    if name == "MemoryError":
        return Lost("the question took more memory than the limit: ask for less")
    return _NAMED.get(name, errors.EngineError)(text)


def response(error: Exception) -> JSONResponse:
    """Return the answer to a request that ended with an error."""
    if isinstance(error, Problem):
        return problem(error.status, str(error), error.headers)
    status = next(status for kind, status in _STATUS if isinstance(error, kind))
    named = (name for kind, name in _TYPES if isinstance(error, kind))
    return problem(status, str(error), _AFTER.get(status), next(named, ""))


def not_allowed(request: Request) -> JSONResponse:
    """Return that a path takes other methods: all of them, and what is sent with the first."""
    routes = [
        route
        for route in request.app.state.listed
        if isinstance(route, Route) and route.matches(request.scope)[0] is not Match.NONE
    ]
    methods = [one for one in _METHODS if any(one in (route.methods or ()) for route in routes)]
    told = [one for one in methods if one != "HEAD"]
    detail = f"{request.url.path} takes {either(told)}, not {request.method}"
    if len(told) == 1:
        detail = f"{told[0]} it{_sent_with(routes[0])}: {detail}"
    return problem(405, detail, {"Allow": ", ".join(methods)})


def _sent_with(route: Route) -> str:
    """Return what a route of the JSON interface needs beside its path."""
    if not isinstance(route, APIRoute):
        return ""
    needed = [one.alias for one in route.dependant.query_params if one.field_info.is_required()]
    if needed:
        return f", with ?{'&'.join(f'{name}=...' for name in needed)}"
    return ", with JSON in the body" if "requestBody" in (route.openapi_extra or {}) else ""


def problem(
    status: int, detail: str, headers: Mapping[str, str] | None = None, kind: str = ""
) -> JSONResponse:
    """Return a problem as a response."""
    title = HTTPStatus(status).phrase if status in list(HTTPStatus) else "Client Closed Request"
    body = {"title": title, "status": status, "detail": detail}
    if kind:
        body = {"type": f"urn:deixis:problem:{kind}", **body}
    return JSONResponse(body, status, dict(headers or {}), media_type="application/problem+json")
