"""A page in a browser: its messages, its requests, what it cuts off, and how accessible it is."""

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

from tests.claims.rows import Row, equal

CHROMIUM = os.environ.get("WHIPPLE_CHROMIUM") or shutil.which("chromium")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    # Whatever the page may ask for elsewhere is answered by nobody.
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)
PATIENCE = 120_000  # ms: a cold browser on a busy machine
WIDTHS, HEIGHT = (400, 1400), 900  # of the window, px
SERIOUS = ("serious", "critical")
# Boxes that people cannot scroll sideways, and what reaches beyond them.
CUT = """() => [...document.querySelectorAll("figure, figure > *, svg, p, h1, h2, h3, nav, dl")]
    .filter(box => box.getBoundingClientRect().right > innerWidth + 1 && !box.closest("table"))
    .map(box => `${box.tagName} ${box.className.baseVal ?? box.className} ${box.textContent.slice(0, 40)}`)"""

BEYOND = "Math.max(0, document.documentElement.scrollWidth - innerWidth)"  # px of the document beyond the window
A4 = (595, 842)  # points, portrait

Scheme = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = ("light", "dark")


@contextmanager
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS), timeout=PATIENCE)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def window(
    browser: Browser, width: int = max(WIDTHS), scheme: Scheme = "light", **options: Any
) -> Iterator[tuple[Page, list[str], list[str]]]:
    """A page in a window of its own; what it and its scripts say on the console, and the addresses it requests."""
    viewport: Any = {"width": width, "height": HEIGHT}
    context = browser.new_context(viewport=viewport, color_scheme=scheme, **options)
    context.set_default_timeout(PATIENCE)
    page, messages, requests = context.new_page(), list[str](), list[str]()
    page.on("console", lambda message: messages.append(message.text))
    page.on("pageerror", lambda error: messages.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    try:
        yield page, messages, requests
    finally:
        context.close()


@contextmanager
def opened(
    browser: Browser, file: Path, width: int, scheme: Scheme = "light"
) -> Iterator[tuple[Page, list[str], list[str]]]:
    """A page from disk after its scripts have run, its messages, and its requests."""
    with window(browser, width, scheme) as (page, messages, requests):
        page.goto(file.as_uri())
        yield (page, messages, [url for url in requests if not url.startswith(("data:", file.as_uri()))])


def faults_of(page: Page, where: str) -> Iterator[Row]:
    """What no page may have: serious violations of accessibility, and anything beyond the window."""
    yield equal(f"{where}: serious violations of accessibility (axe)", expected=[], got=violations_of(page))
    yield equal(f"{where}: elements beyond the window", expected=[], got=page.evaluate(CUT))
    yield equal(f"{where}: document wider than the window by (px)", expected=0, got=page.evaluate(BEYOND))


def rows_of(browser: Browser, file: Path, width: int, scheme: Scheme, picture: Path | None = None) -> Iterator[Row]:
    """What a page from disk must not have, in a window of a width; a picture of all of it is kept."""
    where = f"{file.name}, {width} px, {scheme}"
    with opened(browser, file, width, scheme) as (page, messages, requests):
        yield from faults_of(page, where)
        yield equal(f"{where}: messages and requests", expected=[], got=[*messages, *requests])
        if picture:
            page.screenshot(path=picture, full_page=True)


def violations_of(page: Page) -> list[str]:
    """What a page has against it in accessibility, serious or worse (axe)."""
    found = Axe().run(page).response["violations"]
    serious = (each for each in found if each["impact"] in SERIOUS)
    return [f"{each['id']}: {node['html'][:120]}" for each in serious for node in each["nodes"]]


def print_page(browser: Browser, file: Path, pdf: Path) -> Iterator[Row]:
    """Print a page as PDF; it stands on sheets of A4 and asks for nothing."""
    with opened(browser, file, max(WIDTHS)) as (page, messages, requests):
        page.pdf(path=pdf, prefer_css_page_size=True, print_background=True)
        said = [*messages, *requests]
    yield Row("printed: messages and requests", "none", "; ".join(said) or "none", not said)
    boxes = re.findall(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)", pdf.read_bytes())
    sizes = {(round(float(width)), round(float(height))) for width, height in boxes}
    yield equal("printed: size of the sheets (points)", expected={A4}, got=sizes)
    yield Row("printed: sheets", "", str(len(boxes)), None)
