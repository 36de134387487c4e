"""Words that told people nothing stay away: in sources of pages and commands, in cubes and in reports."""

import json
import re
from pathlib import Path

import pytest

from studies.reports import page
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.studies.support import fakes
from tests.studies.support.printed import undrawn

ROOT = Path(__file__).parents[3]
GONE = re.compile(
    "points that reject|wide bars|is refuted|beyond hugoniot|untested|simulation only|recommended law", re.IGNORECASE
)
SOURCES = [
    file
    for folder in ("studies", "service", "whipple")
    for kind in ("py", "html", "txt", "yaml", "js")
    for file in (ROOT / folder).rglob(f"*.{kind}")
]


@pytest.mark.claim("report", "plain-words")
def test_words_that_told_nothing__are_in_no_source_no_cube_and_no_report(compared: Compared) -> None:
    """No page, command, cube or report says "agrees, wide bars", "points that reject", "is refuted" or "untested"."""
    found = [str(file.relative_to(ROOT)) for file in SOURCES if GONE.search(file.read_text(encoding="utf-8"))]
    compared(equal(f"sources with such words, of {len(SOURCES)}", expected=[], got=found))
    for sweep in (fakes.holes(), fakes.refined_holes(), fakes.craters()):
        dataset = fakes.cube_of(sweep)
        document = fakes.document_of(dataset)
        with undrawn():
            texts = [
                json.dumps(document),
                page.page(document),
                page.appendix(document),
                str(dataset.to_dict(data=True)),
            ]
        compared(equal(f"{sweep.name}: such words", expected=0, got=sum(len(GONE.findall(text)) for text in texts)))
