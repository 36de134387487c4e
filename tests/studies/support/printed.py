"""The content of a report's page: each marked number and text with its place, and all unmarked text."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any
from unittest.mock import patch

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


@dataclass
class Page(HTMLParser):
    """A page taken apart."""

    marks: list[Mark] = field(default_factory=list)
    unmarked: str = ""  # text that stands outside every mark
    says: list[str] = field(default_factory=list)  # what marks of drawings say
    links: list[str] = field(default_factory=list)  # everything that the page could load

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self._open: list[list[Any]] = []  # [tag, path, value, text] of each open element

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = dict(attrs)
        self.links += [named[key] or "" for key in ("src", "href") if key in named]
        if tag not in ("meta", "link", "br"):
            self._open.append([tag, named.get("data-path"), named.get("value"), ""])

    def handle_endtag(self, tag: str) -> None:
        tag, path, value, text = self._open.pop()
        if path is not None:
            self.marks.append(Mark(path, value, text))
        if tag == "title" and any(element[0] == "svg" for element in self._open):
            self.says.append(text)

    def handle_data(self, data: str) -> None:
        if not self._open:
            return
        marked = [element for element in self._open if element[1] is not None]
        for element in marked[-1:] or self._open[-1:]:
            element[3] += data
        if not marked and not any(element[0] in UNSEEN for element in self._open):
            self.unmarked += data


@contextmanager
def undrawn() -> Iterator[None]:
    """Pages whose figures are empty: to draw them is nearly all that a page costs."""
    with patch.multiple(charts, **dict.fromkeys(("of_page", "opening", "thumbnail"), lambda *_: Markup())):
        yield


def undrawn_page(document: dict[str, Any]) -> str:
    """The page of a document, without its figures."""
    with undrawn():
        return page.page(document)


def read_page(html: str) -> Page:
    """Take a page apart."""
    page = Page()
    page.feed(html)
    page.close()
    return page


def at(document: Any, pointer: str) -> Any:
    """The value at a JSON pointer."""
    for step in pointer.split("/")[1:]:
        key = step.replace("~1", "/").replace("~0", "~")
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document
