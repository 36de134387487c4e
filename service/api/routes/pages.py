"""HTML pages for people: the list of sweeps, a sweep, and the documentation of the API; they work offline."""

import json
import re
import threading
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any

from fastapi import APIRouter, FastAPI, Query, Request, Response
from fastapi.responses import HTMLResponse
from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup, escape

from service import version
from service.api.errors import INTERNAL_ERROR, PROBLEMS
from service.api.routes.dependencies import AppArtifacts, AppStore, SweepId
from service.api.schemas import SweepModel
from service.files.artifacts import Artifacts
from service.records.jobs import Stored
from studies.quantities.display import duration
from studies.quantities.files import REPORT_JSON

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
# Open to callers without a key, because problem documents point there.
docs_router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

ADDRESS = "\0"  # occurs in no text of the page
BUILDING = threading.Lock()  # ``cache`` alone lets every thread that finds nothing build the page
REFRESH_SECONDS = 5  # reload interval of a page that lists unfinished sweeps


@router.get("/")
def show_sweeps(store: AppStore, cursor: Annotated[str | None, Query()] = None) -> str:
    """The sweeps with state, progress and links to report and cube."""
    front = store.sweeps.page_with_files(cursor=cursor)
    page = front.sweeps
    return _rendered(
        "sweeps.html",
        sweeps=[SweepModel.of(row, front.files[row.id]) for row in page.items],
        next_cursor=page.next_cursor,
        queue=front,
        refresh=None if all(row.is_terminal for row in page.items) else REFRESH_SECONDS,
    )


@router.get("/sweeps/{id}")
def show_sweep(id: SweepId, store: AppStore, artifacts: AppArtifacts) -> str:
    """A sweep with the headline of its report."""
    row, names = store.sweeps.get_with_files(id)
    _, report = store.sweeps.get_with_file(id, REPORT_JSON)
    return _rendered(
        "sweep.html",
        sweep=SweepModel.of(row, names),
        headline=_headline(artifacts, report),
        refresh=None if row.is_terminal else REFRESH_SECONDS,
    )


def problem_page(problem: Mapping[str, Any]) -> str:
    """A problem document as a page."""
    return _rendered("problem.html", problem=problem)


def _headline(artifacts: Artifacts, report: Stored | None) -> str:
    """The headline of a report; empty without a report, or in one of an early version."""
    if report is None or not artifacts.is_there(report):
        return ""
    return str(artifacts.read_json(report).get("headline", ""))


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


def _operations(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {**operation, "path": path, "method": method.upper()}
