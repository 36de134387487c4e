"""What a report opens with: the number, the nearest laws, what was measured; of sweeps whose numbers are known."""

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import whipple
from studies import laws as laws_of
from studies.reports.sections.search import FoundLimit, FoundLimits
from studies.reports.wording import MOST_WORDS, text_template, worded
from studies.sweeps import examples
from studies.sweeps.axes import Axis
from studies.sweeps.document import read_yaml
from tests.claims.rows import at_most, equal
from tests.studies.support import fakes

NAME = "hole_diameter"
Numbers = Callable[[float, float], float]


def ratio(speed: float, thickness: float) -> float:
    """Hole over projectile of every made-up run."""
    return 2.0 * (speed / 5e3) ** 0.6 * (thickness / 2e-3) ** 0.4


def law(name: str, factor: Numbers, **changes: Any) -> Any:
    """A law that gives the made-up hole times a factor of speed and thickness."""

    def given(shot: Any, _: str) -> float:
        return ratio(shot.speed, shot.plate_thickness) * factor(shot.speed, shot.plate_thickness)

    return fakes.law(name, NAME, given, **changes)


def document_of(
    laws: list[Any], *axes: Axis, bar: float = 0.004, mesh: bool = True, shots: Any = (), spoiled: Any = None
) -> Any:
    """Report and cube of made-up holes, on one grid or three of first order; ``spoiled`` are changes by run number."""
    sweep = fakes.sweep_of(*axes, resolutions=fakes.CELLS if mesh else (20.0,), model_part="none")
    results = {}
    for number, point in enumerate(sweep.runs()):
        at = laws_of.shot_from(point.run.parameters, point.run.materials)
        assert at.plate_thickness is not None
        value = ratio(at.speed, at.plate_thickness) * fakes.DIAMETER
        measured = fakes.of_first_order(value, bar, point.run)
        result = replace(fakes.result(point.run), measurements={NAME: measured})
        results[point.run.id] = replace(result, **(spoiled or {}).get(number, {}))
    dataset = fakes.cube_of(sweep, results, laws=laws, quantities={NAME: fakes.HOLES[NAME]}, observations=shots)
    return fakes.document_of(dataset), dataset


SPEED = Axis("speed", "m s-1", fakes.SPEEDS)
THICKNESS = Axis("plate_thickness", "m", fakes.THICKNESSES)


def shot(factor: float, confidence: str = "read", uncertainty: float | None = 0.02, speed: float = 4e3) -> Any:
    """A measured hole in 2 mm, so many times the made-up one."""
    value = factor * ratio(speed, 2e-3) * fakes.DIAMETER
    observed = fakes.observed(speed, 2e-3, value, None if uncertainty is None else uncertainty * value)
    return replace(observed, confidence=confidence)


def said(*arguments: Any, **named: Any) -> str:
    """The headline of made-up holes, with plain spaces."""
    document, _ = document_of(*arguments, **named)
    assert not re.search(r"±[\d.]+ %", document["headline"])  # a narrow space holds number and unit together
    return str(document["headline"]).replace("\u202f", " ")


def exact(name: str, factor: float = 1.0, **changes: Any) -> Any:
    return law(name, lambda speed, thickness: factor, **changes)


THICKER = fakes.observed(6e3, 2.15e-3, 30e-3)
FLAG: dict[str, Any] = {"flags": ("under_resolved",)}
FLAGGED = dict.fromkeys(range(99), FLAG)
# Of 8 mm in 2 mm: 16 mm times 0.4^0.6 at 2 km/s, times 1.4^0.6 at 7 km/s.
LOW, HIGH = 16.0 * 0.4**0.6, 16.0 * 1.4**0.6
HOLES = f"Hole {LOW:.3g} mm at 2 km/s to {HIGH:.3g} mm at 7 km/s"
UNKNOWN = f"{HOLES} (mesh error unknown)."
HILL = exact("h", 0.95, title="Hill")
ENDS = [Axis("speed", "m s-1", (2e3, 7e3)), Axis("plate_thickness", "m", (2e-3, 4e-3))]
THICK = HIGH * 2.0**0.4
SOME = {"speed": [Axis("speed", "m s-1", (4e3, 5e3, 6e3))], "one": [Axis("speed", "m s-1", (5e3,))]}


FINE = f"{HOLES} (±0.4 %)"
NEAREST = "Nearest law: Hill (−5 %)."
NO_SHOT = "No shot measured."
# What a sweep over the speed opens with beside one law, 5 % below; by what else is different.
OPENINGS: list[tuple[str, dict[str, Any]]] = [
    (f"{HOLES} (±7 %). {NEAREST} {NO_SHOT}", {"bar": 0.07}),
    (
        f"{FINE}. Nearest laws: Eta (+3 %), Hill (−5 %). {NO_SHOT}",
        {"laws": [HILL, exact("e", 1.03, title="Eta, Zeta")]},
    ),
    (
        f"{FINE}. Nearest law: Hill (−10 to +5 %). {NO_SHOT}",
        {"laws": [law("h", lambda speed, _: 0.9 + 0.15 * (speed - 2e3) / 5e3, title="Hill")]},
    ),
    (
        f"Hole {LOW:.3g} mm (2 km/s, plate thickness 2 mm) to {THICK:.3g} mm (7 km/s, plate thickness 4 mm), ±7 %. "
        f"{NEAREST} {NO_SHOT}",
        {"axes": ENDS, "bar": 0.07},
    ),
    (f"Hole 14.0, 16.0, 17.8 mm at 4, 5, 6 km/s (±7 %). {NEAREST} {NO_SHOT}", {"axes": SOME["speed"], "bar": 0.07}),
    (f"Hole 16.0 ± 1.1 mm. Hill 15.2. {NO_SHOT}", {"axes": SOME["one"], "bar": 0.07}),
    (
        "Hole 16.0 ± 1.1 mm, measured 16.5. Hill 15.2.",
        {"axes": SOME["one"], "bar": 0.07, "shots": (shot(1.03125, speed=5e3),)},
    ),
    (f"{UNKNOWN} {NEAREST} {NO_SHOT}", {"mesh": False}),
    (f"{HOLES} (±0.4 %; all flagged). {NEAREST} {NO_SHOT}", {"spoiled": FLAGGED}),
    (f"{HOLES} (±0.4 %; 2 of 6 flagged). {NEAREST} {NO_SHOT}", {"spoiled": dict.fromkeys((2, 8), FLAG)}),
    (
        f"{FINE}. No law is comparable here. {NO_SHOT}",
        {"laws": [exact("h", title="Hill", range=fakes.within(8.0, 9.0))]},
    ),
    (f"{FINE}. {NEAREST} One shot measured 18.2 mm: computed −23 %, Hill −27 %.", {"shots": (shot(1.3),)}),
    (
        f"{FINE}. {NEAREST} One shot measured 18.2 mm, second-hand: computed −23 %.",
        {"shots": (shot(1.3, "second-hand"),)},
    ),
    (f"{FINE}. {NEAREST} 2 shots measured: computed −23 to +25 %.", {"shots": (shot(1.3), shot(0.8, speed=6e3))}),
    # Between the runs of 4 and 5 km/s; and in a plate that is a little thicker, with which nothing is compared.
    (f"{FINE}. {NEAREST} One shot measured 19.5 mm: computed −23 %, Hill −27 %.", {"shots": (shot(1.3, speed=4.5e3),)}),
    (f"{FINE}. {NEAREST} 1 of 2 shots measured: computed −23 %.", {"shots": (shot(1.3), THICKER)}),
    (f"{FINE}. {NO_SHOT}", {"laws": [exact("h", confidence="memory")]}),
    (f"{FINE}. {NO_SHOT}", {"laws": [], "shots": (shot(1.3, speed=9e3),)}),
]


@pytest.mark.claim("report", "headline")
@pytest.mark.parametrize(("expected", "changes"), OPENINGS)
def test_headline__of_known_numbers(expected: str, changes: dict[str, Any]) -> None:
    """The opening of a sweep whose numbers are known has its values, its nearest laws and its measured shots."""
    options = {"laws": [HILL], "axes": [SPEED], **changes}
    assert said(options.pop("laws"), *options.pop("axes"), **options).removesuffix(TO_RUN).rstrip() == expected


TO_RUN = "Run with accuracy 5 % for error bars."
ALUMINIUM = [Axis("speed", "m s-1", (4e3, 6.18e3)), Axis("plate_thickness", "m", (4e-3,))]


def test_headline__says_a_published_range_of_an_unknown_alloy_and_the_law_that_reaches_it() -> None:
    """A shot that ships is named though the sweep brings none, with what is doubtful about it."""
    metals = {"projectile": "al-2024-t3", "target": "al-2024-t3", "projectile_diameter": 1e-2}
    sweep = fakes.sweep_of(*ALUMINIUM, resolutions=fakes.CELLS, fixed=metals, model_part="none")
    results = {}
    for point in sweep.runs():
        value = 23.5e-3 * (float(point.run.parameters["speed"] or 0.0) / 6.18e3) ** 0.5
        results[point.run.id] = replace(
            fakes.result(point.run), measurements={NAME: fakes.of_first_order(value, 0.02, point.run)}
        )
    laws = [
        fakes.law(name, NAME, lambda *_, size=size: size, title=name) for name, size in (("Hill", 2.4), ("Sawle", 2.79))
    ]
    dataset = fakes.cube_of(sweep, results, laws=laws, quantities={NAME: fakes.HOLES[NAME]})
    assert fakes.document_of(dataset)["headline"] == (
        "6.18 km/s: 23.5 mm computed, 24.0 by Hill; measured 27.5 to 34.5, alloy unknown, second-hand; only Sawle "
        "(27.9) reaches it."
    )


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ([183.0], "Perforated from speed 183 m/s, between 180 and 186 m/s."),
        ([183.0, 250.0], "Perforated from speed 0.183-0.25 km/s (2 limits)."),
        ([None], "The search for perforated found no limit."),
    ],
)
def test_headline__of_a_search_is_its_limit(limits: list[float | None], said: str) -> None:
    found = (FoundLimit({}, limit, 180.0, 186.0, 5, "bracketed", "") for limit in limits)
    record = FoundLimits("speed", "perforated", "m s-1", tuple(found))
    assert worded(text_template("search.txt"), search=record) == said


# The quantity that opens the report of each example.
OPENING = {
    **dict.fromkeys(("holes", "aluminium", "oblique", "smoke"), ("hole_diameter",)),
    **dict.fromkeys(("sphere", "craters"), ("crater_depth",)),
    **{"plate": ("plateau_pressure",), "bar": ("contact_time",), "taylor": ("final_length",)},
}
NUMBER = re.compile(r"\d+(?:\.\d+)?")


@pytest.mark.claim("report", "headline", minutes=7.0)
@pytest.mark.parametrize("name", [name for name in OPENING if name in examples.names()])
def test_headline__of_the_sweeps_that_ship_is_short_and_has_their_numbers(
    name: str, tmp_path: Path, compared: Callable[..., None]
) -> None:
    """Of each demo and example the headline has at most 30 words, and the value of a point of the cube."""
    folder = whipple.run_sweep(read_yaml(examples.text(name), name), tmp_path, keep="numbers")
    headline = json.loads((folder / "report.json").read_text("utf-8"))["headline"]
    with xr.open_dataset(folder / "cube.nc") as dataset:
        found = [dataset[each].values for each in OPENING[name]]
    values = [float(value) * factor for each in found for value in each.ravel() for factor in (1e3, 1e6, 1e-6, 1e-9)]
    text = headline.replace("\u202f", "").partition(": ")[2] if name == "aluminium" else headline.replace("\u202f", "")
    first = float(NUMBER.findall(text)[0])
    close = any(math.isclose(first, value, rel_tol=6e-3) for value in values)
    compared(at_most(f"{name}: words of {headline}", limit=MOST_WORDS, got=len(headline.split())))
    compared(equal(f"{name}: its first number is a value of the cube", expected=True, got=close))
