"""Log-in and log-out of a browser; open to callers without a key."""

import re

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import RedirectResponse

from service.api.access import Caller, key_of, known_caller
from service.api.browsers import SESSION, FormFields, check_token, cookie
from service.api.dependencies import AppStore
from service.api.errors import Unauthorized, problem_response
from service.pages.page_routes import PageRoutes
from service.pages.rendering import SEE_OTHER, page, set_cookie

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("login", 90, router, is_open=True)


@router.get("/login")
def show_login(request: Request) -> Response:
    """The form to log in with a key."""
    return page(request, "login.html", to="/")


@router.post("/login", name="log-in", dependencies=[Depends(check_token)])
def log_in(request: Request, form: FormFields, store: AppStore) -> Response:
    """Log a browser in with a key, and show the page that it asked for; with a wrong key, the form again."""
    try:
        key = key_of(request, form.get("key", "").strip())
    except Unauthorized as error:
        return problem_response(request, error)
    request.state.caller = Caller.of(key)
    response = RedirectResponse(_own_page(form.get("to", "")), SEE_OTHER)
    set_cookie(request, response, SESSION, store.keys.begin_session(key))
    return response


@router.post("/logout", name="log-out", dependencies=[Depends(check_token)])
def log_out(request: Request, store: AppStore) -> Response:
    """Log the browser out."""
    request.state.caller = known_caller(request)
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
