"""What goes wrong, as HTTP: one table from exception to status, one shape of answer (RFC 9457).

Domain code raises exceptions that carry meaning and knows nothing of the web. Here each becomes an
``application/problem+json`` document; an exception that is not in the table is a 500 that says
nothing of its text, which goes to the log together with the request's id.
"""

import json
import logging
import re
from collections.abc import Mapping
from dataclasses import asdict, astuple, dataclass
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from service.records.jobs import Conflict, KeyReused, NotFound, StoreUnavailable
from solver.errors import WhippleError
from studies.values.errors import MOST_FINDINGS, Finding, InvalidInput
from studies.values.nearest import shown

log = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
MOST_TOLD = 50  # findings in one answer
LONGEST_TOLD = (
    48_000  # bytes of them; with one of them again as the summary an answer has less than 64 kB
)
LONGEST_PART = (
    1_500  # characters of a field, a limit, a cure: one that lists names has about a thousand
)


class BodyTooLarge(WhippleError):
    """A body is longer than the service accepts."""


class UnsupportedMediaType(WhippleError):
    """A body is of a media type that is not read here."""


class NotReady(WhippleError):
    """A file will be there later."""


class ServiceNotReady(WhippleError):
    """The service answers, but cannot do its work now."""


class Changed(WhippleError):
    """A file is asked for as it was, and it is another now."""

    def __init__(self) -> None:
        super().__init__("the file is not the one that If-Match names; ask again without it")


class Busy(WhippleError):
    """So many already ask for this that one more would only make all of them slower."""


class PartialCubeFailed(WhippleError):
    """The cube of a sweep that has not ended could not be made."""


class NoKey(WhippleError):
    """Who is asking has not said who it is, or not with a key that is valid."""

    def __init__(self, text: str, *, given: bool):
        super().__init__(text)
        words = ', error="invalid_token"' if given else ""
        self.headers = {"WWW-Authenticate": f'Bearer realm="whipple"{words}'}


class NotAllowed(WhippleError):
    """Who is asking is known, and may not do this."""

    def __init__(self, text: str, *, scope: str):
        super().__init__(text)
        words = f'error="insufficient_scope", scope="{scope}"'
        self.headers = {"WWW-Authenticate": f'Bearer realm="whipple", {words}'}


class Malformed(WhippleError):
    """A request breaks a rule of HTTP, so that nobody knows what it means."""


class ForeignHost(WhippleError):
    """A request names a host that this service does not answer to (DNS rebinding)."""


class CrossSite(WhippleError):
    """A page of another site tried to change something here."""


@dataclass(frozen=True)
class ProblemDetails:
    """A kind of problem: its status, and the words that stay the same each time it occurs."""

    status: HTTPStatus
    slug: str  # end of the ``type`` URI, stable
    title: str
    retry_after: int | None = None  # s; asking again may succeed

    @property
    def type(self) -> str:
        """URI of the kind, which the documentation page explains."""
        return f"/docs#problem-{self.slug}"


PROBLEMS: Mapping[type[Exception], ProblemDetails] = {
    InvalidInput: ProblemDetails(
        HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-input", "The input is refused; nothing was stored"
    ),
    NotFound: ProblemDetails(HTTPStatus.NOT_FOUND, "not-found", "There is no such thing"),
    NotReady: ProblemDetails(
        HTTPStatus.CONFLICT, "not-ready", "The file is not there yet", retry_after=2
    ),
    Conflict: ProblemDetails(HTTPStatus.CONFLICT, "conflict", "The state does not allow this"),
    BodyTooLarge: ProblemDetails(
        HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "body-too-large", "The body is too long"
    ),
    Changed: ProblemDetails(
        HTTPStatus.PRECONDITION_FAILED, "changed", "The file is another one now"
    ),
    KeyReused: ProblemDetails(
        HTTPStatus.UNPROCESSABLE_ENTITY,
        "idempotency-key-reused",
        "This Idempotency-Key belongs to another request; nothing was stored",
    ),
    NoKey: ProblemDetails(HTTPStatus.UNAUTHORIZED, "no-key", "This needs a valid API key"),
    NotAllowed: ProblemDetails(HTTPStatus.FORBIDDEN, "not-allowed", "This API key may not do that"),
    PartialCubeFailed: ProblemDetails(
        HTTPStatus.INTERNAL_SERVER_ERROR,
        "partial-cube-failed",
        "The partial cube could not be made",
    ),
    Busy: ProblemDetails(
        HTTPStatus.SERVICE_UNAVAILABLE, "busy", "Too many ask for this at once", 5
    ),
    UnsupportedMediaType: ProblemDetails(
        HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
        "unsupported-media-type",
        "The body is of another media type",
    ),
    Malformed: ProblemDetails(
        HTTPStatus.BAD_REQUEST, "malformed", "The request breaks a rule of HTTP"
    ),
    # For the log and the metrics: whoever sent it is gone.
    ClientDisconnect: ProblemDetails(
        HTTPStatus.BAD_REQUEST, "incomplete", "The connection ended before the body did"
    ),
    ForeignHost: ProblemDetails(
        HTTPStatus.MISDIRECTED_REQUEST, "foreign-host", "This host name is not answered to"
    ),
    CrossSite: ProblemDetails(
        HTTPStatus.FORBIDDEN, "cross-site", "Another site may not change anything"
    ),
    StoreUnavailable: ProblemDetails(
        HTTPStatus.SERVICE_UNAVAILABLE, "store-unavailable", "The store does not answer", 2
    ),
    ServiceNotReady: ProblemDetails(
        HTTPStatus.SERVICE_UNAVAILABLE, "service-not-ready", "The service is not ready", 2
    ),
}
INTERNAL = ProblemDetails(
    HTTPStatus.INTERNAL_SERVER_ERROR, "internal", "Something unforeseen went wrong here"
)


def install(app: FastAPI) -> None:
    """Make the app answer every error with a problem document."""
    for kind in PROBLEMS:
        app.add_exception_handler(kind, _answer_known)
    app.add_exception_handler(HTTPException, _answer_http)
    app.add_exception_handler(RequestValidationError, _answer_validation)
    app.add_exception_handler(Exception, _answer_unforeseen)


def answer(request: Request, error: Exception) -> Response:
    """The problem document for an exception of the table, or of a kind derived from one."""
    problem = next(PROBLEMS[kind] for kind in type(error).__mro__ if kind in PROBLEMS)
    if isinstance(error, InvalidInput):
        return _document(request, problem, _summary(error), _errors(request, error))
    response = _document(request, problem, str(error))
    response.headers.update(getattr(error, "headers", {}))
    return response


async def _answer_known(request: Request, error: Exception) -> Response:
    return answer(request, error)


async def _answer_validation(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    return answer(request, InvalidInput(_finding(one) for one in error.errors()))


async def _answer_http(request: Request, error: Exception) -> Response:
    """An error of the framework itself: unknown route, wrong method."""
    assert isinstance(error, HTTPException)
    status = HTTPStatus(error.status_code)
    body = {"type": "about:blank", "title": status.phrase, "status": status, "detail": error.detail}
    return _response(request, body, dict(error.headers or {}))


async def _answer_unforeseen(request: Request, error: Exception) -> Response:
    request_id = request.state.request_id
    log.error("request %s failed", request_id, exc_info=error, extra={"request_id": request_id})
    return _document(request, INTERNAL, "the log of the service has it under this request_id")


def _document(
    request: Request, problem: ProblemDetails, detail: str, more: Mapping[str, Any] | None = None
) -> Response:
    body: dict[str, Any] = {
        "type": problem.type,
        "title": problem.title,
        "status": problem.status,
        "detail": detail,
        **(more or {}),
    }
    headers = {} if problem.retry_after is None else {"Retry-After": str(problem.retry_after)}
    return _response(request, body, headers)


def _response(request: Request, body: dict[str, Any], headers: dict[str, str]) -> Response:
    request_id = request.state.request_id
    body |= {"instance": request.url.path, "request_id": request_id}
    headers |= {"X-Request-ID": request_id, "X-Content-Type-Options": "nosniff"}
    # In ASCII, because half a character of what was sent can be told in no other way.
    return Response(json.dumps(body), body["status"], headers, MEDIA_TYPE)


def _summary(error: InvalidInput) -> str:
    first, *others = error.findings
    if not others:
        return str(_shortened(first))
    stopped = "; the rest was not read" if len(error.findings) == MOST_FINDINGS else ""
    return f"{_shortened(first)} (and {len(others)} more, see errors{stopped})"


def _errors(request: Request, error: InvalidInput) -> dict[str, Any]:
    """The first findings, each with its place in the document, and how many more there were."""
    document = getattr(request.state, "document", None)
    told: list[dict[str, str]] = []
    size = 0
    for finding in map(_shortened, error.findings[:MOST_TOLD]):
        one = {**asdict(finding), "pointer": pointer(finding.field, document)}
        size += len(json.dumps(one))
        if size > LONGEST_TOLD:
            break
        told.append(one)
    left = len(error.findings) - len(told)
    return {"errors": told, **({"more_errors": left} if left else {})}


def _shortened(finding: Finding) -> Finding:
    return Finding(*(text[:LONGEST_PART] for text in astuple(finding)))


def _finding(error: Mapping[str, Any]) -> Finding:
    """A finding of the framework (a query parameter, a path) in our own words."""
    place = ".".join(str(part) for part in error["loc"])
    return Finding(place, shown(error.get("input")), error["msg"], "see /docs for what is allowed")


def pointer(field: str, document: object) -> str:
    """The JSON pointer (RFC 6901) of the deepest part of ``document`` that a finding's field names.

    >>> pointer("axes.speed[1]", {"axes": {"speed": ["2 km/s", "6"]}})
    '/axes/speed/1'
    >>> pointer("fixed.target.strength.A", {"fixed": {"target.strength.A": 100}})
    '/fixed/target.strength.A'
    >>> pointer("fixed.speed", {"fixed": {}})
    '/fixed'
    """
    found, rest, here = "", field, document
    while rest:
        step = _step(rest, here)
        if step is None:
            break
        key, length = step
        here = here[key]  # type: ignore[index]
        found += "/" + str(key).replace("~", "~0").replace("/", "~1")
        rest = rest[length:].removeprefix(".")
    return found


def _step(path: str, here: object) -> tuple[Any, int] | None:
    """The key at the begin of ``path`` that ``here`` has, the longest if several, and its length."""
    if isinstance(here, list) and (match := re.match(r"\[(\d{1,9})\]", path)):
        index = int(match[1])
        return (index, match.end()) if index < len(here) else None
    if isinstance(here, Mapping):
        ends = [len(path), *(match.start() for match in re.finditer(r"[.[]", path))]
        lengths = sorted((end for end in ends if end and path[:end] in here), reverse=True)
        return next(((path[:length], length) for length in lengths), None)
    return None
