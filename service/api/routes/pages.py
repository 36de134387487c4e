"""Plain pages for people: the sweeps, and the interface described, both without any network."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse
from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup, escape

from service.api.errors import INTERNAL, PROBLEMS
from service.api.routes.given import StoreGiven
from service.api.schemas import SweepModel
from service.records.version import version
from studies.values.formats import duration

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
# What a problem document points to, so that who has no key can read what that means.
docs_router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

REFRESH = 5  # s; a page with unfinished sweeps loads itself again
TEMPLATES = Environment(
    loader=PackageLoader("service.api"),
    autoescape=select_autoescape(),
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["duration"] = duration
TEMPLATES.filters["pretty"] = lambda value: json.dumps(value, indent=2)


@router.get("/")
def show_sweeps(store: StoreGiven, cursor: Annotated[str | None, Query()] = None) -> str:
    """The sweeps with state, progress and links to report and cube."""
    front = store.sweeps_with_files(cursor=cursor)
    page = front.sweeps
    return _rendered(
        "sweeps.html",
        sweeps=[SweepModel.of(row, front.files[row.id]) for row in page.items],
        next_cursor=page.next_cursor,
        queue=front,
        refresh=None if all(row.is_terminal for row in page.items) else REFRESH,
    )


@docs_router.get("/docs")
def show_interface(request: Request) -> str:
    """Every operation of the interface with parameters, examples and answers."""
    return _rendered(
        "docs.html",
        operations=list(_operations(request.app.openapi())),
        problems=[*PROBLEMS.values(), INTERNAL],
        address=str(request.base_url).rstrip("/"),
    )


def code(text: str | None) -> Markup:
    """A description with its `words` set as code.

    >>> str(code("see `next_cursor` <here>"))
    'see <code>next_cursor</code> &lt;here&gt;'
    """
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text or ""))))


TEMPLATES.filters["code"] = code


def _rendered(template: str, **content: Any) -> str:
    return TEMPLATES.get_template(template).render(version=version(), **content)


def _operations(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {**operation, "path": path, "method": method.upper()}
