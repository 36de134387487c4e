"""Rendering of pages: templates, cookies and the token of forms, and problem documents as pages.

What browsers send back is read, and its token checked, where callers are authenticated (``service.api.browsers``).
"""

import hashlib
import json
import re
import secrets
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from fastapi import Request, Response
from fastapi.responses import HTMLResponse
from jinja2 import Environment, FunctionLoader, select_autoescape
from markupsafe import Markup, escape
from pydantic import JsonValue

from service import version
from service.api.access import Caller
from service.api.browsers import BROWSER, TOKEN_FIELD, cookie, token_of
from service.api.dependencies import in_child
from service.pages.charts import Chart
from service.pages.computed import drawn_chart
from service.pages.page_routes import head_links
from service.records.jobs import NotFound
from studies import scenarios
from studies.quantities.display import display_of, duration

ONCE = "once"  # field with a random value of the page, by which a form that is sent twice is known
LONGEST_TEXT = 200  # characters of what is searched for
MOST_PLACE = 10**6  # largest number of a first row that a query may name
SEE_OTHER = 303  # an order was carried out: read the page that shows what it did
KEPT_SECONDS = 86400  # by a browser: the address of a chart names its content
UNAUTHORIZED, KEY_WAS_SENT = 401, 'error="invalid_token"'


def code(text: str | None) -> Markup:
    """A description with its `quoted` words as code.

    >>> str(code("see `next_cursor` <here>"))
    'see <code>next_cursor</code> &lt;here&gt;'
    """
    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text or ""))))


def _source(name: str) -> str:
    """A template of pages, or of a feature: "package:file"."""
    package, _, file = name.rpartition(":")
    return files(package or "service.pages").joinpath("templates", file).read_text(encoding="utf-8")


TEMPLATES = Environment(
    loader=FunctionLoader(_source), autoescape=select_autoescape(), trim_blocks=True, lstrip_blocks=True
)
TEMPLATES.globals["head_links"] = head_links
TEMPLATES.filters |= {
    "capitalize_first": lambda text: text[:1].upper() + text[1:],
    "code": code,
    "dict_with": lambda given, **changes: {**given, **changes},
    "duration": duration,
    "pretty": lambda value: json.dumps(value, indent=2),
    "scenario_title": lambda name: scenarios.load(name).title if name in scenarios.names() else name,
    "shown_unit": lambda unit: display_of(unit).unit,
}


def rendered(template: str, **content: Any) -> str:
    return TEMPLATES.get_template(template).render(version=version(), **content)


def page(
    request: Request,
    template: str,
    caller: Caller | None = None,
    *,
    status: int = 200,
    headers: Mapping[str, str] | None = None,
    **content: Any,
) -> Response:
    """A page whose forms have the token of the browser, which gets its cookie if it has none."""
    browser = cookie(request, BROWSER) or secrets.token_urlsafe(32)
    field = {"name": TOKEN_FIELD, "value": token_of(request, browser)}
    text = rendered(template, caller=caller, token=field, here=request.url.path, **content)
    response = HTMLResponse(text, status, headers=dict(headers or {}))
    if not cookie(request, BROWSER):
        set_cookie(request, response, BROWSER, browser)
    return response


def problem_page(
    request: Request, status: int, problem: Mapping[str, JsonValue], headers: Mapping[str, str]
) -> Response:
    """A problem document as a page: where a key is missing, the form to log in with one."""
    if status != UNAUTHORIZED:
        caller = getattr(request.state, "caller", None)
        return page(request, "problem.html", caller, status=status, headers=headers, problem=problem)
    to = request.url.path if request.method == "GET" else "/"
    # A page that is opened from another site comes without our cookie, and with it when it loads itself again.
    again = request.headers.get("sec-fetch-site") == "cross-site"
    wrong = problem if KEY_WAS_SENT in headers["WWW-Authenticate"] else None
    return page(request, "login.html", status=status, headers=headers, problem=wrong, to=to, again=again)


def set_cookie(request: Request, response: Response, name: str, value: str) -> None:
    """Give a browser a cookie that scripts cannot read and other sites do not send; an empty one is removed."""
    secure = request.url.scheme == "https"
    age = None if value else 0
    response.set_cookie(name, value, max_age=age, path="/", httponly=True, samesite="strict", secure=secure)


def idempotency_of(form: Mapping[str, str], *asked: str | None) -> tuple[str, str]:
    """Key and digest of a submission: a form that is sent twice with the same ``asked`` makes one sweep."""
    digest = hashlib.sha256(json.dumps((form.get(ONCE, ""), *asked)).encode()).hexdigest()
    return digest, digest


async def drawn(request: Request, chart: Chart) -> Response:
    """A chart as SVG; raises NotFound for an empty one, TooManyRequests where no child process is free in time."""
    if chart.is_empty:
        raise NotFound("values to draw of", chart.title)
    return as_svg(await in_child(request, drawn_chart, chart.drawn_part()))


def as_svg(svg: str | bytes) -> Response:
    """A drawing whose address names its content, so that a browser keeps it."""
    return Response(svg, media_type="image/svg+xml", headers={"Cache-Control": f"private, max-age={KEPT_SECONDS}"})
