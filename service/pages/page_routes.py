"""What a page, or a feature with one, adds to the pages."""

from dataclasses import dataclass
from functools import cache

from fastapi import APIRouter

from solver.registry import entries


@dataclass(frozen=True)
class PageRoutes:
    """The routes of pages, and which of them every page links."""

    name: str
    place: int  # in the head of every page; of two routes that match an address, the first is taken
    router: APIRouter
    links: tuple[tuple[str, str], ...] = ()  # address and title
    is_open: bool = False  # whether callers without a key may see it


@cache
def all_pages() -> tuple[PageRoutes, ...]:
    """The pages of the folder ``pages`` and of features, in their order."""
    return tuple(sorted(entries("service.pages.pages", "PAGE").values(), key=lambda page: page.place))


def head_links() -> list[tuple[str, str]]:
    """Address and title of the pages that every page links."""
    return [link for page in all_pages() for link in page.links]
