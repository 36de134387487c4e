"""The documentation: the site builds strictly, with the pages that are made, and loads nothing from a network."""

import os
import re
from pathlib import Path

import pytest

from docs.pages import DOCS, made
from docs.pages.measurements import SCENARIOS
from studies import measurements as measured
from studies.cases import validation
from tests.cases import verification
from tests.service.support.browser import PATIENCE, WIDTHS, chromium, opened

ROOT = DOCS.parent
LOADED = re.compile(r"""(?:src|href)=["'](https?:)?//""")  # of scripts, styles and pictures
PATH = re.compile(r"<code>((?:solver|studies|service|tests|docs)/[\w/.-]+)</code>")
PICTURE = re.compile(r'<img[^>]* src="([^"]+)"')
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)\s]*)?\)")
SITE = ROOT / "build" / "site"
HANDWRITTEN = [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")), *sorted(DOCS.glob("*.md"))]


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


def test_pages__are_built_with_their_pictures_and_name_files_that_are_there(site: Path) -> None:
    for name in made():
        assert (site / name.replace(".md", ".html")).is_file(), name
        assert not (DOCS / name).exists(), f"{name} is made, by make docs: remove it"
    for kind, names in (("verification", verification.cases()), ("validation", validation.names())):
        cases = {page.stem for page in (site / kind).glob("*.html")}
        text = (site / f"{kind}.html").read_text(encoding="utf-8")
        assert cases
        assert all(name in cases or f"<code>{name}</code>" in text for name in names), kind
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        named = [page.parent / picture for picture in PICTURE.findall(text)] + [
            ROOT / path for path in PATH.findall(text)
        ]
        assert [file for file in named if not file.exists()] == [], page.name


def test_drawings__have_a_name_for_every_measurement() -> None:
    drawn = " ".join((DOCS / "drawings" / f"{file}.svg").read_text(encoding="utf-8") for file, *_ in SCENARIOS.values())
    for name in measured.names():
        assert re.search(rf"\b{name}\b", drawn), name


@pytest.mark.parametrize("page", HANDWRITTEN, ids=lambda page: page.name)
def test_links__of_a_file_lead_to_files_or_to_pages_that_are_built(page: Path, site: Path) -> None:
    """As they stand in git; links between pages and their anchors are checked by the build."""
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" not in target:
            file = Path(os.path.normpath(page.parent / target))
            built = file.is_relative_to(SITE) and (site / file.relative_to(SITE)).is_file()
            assert file.exists() or built, target
