"""The pages of docs/: the site builds strictly, loads nothing from a network, and made pages are current."""

import re
from pathlib import Path

import pytest

from docs.pages import DOCS, accuracy, laws, measurements, shields, shots, validation
from studies import measurements as measured

ROOT = DOCS.parent
MADE = {
    **{"accuracy": accuracy, "laws": laws, "measurements": measurements},
    **{"shields": shields, "shots": shots, "validation": validation},
}
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
    for page in site.glob("*.html"):
        head = re.findall(r"<(?:script|link|img)[^>]*>", page.read_text(encoding="utf-8"))
        assert not [element for element in head if LOADED.search(element)], page.name


def test_site__has_equations_as_mathml(site: Path) -> None:
    text = (site / "theory.html").read_text(encoding="utf-8")
    assert text.count("<math") > 50
    assert "$" not in re.sub(r"<(script|code|pre).*?</\1>", "", text, flags=re.DOTALL)


@pytest.mark.parametrize("name", MADE)
def test_made_page__is_what_the_command_makes_now(name: str) -> None:
    """``python -m docs.pages`` writes them."""
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == MADE[name].page()


def test_limits__have_the_bias_of_the_stored_shots() -> None:
    """``python -m docs.pages`` writes the line."""
    assert shots.limit() in (DOCS / "limits.md").read_text(encoding="utf-8").splitlines()


def test_drawings__have_a_name_for_every_measurement() -> None:
    drawn = " ".join(measurements.drawings().values())
    for name in measured.names():
        assert re.search(rf"\b{name}\b", drawn), name


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_pages__name_files_that_are_there(page: Path) -> None:
    for path in PATH.findall(page.read_text(encoding="utf-8")):
        assert (ROOT / path).exists(), path
