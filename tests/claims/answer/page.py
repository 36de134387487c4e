"""The report's page in a browser, of runs that were computed for it."""

from collections.abc import Iterator
from pathlib import Path

import whipple
from tests.acceptance.support.browser import SCHEMES, WIDTHS, chromium, look, print_page, rows_of
from tests.claims import Row, at_most, claim

# Pictures of the page stay here, to be looked at.
FOLDER = Path(__file__).parents[3] / ".cache" / "report-page"
MOST = 8.0  # MB
HOLES = {
    "name": "page",
    "title": "Holes in copper plates, 8 mm copper sphere",
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "axes": {"speed": ["3 km/s", "5 km/s", "6.5 km/s"], "plate_thickness": ["2 mm", "3 mm"]},
    "resolution": 16,
}


@claim(
    "report-page",
    says="a report with pictures has at most 8 MB, and in Chromium at 400 and 1400 px, light, dark and printed, no "
    "message, no request, nothing cut off and no serious violation of accessibility",
)
def report_page() -> Iterator[Row]:
    report = Path(whipple.run_sweep(HOLES, FOLDER / "holes", overwrite=True)) / "report.html"
    yield at_most("size of the report (MB)", limit=MOST, got=report.stat().st_size / 1e6)
    with chromium() as browser:
        for width in WIDTHS:
            for scheme in SCHEMES:
                picture = FOLDER / f"{width}-{scheme}.png"
                seen = look(browser, report, width, scheme, picture)
                yield from rows_of(seen, f"{width} px, {scheme}")
        yield from print_page(browser, report, FOLDER / "report.pdf")
    yield Row("pictures of the page", "", str(FOLDER), None)
