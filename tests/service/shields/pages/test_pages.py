"""The pages of a shield and of the shots at them, and what pages of runs and sweeps say of walls that hold."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.pages.pages.runs import _printed
from service.shields.pages.shields import NOTE
from studies.quantities.parameters import Value
from tests.service.api.test_turns import check_that_waiting_leaves_turns, strict
from tests.service.pages.test_asking import check_fields, findings
from tests.service.support.api import Api, open_api

__all__ = ["strict"]


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """A service that a browser asks for pages."""
    with open_api(tmp_path) as opened:
        opened.http.headers.update({"Accept": "text/html"})
        yield opened


@pytest.mark.claim("pages", "shield-page", minutes=0.1)
def test_shield__is_answered_with_a_figure_and_its_findings_stand_at_the_fields(api: Api) -> None:
    page = api.http.get("/shields")
    assert "to fail" in page.text
    assert page.text.count('src="data:image/svg+xml') == 2
    assert "/new/whipple_shield?" in page.text
    asked = "speed=6&projectile=al-2017-t4&projectile_diameter=5+mm&bumper=al-6061-t6&wall_thickness=3+mm"
    refused = api.http.get(f"/shields?{asked}")
    assert findings(refused).keys() == {"speed", "bumper_thickness", "stand_off"}
    assert api.http.get(f"/shields/sheet?{asked}").status_code == 422
    check_fields(api, "/shields?speed=6", "projectile", "wall")
    assert "unsafe-inline" in api.http.get("/shields/sheet").headers["Content-Security-Policy"]


def test_shots__on_shields_are_chosen_by_the_address(api: Api) -> None:
    page = api.http.get("/shots/shields?speed=6+km/s+to+7+km/s&outcome=held")
    held = int(re.search(r"(\d+) shots; the wall failed in 0", page.text)[1])  # type: ignore[index]
    assert 0 < held < 804
    assert api.http.get("/shots/shields?speed=6").status_code == 422


def test_page__that_waits_for_a_child_leaves_the_others_their_turns(strict: tuple[Api, str, httpx.Client]) -> None:
    check_that_waiting_leaves_turns(*strict, "/shields?speed=5+km/s")


def test_wall_that_holds__says_how_many_failures_such_simulations_find() -> None:
    parameters: dict[str, Value] = {"speed": 7e3, "obliquity": 0.0, "failure": "void-growth"}
    held, perforated = (_printed("wall_perforated", value, None, (), parameters).text for value in (0.0, 1.0))
    assert held == "wall holds; such simulations found 8 of 17 walls that were perforated"
    assert perforated == "wall perforated"


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ({"fixed": {}}, "with failure none, such simulations found 7 of 17 walls that were perforated"),
        ({"fixed": {"failure": None}}, "with failure none, such simulations found 7 of 17 walls that were perforated"),
        ({"axes": {"failure": ["void-growth"]}}, "with failure void-growth, such simulations found 8 of 17"),
        ({"fixed": {"failure": "spall-rate"}}, "with failure spall-rate, no published shots were simulated like this"),
    ],
)
def test_walls_of_a_sweep__stand_above_how_many_failures_such_simulations_find(
    document: dict[str, Any], said: str
) -> None:
    assert NOTE.of_sweep(document).startswith(f"Where a wall holds at 3 km/s or faster: {said}")


def test_page_of_a_shield__says_what_its_walls_that_hold_are_worth(api: Api) -> None:
    fixed = {
        **{"projectile": "al-2017-t4", "projectile_diameter": "5 mm", "bumper": "al-6061-t6"},
        **{"bumper_thickness": "1.2 mm", "stand_off": "100 mm", "wall": "al-6061-t6", "wall_thickness": "3.2 mm"},
    }
    sweep = api.submit(scenario="whipple_shield", fixed=fixed, axes={"speed": ["6 km/s"]}, resolution=16)
    note = "Where a wall holds at 3 km/s or faster:"
    assert note in api.http.get(f"/sweeps/{sweep}", params={"quantity": "wall_perforated"}).text
    assert note not in api.http.get(f"/sweeps/{sweep}", params={"quantity": "wall_bulge"}).text
