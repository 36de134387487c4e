"""HTML pages for people: the list of sweeps, a sweep with its orders, log-in, and the documentation of the API.

They work offline, and without scripts: a script only shows a page anew when the service reports a change.
"""

import json
import re
import threading
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, FastAPI, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse
from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup, escape

from service import version
from service.api.access import Caller, Reader, Submitter, key_of
from service.api.browsers import (
    BROWSER,
    SESSION,
    TOKEN_FIELD,
    FormFields,
    check_token,
    cookie,
    new_browser,
    set_cookie,
    token_of,
)
from service.api.errors import INTERNAL_ERROR, PROBLEMS, Unauthorized, problem_response
from service.api.routes import sweeps
from service.api.routes.dependencies import AppArtifacts, AppSettings, AppStore, SweepId
from service.api.schemas import SweepModel
from service.files.artifacts import Artifacts
from service.records.jobs import Scope, Stored, SweepState, SweepStatus
from studies.quantities.display import duration
from studies.quantities.files import REPORT_JSON

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
# Open to callers without a key: to log in, and because problem documents point there.
docs_router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

ADDRESS = "\0"  # occurs in no text of the page
BUILDING = threading.Lock()  # ``cache`` alone lets every thread that finds nothing build the page
UNAUTHORIZED, KEY_WAS_SENT = 401, 'error="invalid_token"'
SEE_OTHER = 303  # an order was carried out: read the page that shows what it did
Order = Literal["cancel", "retry", "delete"]


# ---- sweeps --------------------------------------------------------------------------------------


@router.get("/")
def show_sweeps(
    request: Request, caller: Reader, store: AppStore, cursor: Annotated[str | None, Query()] = None
) -> Response:
    """The sweeps with state, progress and links to report and cube."""
    front = store.sweeps.page_with_files(cursor=cursor)
    page = front.sweeps
    return _page(
        request,
        "sweeps.html",
        caller,
        sweeps=[SweepModel.of(row, front.files[row.id]) for row in page.items],
        next_cursor=page.next_cursor,
        queue=front,
        events="/v1/queue/events",
    )


@router.get("/sweeps/{id}")
def show_sweep(request: Request, id: SweepId, caller: Reader, store: AppStore, artifacts: AppArtifacts) -> Response:
    """A sweep with the headline of its report, and what the caller may do with it."""
    row, names = store.sweeps.get_with_files(id)
    _, report = store.sweeps.get_with_file(id, REPORT_JSON)
    sweep = SweepModel.of(row, names)
    return _page(
        request,
        "sweep.html",
        caller,
        sweep=sweep,
        headline=_headline(artifacts, report),
        orders=_orders(caller, row),
        events=None if row.is_terminal else sweep.links["events"],
    )


def _orders(caller: Caller, sweep: SweepStatus) -> list[Order]:
    """The orders that a caller may give for a sweep in its present state."""
    if not caller.may(Scope.SUBMIT) or not caller.owns(sweep):
        return []
    if not sweep.is_terminal:
        return ["cancel"]
    return ["delete"] if sweep.state == SweepState.SUCCEEDED else ["retry", "delete"]


@router.post("/sweeps/{id}/{order}", dependencies=[Depends(check_token)])
def carry_out(
    id: SweepId, order: Order, caller: Submitter, store: AppStore, settings: AppSettings, artifacts: AppArtifacts
) -> Response:
    """Carry out an order of the page of a sweep, and show the page again; of a deleted one, the list."""
    if order == "delete":
        sweeps.delete_sweep(id, caller, store)
        return RedirectResponse("/", SEE_OTHER)
    if order == "cancel":
        sweeps.cancel_sweep(id, caller, store)
    else:
        sweeps.retry_sweep(id, caller, store, settings, artifacts)
    return RedirectResponse(f"/sweeps/{id}", SEE_OTHER)


def _headline(artifacts: Artifacts, report: Stored | None) -> str:
    """The headline of a report; empty without a report, or in one of an early version."""
    if report is None or not artifacts.is_there(report):
        return ""
    return str(artifacts.read_json(report).get("headline", ""))


# ---- log-in --------------------------------------------------------------------------------------


@docs_router.get("/login")
def show_login(request: Request) -> Response:
    """The form to log in with a key."""
    return _page(request, "login.html", to="/")


@docs_router.post("/login", dependencies=[Depends(check_token)])
def log_in(request: Request, form: FormFields, store: AppStore) -> Response:
    """Log a browser in with a key, and show the page that it asked for; with a wrong key, the form again."""
    try:
        key = key_of(request, form.get("key", "").strip())
    except Unauthorized as error:
        return problem_response(request, error)
    response = RedirectResponse(_own_page(form.get("to", "")), SEE_OTHER)
    set_cookie(request, response, SESSION, store.keys.begin_session(key))
    return response


@docs_router.post("/logout", dependencies=[Depends(check_token)])
def log_out(request: Request, store: AppStore) -> Response:
    """Log the browser out."""
    store.keys.end_session(cookie(request, SESSION))
    response = RedirectResponse("/login", SEE_OTHER)
    set_cookie(request, response, SESSION, "")
    return response


def _own_page(path: str) -> str:
    """A path of this service; the list of sweeps for anything else.

    >>> _own_page("/sweeps/1"), _own_page("//example.org"), _own_page("https://example.org")
    ('/sweeps/1', '/', '/')
    """
    return path if re.fullmatch(r"/[\w/-]*", path) and not path.startswith("//") else "/"


def problem_page(request: Request, problem: Mapping[str, Any], headers: Mapping[str, str]) -> Response:
    """A problem document as a page: where a key is missing, the form to log in with one."""
    status = problem["status"]
    if status != UNAUTHORIZED:
        return _page(request, "problem.html", status=status, headers=headers, problem=problem)
    to = problem["instance"] if request.method == "GET" else "/"
    # A page that is opened from another site comes without our cookie, and with it when it loads itself again.
    again = request.headers.get("sec-fetch-site") == "cross-site"
    wrong = problem if KEY_WAS_SENT in headers["WWW-Authenticate"] else None
    return _page(request, "login.html", status=status, headers=headers, problem=wrong, to=to, again=again)


# ---- documentation -------------------------------------------------------------------------------


@docs_router.get("/docs")
def show_documentation(request: Request) -> str:
    """Every operation of the API with parameters, examples and responses."""
    address = escape(str(request.base_url).rstrip("/"))
    with BUILDING:
        page = _documentation(request.app)
    return page.replace(ADDRESS, address)


@docs_router.get("/openapi.json", response_class=Response)
def show_openapi(request: Request) -> Response:
    """The OpenAPI document."""
    with BUILDING:
        document = _openapi(request.app)
    return Response(document, media_type="application/json")


@cache
def _documentation(app: FastAPI) -> str:
    """The page with ``ADDRESS`` in place of that of the service; rendering it takes 50 ms (2026-11)."""
    return _rendered(
        "docs.html",
        operations=list(_operations(app.openapi())),
        problems=[*PROBLEMS.values(), INTERNAL_ERROR],
        address=ADDRESS,
    )


@cache
def _openapi(app: FastAPI) -> bytes:
    return json.dumps(app.openapi(), ensure_ascii=False).encode()


def code(text: str | None) -> Markup:
    """A description with its `quoted` words as code.

    >>> str(code("see `next_cursor` <here>"))
    'see <code>next_cursor</code> &lt;here&gt;'
    """
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text or ""))))


TEMPLATES = Environment(
    loader=PackageLoader("service.api"), autoescape=select_autoescape(), trim_blocks=True, lstrip_blocks=True
)
TEMPLATES.filters |= {"code": code, "duration": duration, "pretty": lambda value: json.dumps(value, indent=2)}


def _rendered(template: str, **content: Any) -> str:
    return TEMPLATES.get_template(template).render(version=version(), **content)


def _page(
    request: Request,
    template: str,
    caller: Caller | None = None,
    *,
    status: int = 200,
    headers: Mapping[str, str] | None = None,
    **content: Any,
) -> Response:
    """A page whose forms have the token of the browser, which gets its cookie if it has none."""
    browser = cookie(request, BROWSER) or new_browser()
    field = {"name": TOKEN_FIELD, "value": token_of(request, browser)}
    page = _rendered(template, caller=caller, token=field, **content)
    response = HTMLResponse(page, status, headers=dict(headers or {}))
    if not cookie(request, BROWSER):
        set_cookie(request, response, BROWSER, browser)
    return response


def _operations(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {**operation, "path": path, "method": method.upper()}
