"""Plain pages for people: the sweeps, and the interface described, both without any network."""

import json
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse
from jinja2 import Environment, PackageLoader, select_autoescape

from service.errors import INTERNAL, PROBLEMS
from service.routes.given import StoreGiven
from service.schemas import SweepModel
from service.version import version

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

REFRESH = 5  # s; a page with unfinished sweeps loads itself again
TEMPLATES = Environment(
    loader=PackageLoader("service"),
    autoescape=select_autoescape(),
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["pretty"] = lambda value: json.dumps(value, indent=2)


@router.get("/")
def show_sweeps(store: StoreGiven, cursor: Annotated[str | None, Query()] = None) -> str:
    """The sweeps with state, progress and links to report and cube."""
    page = store.sweeps(cursor=cursor, limit=50)
    return _rendered(
        "sweeps.html",
        sweeps=[SweepModel.of(row) for row in page.items],
        next_cursor=page.next_cursor,
        refresh=None if all(row.is_terminal for row in page.items) else REFRESH,
    )


@router.get("/docs")
def show_interface(request: Request) -> str:
    """Every operation of the interface with parameters, examples and answers."""
    document = request.app.openapi()
    problems = [*PROBLEMS.values(), INTERNAL]
    return _rendered("docs.html", operations=list(_operations(document)), problems=problems)


def _rendered(template: str, **content: Any) -> str:
    return TEMPLATES.get_template(template).render(version=version(), **content)


def _operations(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {**operation, "path": path, "method": method.upper()}


def duration(seconds: float | None) -> str:
    """A time span for people.

    >>> duration(42.0), duration(3700.0), duration(None)
    ('42 s', '1 h 02 min', '')
    """
    if seconds is None:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"


TEMPLATES.filters["duration"] = duration
