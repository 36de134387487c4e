"""The pictures of README, from the reports of a demo: ``python -m docs.screenshots DEMO`` writes docs/holes.png and
docs/gallery.png.

They are photographs of the reports in Chromium, so that README shows what people get.
"""

import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

from tests.crash.support.browser import chromium, opened

DOCS = Path(__file__).parent
WIDTH = 1100  # px of the window: a report's widest layout
GALLERY_WIDTH = 1160
COLOURS = 256
# The last run in full size: its debris at two times and its section at the end, without the growth history.
PICTURES = """() => {
    const run = [...document.querySelectorAll("section.run")].at(-1);
    const debris = [...run.querySelectorAll(".beside > figure svg.of-run")];
    const end = run.querySelector(".fields > figure svg.of-run");
    const styles = [...document.querySelectorAll("style")].map(style => style.outerHTML).join("");
    return [styles, run.querySelector("h3").textContent, [...debris, end].map(svg => svg.outerHTML)];
}"""
ROWS = {"holes": "Copper sphere of 8 mm on a copper plate", "craters": "The same sphere on a copper block"}


def main(demo: Path) -> None:
    """Write both pictures."""
    with chromium() as browser:
        shrink(_holes(browser, demo / "holes" / "report.html"))
        shrink(_gallery(browser, demo))


def _holes(browser: Browser, report: Path) -> Path:
    """The first figure of a report: simulation and laws."""
    file = DOCS / "holes.png"
    with opened(browser, report, WIDTH) as (page, _, _):
        page.evaluate("location.hash = '#figures'")  # which unfolds it
        page.locator("[data-plot='0']").screenshot(path=file)
    return file


def _gallery(browser: Browser, demo: Path) -> Path:
    """Debris at two times and the end of a perforation and of a crater, a row for each."""
    file, rows, head = DOCS / "gallery.png", [], ""
    for name, title in ROWS.items():
        with opened(browser, demo / name / "report.html", WIDTH) as (page, _, _):
            head, where, pictures = page.evaluate(PICTURES)
        cells = "".join(f"<div>{picture}</div>" for picture in pictures)
        rows.append(f'<h3>{title}, {where}</h3><div class="row">{cells}</div>')
    page = browser.new_page(viewport={"width": GALLERY_WIDTH, "height": 400})
    page.set_content(
        f"{head}<style>body {{ max-width: none; padding: 8px 16px; }} .row {{ display: grid; "
        f"grid-template-columns: repeat(3, 1fr); gap: 20px; align-items: start; }}</style>{''.join(rows)}"
    )
    page.locator("body").screenshot(path=file)
    page.close()
    return file


def shrink(file: Path) -> None:
    """Reduce the colours of a picture, so that the file is small."""
    with Image.open(file) as picture:
        small = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(file, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: python -m docs.screenshots DEMO\n\n{__doc__}")
    main(Path(sys.argv[1]))
