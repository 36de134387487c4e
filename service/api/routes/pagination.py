"""The way to the next page, for programs that follow links (RFC 8288)."""

from fastapi import Request, Response


def link_next(request: Request, response: Response, cursor: str | None) -> None:
    """Name the next page, if there is one: the same question with its cursor."""
    if cursor is not None:
        there = request.url.include_query_params(cursor=cursor)
        response.headers["Link"] = f'<{there.path}?{there.query}>; rel="next"'
