"""The rule of the choice, as stated beforehand in the folder's docstring."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

DRIFT, PRESSURE, SHOCK_SPEED = 0.01, 0.015, 0.01
EQUAL = 0.005  # of the hole: variants this near to the best count as equal
COARSE, FINE = "16", "32"  # cells across the diameter: 4 and 8 through the plate

Figures = Mapping[str, Any]


def runs(figures: Figures) -> Iterator[Figures]:
    """Every hole and the crater of a variant."""
    for holes in figures["holes"].values():
        yield from holes.values()
    yield figures["crater"]


def failures(figures: Figures) -> list[str]:
    """Why a variant is out: runs that failed, drifted or ran away."""
    found = []
    for one in (*runs(figures), *figures["shocks"].values()):
        if one["state"] != "succeeded":
            found.append(str(one["reason"]))
            continue
        drift = one.get("energy_drift", one.get("drift"))
        if abs(drift) > DRIFT:
            found.append(f"energy drift {drift:.1%}")
        if "runaway_particles" in one.get("flags", ()):
            found.append("runaway particles")
    return found


def eligible(figures: Figures) -> bool:
    """Whether nothing failed and the shocks are right."""
    return not failures(figures) and all(
        abs(shock["pressure"]) <= PRESSURE and abs(shock["shock_speed"]) <= SHOCK_SPEED
        for shock in figures["shocks"].values()
    )


def change_of_hole(figures: Figures, speed: str) -> float | None:
    """(D(4) - D(8)) / D(8), or None where a hole is missing."""
    coarse, fine = (figures["holes"][speed][cells].get("hole_diameter") for cells in (COARSE, FINE))
    return None if coarse is None or fine is None else float(coarse / fine - 1.0)


def cost(figures: Figures, speed: str) -> float | None:
    """Processor seconds of the finer hole."""
    seconds = figures["holes"][speed][FINE].get("seconds")
    return None if seconds is None else float(seconds)


def score(figures: Figures) -> float:
    """Sum of |D(8) - D(4)| / D(8) over the speeds; infinite where there is none."""
    changes = [change_of_hole(figures, speed) for speed in figures["holes"]]
    return sum(math.inf if change is None else abs(change) for change in changes)


def total_cost(figures: Figures) -> float:
    """Processor seconds of the finer holes."""
    costs = [cost(figures, speed) for speed in figures["holes"]]
    return sum(math.inf if seconds is None else seconds for seconds in costs)


def winner(results: Mapping[str, Figures]) -> str:
    """The name of the variant that the rule chooses; raises ValueError where none is eligible."""
    fit = {name: figures for name, figures in results.items() if eligible(figures)}
    if not fit:
        raise ValueError("no variant holds the shock states")
    best = min(score(figures) for figures in fit.values())
    equal = [name for name, figures in fit.items() if score(figures) <= best + EQUAL]
    return min(equal, key=lambda name: total_cost(fit[name]))
