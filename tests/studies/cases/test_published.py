"""The validation cases: each is a claim by its own name, on three grids, and holds on coarse ones.

On three grids all take a core more than an hour. The page of some is opened in a browser.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from service.cases.validation import STORE, selected, validated
from service.settings import Settings
from studies.cases import validation
from studies.cases.validation import ValidationLevel
from tests.cases.cubes import computed
from tests.claims.marked import claimed
from tests.claims.rows import Row
from tests.service.support.browser import SCHEMES, WIDTHS, chromium, rows_of

BY_COMMAND = "elastic-bar"
# Of a core: by particle-steps and 0.1 us each, measured 2026-11-23; of the others a guess.
MINUTES = {"hole-laws": 50.0}
HALF_MODELS = {"table-3-3": 9.0, "table-3-4": 16.0}
SHOWN = ("elastic-bar", "hole-laws", "taylor-bar")


def _rows(names: Sequence[str], level: ValidationLevel, folder: Path, **more: Any) -> Iterator[Row]:
    settings = Settings(data=folder / STORE, **more)
    for _, comparison in validated(
        selected(names), level, folder, settings, lambda name: nullcontext(lambda status: None)
    ):
        yield Row(**vars(comparison))


@pytest.mark.parametrize("name", claimed(validation.names(), ["plate-spall"], "cases", "validation-quick"))
def test_case__holds_on_coarse_grids(name: str, compared: Callable[[Row], None], tmp_path: Path) -> None:
    """Every validation case holds on coarse grids."""
    # One by the command, without figures in its report, the others without its service and report, which cost most.
    if name == BY_COMMAND:
        rows = _rows([name], "quick", tmp_path, targets_module="tests.service.support.solving")
    else:
        case, cubes = validation.load(name), {}
        for sweep_name, document in case.documents("quick").items():
            cubes[sweep_name] = computed(document, tmp_path)
        rows = (Row(**vars(comparison)) for comparison in case.rows("quick", cubes))
    for row in rows:
        compared(row)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.claim("cases", name, minutes=MINUTES.get(name, 5.0)))
        for name in validation.names()
    ],
)
def test_case__holds_on_three_grids(name: str, compared: Callable[[Row], None], tmp_path: Path) -> None:
    """A validation case holds on three grids."""
    for row in _rows([name], "fine", tmp_path):
        compared(row)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.claim("cases", f"{name}-half-model", minutes=minutes))
        for name, minutes in HALF_MODELS.items()
    ],
)
def test_case__holds_in_the_half_model(name: str, compared: Callable[[Row], None], tmp_path: Path) -> None:
    """Craters of the thesis hold in three dimensions, its half model on cells of 1 mm."""
    for row in _rows([name], "thesis", tmp_path):
        compared(row)


@pytest.mark.browser
@pytest.mark.claim("cases", "validation-pages", minutes=2.0)
def test_page__is_whole_in_a_browser(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """The page of `whipple validate` is whole in Chromium at 400 and 1400 px, light and dark.

    No message, no request, nothing cut off and no serious violation of accessibility.
    """
    list(_rows(SHOWN, "quick", tmp_path))
    with chromium() as browser:
        for width in WIDTHS:
            for scheme in SCHEMES:
                for row in rows_of(browser, tmp_path / "index.html", width, scheme):
                    compared(row)
