"""The pages of docs/: the site builds strictly, loads nothing from a network, and made pages are current."""

import re
from pathlib import Path
from types import ModuleType

import pytest

from docs.pages import DOCS, shots, validation, verification
from docs.pages.__main__ import PAGES
from docs.pages.measurements import SCENARIOS
from studies import measurements as measured
from tests.crash.support.browser import PATIENCE, WIDTHS, chromium, opened

ROOT = DOCS.parent
LOADED = re.compile(r"""(?:src|href)=["'](https?:)?//""")  # of scripts, styles and pictures
PATH = re.compile(r"`((?:solver|studies|service|tests|docs)/[\w/.-]+)`")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built pages; a link that leads nowhere ends the build."""
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    build(load_config(str(ROOT / "mkdocs.yml"), strict=True, site_dir=str(folder)))
    return folder


def test_site__has_every_page_and_loads_nothing_from_a_network(site: Path) -> None:
    pages = {page.name for page in site.glob("*.html")}
    assert pages >= {f"{page.stem}.html" for page in DOCS.glob("*.md")} | {"index.html"}
    for page in site.rglob("*.html"):
        head = re.findall(r"<(?:script|link|img)[^>]*>", page.read_text(encoding="utf-8"))
        assert not [element for element in head if LOADED.search(element)], page.name


@pytest.mark.claim("docs", "search", minutes=0.1)
def test_search__finds_a_word_from_disk_in_a_browser(site: Path) -> None:
    """The search of the pages finds a word in a browser, from disk."""
    with chromium() as browser, opened(browser, site / "index.html", WIDTHS[-1]) as (page, _, _):
        page.click('[data-bs-target="#mkdocs_search_modal"]')
        page.fill("#mkdocs-search-query", "bumper")
        link = page.locator("#mkdocs-search-results a").first
        link.wait_for(timeout=PATIENCE)
        href = link.get_attribute("href") or ""
        text = (site / href.partition("#")[0]).read_text(encoding="utf-8")
        assert "bumper" in text.lower()
        page.fill("#mkdocs-search-query", "xyzzy")
        page.get_by_text("No results found").wait_for(timeout=PATIENCE)


def test_site__has_equations_as_mathml(site: Path) -> None:
    text = (site / "theory.html").read_text(encoding="utf-8")
    assert text.count("<math") > 50
    assert "$" not in re.sub(r"<(script|code|pre).*?</\1>", "", text, flags=re.DOTALL)


@pytest.mark.parametrize("module", PAGES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_made_pages__are_what_the_command_makes_now(module: ModuleType) -> None:
    """``python -m docs.pages`` writes them."""
    for name, text in module.pages().items():
        assert (DOCS / name).read_text(encoding="utf-8") == text, name


def test_made_pages__of_cases_that_are_gone_are_gone() -> None:
    kept = {page.relative_to(DOCS).as_posix() for page in DOCS.glob("*/*.md")}
    assert kept <= verification.pages().keys() | validation.pages().keys()


def test_limits__have_the_bias_of_the_stored_shots() -> None:
    """``python -m docs.pages`` writes the line."""
    assert shots.limit() in (DOCS / "limits.md").read_text(encoding="utf-8").splitlines()


def test_drawings__have_a_name_for_every_measurement() -> None:
    drawn = " ".join((DOCS / "drawings" / f"{file}.svg").read_text(encoding="utf-8") for file, *_ in SCENARIOS.values())
    for name in measured.names():
        assert re.search(rf"\b{name}\b", drawn), name


@pytest.mark.parametrize("page", sorted(DOCS.rglob("*.md")), ids=lambda page: page.name)
def test_pages__name_files_that_are_there(page: Path) -> None:
    for path in PATH.findall(page.read_text(encoding="utf-8")):
        assert (ROOT / path).exists(), path
