"""The documentation of the API; open to callers without a key, because problem documents point there."""

import json
import re
import shlex
from collections.abc import Iterator
from functools import cache

from fastapi import APIRouter, FastAPI, Request, Response
from markupsafe import Markup, escape
from pydantic import JsonValue

from service.api.access import known_caller
from service.api.errors import INTERNAL_ERROR, PROBLEMS
from service.openapi.routes import TAGS
from service.pages.page_routes import PageRoutes
from service.pages.rendering import page, rendered

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("documentation", 80, router, (("/docs", "API"),), is_open=True)

EVENTS, FILE = "text/event-stream", re.compile(r"\.\w+$")

ADDRESS = "\0"  # occurs in no text of the page


@router.get("/docs")
def show_documentation(request: Request) -> Response:
    """Every operation of the API with parameters, examples and responses."""
    address = escape(str(request.base_url).rstrip("/"))
    content = _documentation(request.app)
    return page(request, "docs.html", known_caller(request), content=Markup(content.replace(ADDRESS, address)))


@cache
def _documentation(app: FastAPI) -> str:
    """The content of the page with ``ADDRESS`` in place of that of the service; rendering it takes 50 ms (2026-11)."""
    operations = list(_operations(app))
    groups = [{**tag, "operations": [one for one in operations if one["tags"] == [tag["name"]]]} for tag in TAGS]
    return rendered("operations.html", groups=groups, problems=[*PROBLEMS.values(), INTERNAL_ERROR], address=ADDRESS)


def _operations(app: FastAPI) -> Iterator[dict[str, JsonValue]]:
    """The operations of the app, each with a call of it by curl, in which ids are variables of the shell."""
    for path, methods in app.openapi()["paths"].items():
        for method, operation in methods.items():
            place = path.replace("{id}", "$RUN" if path.startswith("/v1/runs") else "$SWEEP")
            for parameter in operation.get("parameters", ()):
                if parameter["in"] == "path" and parameter["name"] != "id":
                    place = place.replace(f"{{{parameter['name']}}}", parameter["schema"]["examples"][0])
            body = operation.get("requestBody", {}).get("content", {}).get("application/json")
            words = ["curl"]
            if method not in ("get", "post") or (method == "post" and body is None):
                words.append(f"-X {method.upper()}")
            if EVENTS in operation["responses"].get("200", {}).get("content", {}):
                words.append("-N")
            elif method == "get" and FILE.search(place):
                words.append("-O")
            if body is not None:  # that of a sweep is in a file
                examples = [body["example"]] if "example" in body else body["schema"].get("examples", [])
                words.append(f"--json {shlex.quote(json.dumps(examples[0])) if examples else '@sweep.json'}")
            example = " ".join([*words, f"{ADDRESS}{place}"])
            yield {**operation, "path": path, "method": method.upper(), "example": example}
