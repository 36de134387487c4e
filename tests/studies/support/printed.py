"""The content of a report's page: each marked number and text with its place, and all unmarked text."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import Mock, patch

from lxml.html import HTMLParser, fromstring
from markupsafe import Markup

from studies.reports import page
from studies.reports.drawing import charts

UNSEEN = ("script", "style", "noscript", "title", "svg")


@dataclass(frozen=True)
class Mark:
    """A piece of the page that carries its place in report.json."""

    path: str  # JSON pointer
    value: str | None  # the number in full; None for a text
    text: str  # as people read it


@dataclass(frozen=True)
class Page:
    """A page taken apart."""

    marks: list[Mark]
    unmarked: str  # text that stands outside every mark
    says: list[str]  # what marks of drawings say
    links: list[str]  # everything that the page could load


@contextmanager
def undrawn() -> Iterator[None]:
    """Pages whose figures are empty: to draw them is nearly all that a page costs."""
    empty = Mock(return_value=Markup())
    with patch.multiple(charts, of_page=empty, opening=empty, thumbnail=empty):
        yield


def undrawn_page(document: dict[str, Any]) -> str:
    """The page of a document, without its figures."""
    with undrawn():
        return page.page(document)


def read_page(html: str) -> Page:
    """Take a page apart."""
    root = fromstring(html, parser=HTMLParser(huge_tree=True))  # its pictures are large
    seen = " or ".join(["@data-path", *(f"self::{name}" for name in UNSEEN)])
    marked = root.xpath("//*[@data-path]")
    return Page(
        marks=[Mark(each.get("data-path"), each.get("value"), each.text_content()) for each in marked],
        unmarked="".join(root.xpath(f"//text()[not(ancestor::*[{seen}])]")),
        says=[each.text_content() for each in root.xpath("//svg//title")],
        links=root.xpath("//@src | //@href"),
    )


def at(document: Any, pointer: str) -> Any:
    """The value at a JSON pointer."""
    for step in pointer.split("/")[1:]:
        key = step.replace("~1", "/").replace("~0", "~")
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document
