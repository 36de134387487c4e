"""What pages give a browser: its cookies, and the value by which a form that is sent twice is known.

What comes back is read, and its token checked, where callers are authenticated (``service.api.browsers``).
"""

import hashlib
import json
import secrets
from collections.abc import Mapping

from fastapi import Request, Response

ONCE = "once"  # field with a random value of the page, by which a form that is sent twice is known


def set_cookie(request: Request, response: Response, name: str, value: str) -> None:
    """Give a browser a cookie that scripts cannot read and other sites do not send; an empty one is removed."""
    secure = request.url.scheme == "https"
    age = None if value else 0
    response.set_cookie(name, value, max_age=age, path="/", httponly=True, samesite="strict", secure=secure)


def idempotency_of(form: Mapping[str, str], *asked: str | None) -> tuple[str, str]:
    """Key and digest of a submission: a form that is sent twice with the same ``asked`` makes one sweep."""
    digest = hashlib.sha256(json.dumps((form.get(ONCE, ""), *asked)).encode()).hexdigest()
    return digest, digest


def new_browser() -> str:
    """A value of the cookie of a browser."""
    return secrets.token_urlsafe(32)
