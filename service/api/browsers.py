"""What browsers send with a request: the cookie of a session, and the token that proves that a page of ours was read.

A form or script of a page sends the token with every order; a page of another site cannot read it. The token is
derived from a cookie that each browser gets with its first page, and from the cookie of the log-in: a new log-in makes
another token.
"""

import hashlib
import hmac
from typing import Annotated
from urllib.parse import parse_qsl

from fastapi import Depends, Request
from starlette.requests import ClientDisconnect

from service.api.errors import BadRequest, CrossSiteRequest, PayloadTooLarge, UnsupportedMediaType

SESSION, BROWSER = "whipple_session", "whipple_browser"  # cookies
TOKEN_FIELD, TOKEN_HEADER = "csrf_token", "X-CSRF-Token"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})  # RFC 9110, section 9.2.1; they have no body that counts
IDENTITY = "identity"  # the coding of a body as it is
FORM = "application/x-www-form-urlencoded"
LONGEST_FORM = 4 << 20  # bytes of the form of a new sweep, which may hold a deck
SHORT_FORM = 16 << 10  # bytes of any other form
MOST_FIELDS = 500  # fields of a form at most; the form of a new sweep has fewer than a hundred
LONGEST_COOKIE = 200  # characters; ours are shorter


def cookie(request: Request, name: str) -> str:
    """The value of a cookie; empty without one, or for one that is none of ours."""
    value = request.cookies.get(name, "")
    return value if len(value) <= LONGEST_COOKIE and value.isascii() else ""


async def body_of(request: Request, longest: int, cure: str = "") -> bytes:
    """The body of a request; raises PayloadTooLarge, UnsupportedMediaType for a compressed one, and BadRequest."""
    declared, coding = request.headers.get("content-length", ""), request.headers.get("content-encoding", IDENTITY)
    if coding.strip().lower() != IDENTITY:
        raise UnsupportedMediaType(
            f"a body in the coding {coding[:80]!r}; send it as it is", {"Accept-Encoding": IDENTITY}
        )
    if declared.isdigit() and int(declared[:18]) > longest:
        raise PayloadTooLarge(f"{declared[:18]} bytes; at most {longest}{cure}")
    body = bytearray()
    try:
        async for chunk in request.stream():
            body += chunk
            if len(body) > longest:
                raise PayloadTooLarge(f"more than {longest} bytes{cure}")
    except ClientDisconnect:
        raise BadRequest("the body ended before its declared length") from None
    return bytes(body)


async def _form(request: Request) -> dict[str, str]:
    """The fields of a form in the body of a browser's order; empty for another body, and where there is no order.

    Raises as ``body_of`` does.
    """
    kind, length = request.headers.get("content-type", ""), request.headers.get("content-length", "")
    is_form = kind.partition(";")[0].strip().lower() == FORM and length.isdigit()
    if request.method in SAFE_METHODS or not is_form or not cookie(request, BROWSER):
        return {}
    longest = LONGEST_FORM if request.url.path.startswith("/new/") else SHORT_FORM
    try:
        text = (await body_of(request, longest, ": send more to POST /v1/sweeps")).decode(errors="replace")
        # Browsers send the ends of lines as CR LF.
        return {name: value.replace("\r\n", "\n") for name, value in parse_qsl(text, max_num_fields=MOST_FIELDS)}
    except ValueError:
        raise BadRequest(f"a form of more than {MOST_FIELDS} fields") from None


FormFields = Annotated[dict[str, str], Depends(_form)]


def token_of(request: Request, browser: str) -> str:
    """The token of a browser, and of its session if it has one."""
    return hmac.new(browser.encode(), cookie(request, SESSION).encode(), hashlib.sha256).hexdigest()


def check_token(request: Request, form: FormFields) -> None:
    """Raise CrossSiteRequest unless a request has the token of its browser, in its header or its form."""
    sent = request.headers.get(TOKEN_HEADER) or form.get(TOKEN_FIELD, "")
    browser = cookie(request, BROWSER)
    if not browser or not hmac.compare_digest(sent.encode(), token_of(request, browser).encode()):
        raise CrossSiteRequest("this page is out of date, or not of this service: load it again, and repeat the order")
