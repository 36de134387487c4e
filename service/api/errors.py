"""Errors as HTTP: one table from exception to status, one format of response (RFC 9457).

Errors that only a request has enter the table by themselves. Any other exception is a 500 that hides its text; the log
has it under the id of the request.
"""

import json
import logging
from collections.abc import Mapping
from dataclasses import asdict, astuple, dataclass
from http import HTTPStatus
from types import MappingProxyType

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from pydantic import JsonValue
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import Match

from service.files.stores import FilesAway
from service.records.jobs import Conflict, KeyReused, NotFound, QuotaExceeded, StoreUnavailable
from solver.errors import WhippleError
from studies.quantities.findings import MOST_FINDINGS, Finding, InvalidInput, shown

log = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
PROBLEM = {
    "description": "A problem document (RFC 9457)",
    "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}},
}
METHODS = ("DELETE", "GET", "HEAD", "PATCH", "POST", "PUT")
MOST_FINDING_BYTES = 48_000  # the summary repeats the first finding; the whole response is below 64 kB
LONGEST_PART = 1_500  # characters of a field, value, limit or cure; a cure that lists names has about a thousand

# Pages load style sheet, scripts and frames of the service only; the report, which the page of its sweep shows in a
# frame, sets a policy of its own.
PAGE_POLICY = (
    "default-src 'none'; style-src 'self'; script-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "frame-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'"
)
# Other responses display and execute nothing if a browser takes them for a page.
OTHER_POLICY = "default-src 'none'; frame-ancestors 'none'; sandbox"
SECURITY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",  # files set a value of their own
}


@dataclass(frozen=True)
class ProblemDetails:
    """A kind of problem: its status, its title, and what it means."""

    status: int
    title: str
    meaning: str
    retry_after: int | None = None  # s; a repeated request may succeed

    @property
    def slug(self) -> str:
        """The stable end of the ``type`` URI."""
        return self.title.lower().replace(" ", "-")

    @property
    def type(self) -> str:
        """URI of the kind, which the documentation page explains; that of none for an error of HTTP alone."""
        return f"/docs#problem-{self.slug}" if self.meaning else "about:blank"


INTERNAL_ERROR = ProblemDetails(
    500, "Internal error", "An unexpected error occurred; the log of the service has the error under `request_id`."
)
PROBLEMS: dict[type[Exception], ProblemDetails] = {
    InvalidInput: ProblemDetails(
        422, "Invalid input", "The input is refused, and nothing was stored. `errors` lists each error."
    ),
    NotFound: ProblemDetails(404, "Not found", "There is no sweep, run or file of this name."),
    Conflict: ProblemDetails(409, "Conflict", "The state of the sweep does not allow this operation."),
    KeyReused: ProblemDetails(
        422, "Idempotency key reused", "This `Idempotency-Key` belongs to a different request; nothing was stored."
    ),
    QuotaExceeded: ProblemDetails(
        429,
        "Quota exceeded",
        "The owner has as much under way, or as many bytes of files, as a key may have; nothing was stored.",
    ),
    # For the log and the metrics: its sender is gone.
    ClientDisconnect: ProblemDetails(400, "Incomplete request", "The connection ended before the body did."),
    FilesAway: ProblemDetails(
        503, "Bucket unavailable", "The bucket that has the file cannot be used; nothing was changed.", retry_after=10
    ),
    StoreUnavailable: ProblemDetails(
        503, "Database unavailable", "The database is locked, unreachable or full; nothing was changed.", retry_after=2
    ),
}


class RequestError(WhippleError):
    """An error that only a request has; the docstring of each kind is its meaning in the documentation."""

    def __init__(self, text: str, headers: Mapping[str, str] = MappingProxyType({})):
        super().__init__(text)
        self.headers = headers  # of the response

    def __init_subclass__(cls, *, status: int, title: str, retry_after: int | None = None):
        assert cls.__doc__
        PROBLEMS[cls] = ProblemDetails(status, title, " ".join(cls.__doc__.split()), retry_after)


class NotReady(RequestError, status=409, title="Not ready", retry_after=2):
    """The file will exist once the sweep has ended."""


class PayloadTooLarge(RequestError, status=413, title="Payload too large"):
    """The request body exceeds the size limit."""


class PreconditionFailed(RequestError, status=412, title="Precondition failed"):
    """The file has changed since the copy that `If-Match` names."""


class Unauthorized(RequestError, status=401, title="Unauthorized"):
    """This request needs a valid API key."""

    def __init__(self, text: str, *, key_was_sent: bool):
        error = ', error="invalid_token"' if key_was_sent else ""
        super().__init__(text, {"WWW-Authenticate": f'Bearer realm="whipple"{error}'})


class TooManyWrongKeys(Unauthorized, status=429, title="Too many wrong keys"):
    """This address has sent many keys that are unknown, revoked or expired; a valid key is served meanwhile."""

    def __init__(self, seconds: int):
        super().__init__("wait, and send a valid key; the operator of the service makes one", key_was_sent=True)
        self.headers = {**self.headers, "Retry-After": str(seconds)}


class Forbidden(RequestError, status=403, title="Forbidden"):
    """The API key lacks the scope that this request needs."""

    def __init__(self, text: str, *, scope: str):
        error = f'error="insufficient_scope", scope="{scope}"'
        super().__init__(text, {"WWW-Authenticate": f'Bearer realm="whipple", {error}'})


class ConversionFailed(RequestError, status=500, title="Conversion failed"):
    """The file, which is made when it is asked for, could not be made."""


class NotAvailable(RequestError, status=501, title="Not available"):
    """This service lacks what it takes to make the file; `detail` says what its operator can install."""


class FileDamaged(RequestError, status=500, title="File damaged"):
    """The file on the disk is not the one that was registered."""


class Busy(RequestError, status=503, title="Service busy", retry_after=5):
    """The maximum number of clients is using this resource."""


class TooManyRequests(RequestError, status=429, title="Too many requests", retry_after=5):
    """This key, or all keys together, have as much under way as the service allows; send the request again."""


class ReaderLost(RequestError, status=503, title="Reader lost", retry_after=2):
    """The process that read the sweep ended before it was done; nothing was stored."""


class UnsupportedMediaType(RequestError, status=415, title="Unsupported media type"):
    """This operation does not read bodies of this media type, or in this coding."""


class BadRequest(RequestError, status=400, title="Bad request"):
    """The request violates HTTP and is ambiguous."""


class MisdirectedRequest(RequestError, status=421, title="Misdirected request"):
    """The Host header names another host than this service."""


class CrossSiteRequest(RequestError, status=403, title="Cross-site request"):
    """Pages of other sites may not change anything here."""


class ServiceNotReady(RequestError, status=503, title="Service not ready", retry_after=2):
    """The service cannot compute at the moment; `detail` says why."""


def install(app: FastAPI) -> None:
    """Make the app respond to every error with a problem document."""
    for kind in PROBLEMS:
        app.add_exception_handler(kind, _respond_problem)
    app.add_exception_handler(HTTPException, _respond_http)
    app.add_exception_handler(RequestValidationError, _respond_validation)
    app.add_exception_handler(Exception, _respond_unexpected)


def problem_response(request: Request, error: Exception) -> Response:
    """The problem document for an exception of the table, or of a subclass."""
    problem = next(PROBLEMS[kind] for kind in type(error).__mro__ if kind in PROBLEMS)
    if isinstance(error, InvalidInput):
        return _response(request, problem, _summary(error), _errors(error))
    headers = error.headers if isinstance(error, RequestError) else {}
    if isinstance(error, QuotaExceeded):
        headers = {"Retry-After": str(error.seconds)}
    return _response(request, problem, str(error), headers=headers)


async def _respond_problem(request: Request, error: Exception) -> Response:
    return problem_response(request, error)


async def _respond_validation(request: Request, error: Exception) -> Response:
    """Report what the framework found in a query parameter or a path."""
    assert isinstance(error, RequestValidationError)
    findings = [
        Finding(
            ".".join(map(str, item["loc"])), shown(item.get("input")), item["msg"], "see /docs for the allowed values"
        )
        for item in error.errors()
    ]
    return problem_response(request, InvalidInput(findings))


async def _respond_http(request: Request, error: Exception) -> Response:
    """Report an error of the framework itself: unknown route, wrong method."""
    assert isinstance(error, HTTPException)
    status, headers = HTTPStatus(error.status_code), dict(error.headers or {})
    if status is HTTPStatus.METHOD_NOT_ALLOWED:  # the framework lists the methods of one route only
        headers["Allow"] = ", ".join(_methods(request))
    return _response(request, ProblemDetails(status, status.phrase, ""), error.detail, headers=headers)


def _methods(request: Request) -> list[str]:
    """The methods of a path, over all of its routes; HEAD is wherever GET is (``middleware.Heads``)."""
    routed = {
        method
        for method in METHODS
        if any(route.matches({**request.scope, "method": method})[0] is Match.FULL for route in request.app.routes)
    }
    return [method for method in METHODS if method in routed or (method == "HEAD" and "GET" in routed)]


async def _respond_unexpected(request: Request, error: Exception) -> Response:
    request_id = request.state.request_id
    log.error("request %s failed", request_id, exc_info=error, extra={"request_id": request_id})
    return _response(request, INTERNAL_ERROR, "the log of the service has the error under this request_id")


def _response(
    request: Request,
    problem: ProblemDetails,
    detail: str,
    extra: Mapping[str, JsonValue] = MappingProxyType({}),
    *,
    headers: Mapping[str, str] = MappingProxyType({}),
) -> Response:
    request_id = request.state.request_id
    body: dict[str, JsonValue] = {"type": problem.type, "title": problem.title, "detail": detail, **extra}
    body |= {"status": problem.status, "instance": request.url.path, "request_id": request_id}
    again = {} if problem.retry_after is None else {"Retry-After": str(problem.retry_after)}
    headers = {**again, **headers, "X-Request-ID": request_id, "Vary": "Accept"}
    page = request.app.state.problem_page
    if page is not None and "text/html" in request.headers.get("accept", ""):  # a browser that opens an address
        response: Response = page(request, problem.status, body, headers)
    else:  # ASCII escapes can carry the lone surrogates that an input may contain
        response = Response(json.dumps(body), problem.status, headers, MEDIA_TYPE)
    add_security_headers(response.headers)  # the response to an unexpected error passes no other middleware
    return response


def add_security_headers(headers: MutableHeaders) -> None:
    """Add what a browser may do with a response, where the response does not say it itself."""
    for name, value in SECURITY_HEADERS.items():
        headers.setdefault(name, value)
    is_page = headers.get("content-type", "").startswith("text/html")
    headers.setdefault("Content-Security-Policy", PAGE_POLICY if is_page else OTHER_POLICY)


def _summary(error: InvalidInput) -> str:
    first, *others = error.findings
    if not others:
        return str(_shortened(first))
    stopped = "; the rest of the input was not read" if len(error.findings) == MOST_FINDINGS else ""
    return f"{_shortened(first)} (and {len(others)} more, see errors{stopped})"


def _errors(error: InvalidInput) -> dict[str, JsonValue]:
    """The first errors, each with its JSON pointer, and the number of errors left out."""
    errors: list[JsonValue] = []
    size = 0
    for finding in map(_shortened, error.findings):
        item = {**asdict(finding), "pointer": error.pointers.get(finding.field, "")}
        size += len(json.dumps(item))
        if size > MOST_FINDING_BYTES:
            break
        errors.append(item)
    left = len(error.findings) - len(errors)
    return {"errors": errors, **({"more_errors": left} if left else {})}


def _shortened(finding: Finding) -> Finding:
    return Finding(*(text[:LONGEST_PART] for text in astuple(finding)))
