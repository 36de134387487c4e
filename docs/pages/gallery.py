"""gallery.md: the sweeps that ship, a sentence each, and a photograph of the report of those that take seconds.

``python -m docs.pages compute gallery DIRECTORY`` computes what the directory does not have, and takes the
photographs in Chromium.
"""

import tempfile
from pathlib import Path
from typing import Any

from docs.pages import DOCS
from studies.sweeps import examples
from studies.sweeps.document import read_yaml

FOLDER = "gallery"
# Of each example that takes less than a minute on two cores: words in the caption of a section of its last run, or none
# for the first figure.
SHOWN = {
    "aluminium": "Section at the end",
    "bar": "",
    "oblique": "Section of the debris (2",
    "plate": "",
    "smoke": "Section of the debris (2",
    "taylor": "Section at the end",
}
SECTION_WIDTH, FIGURE_WIDTH = 420, 640  # px of the window
LARGEST = 60_000  # bytes of a photograph
# Styles and picture of a section of the last run.
SECTION = """words => {
    const run = [...document.querySelectorAll("section.run")].at(-1);
    const figure = [...run.querySelectorAll("figure")].find(each => each.textContent.includes(words));
    const styles = [...document.querySelectorAll("style")].map(style => style.outerHTML).join("");
    return [styles, figure.querySelector("svg.of-run").outerHTML];
}"""
# Pictures of other pages: file, page and what they show.
OTHERS = (
    ("holes.png", "../README.md", "The laws of `holes` beside the simulation."),
    ("gallery.png", "../README.md", "A perforation and a crater of `holes` and `craters`, with debris at two times."),
    ("debris-cloud.png", "clouds.md", "A debris cloud behind a thin plate."),
    ("plugging.png", "methods.md", "A plug of steel, cut out by damage."),
    ("methods.png", "methods.md", "A perforation by material points and by smoothed particles."),
)


def compute(directory: Path | None = None) -> None:
    """Compute the examples that are shown, and photograph their reports."""
    from playwright.sync_api import Browser

    import whipple
    from docs.screenshots import shrink
    from tests.crash.support.browser import chromium, opened

    def photograph(browser: Browser, report: Path, words: str, file: Path) -> None:
        with opened(browser, report, SECTION_WIDTH if words else FIGURE_WIDTH) as (page, _, _):
            picture = page.locator("[data-plot]")
            if words:
                styles, section = page.evaluate(SECTION, words)
                page.set_content(f"{styles}<div style='padding: 4px'>{section}</div>")
                picture = page.locator("div")
            picture.first.screenshot(path=file)
        shrink(file)
        if file.stat().st_size > LARGEST:
            raise ValueError(f"{file}: {file.stat().st_size} bytes, more than {LARGEST}")

    (DOCS / FOLDER).mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary, chromium() as browser:
        for name, words in SHOWN.items():
            folder = (directory or Path(temporary)).resolve() / name
            if not (folder / "report.html").exists():
                whipple.run_sweep(_document(name), folder)
            photograph(browser, folder / "report.html", words, DOCS / FOLDER / f"{name}.png")


def _document(name: str) -> dict[str, Any]:
    document: dict[str, Any] = read_yaml(examples.text(name), name)
    return document


def pages() -> dict[str, str]:
    """gallery.md."""
    parts = [
        "# Gallery\n",
        "The sweeps that ship, in `studies/sweeps/examples/`: copy one and change it. A picture shows the last run in "
        "section, or the first figure of the report. Those without take minutes; `whipple estimate FILE.yaml` says how "
        "many.\n",
    ]
    for name in examples.names():
        says = examples.text(name).splitlines()[0].removeprefix("# ")
        parts += [f"## {name}\n"]
        if name in SHOWN:
            parts += [f"![{_document(name)['title']}]({FOLDER}/{name}.png)\n"]
        parts += [f"**{_document(name)['title']}.** {says}\n"]
    parts += ["## Pictures of other pages\n"]
    for file, page, says in OTHERS:
        parts += [f"[![{says}]({file})]({page})\n", f"{says}\n"]
    return {"gallery.md": "\n".join(parts)}
