"""The rule of the choice, as docs/recipe.md states it."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from studies.cases.verification import contact, plate_impact
from studies.quantities.measured import ENERGY_DRIFT_LIMIT

OTHER_SHAPES = plate_impact.PRESSURE["gimp"]  # whatever is not named there is held to this
# Largest mean change of the Taylor bar's lengths from 10 to 20 cells per diameter and from 20 to 40, which halves at
# first order. The gate is this convergence: the constants of the strength were fitted with another code, on one grid.
TAYLOR_CHANGES = (0.02, 0.01)
CHANGES = {"32": 0.08, "64": 0.02}  # of the mean hole, from the grid before

Figures = Mapping[str, Any]
Results = Mapping[str, Figures]
Holes = Mapping[str, Mapping[str, list[float]]]  # by speed and cells, one for each sub-cell position, m


def runs(figures: Figures) -> Iterator[Figures]:
    """Every hole and the crater of a variant; the viscosities of the scan have none."""
    for holes in figures.get("holes", {}).values():
        yield from holes.values()
    if "crater" in figures:
        yield figures["crater"]


def failures(figures: Figures) -> list[str]:
    """The reasons to exclude a variant: runs that failed, drifted or ran away."""
    found = []
    for one in (*runs(figures), *figures["shocks"].values()):
        if one["state"] != "succeeded":
            found.append(str(one["reason"]))
            continue
        if abs(one["energy_drift"]) > ENERGY_DRIFT_LIMIT:
            found.append(f"energy drift {one['energy_drift']:.1%}")
        if "runaway_particles" in one.get("flags", ()):
            found.append("runaway particles")
    return found


def margins(figures: Figures) -> dict[str, float]:
    """How far each gate is from being missed, as a part of it; negative where it is, -inf where nothing is known."""
    shocks = list(figures["shocks"].values())
    limits = {
        "P": ("pressure", plate_impact.PRESSURE.get(figures["recipe"]["shape"], OTHER_SHAPES)),
        "Us": ("shock_speed", plate_impact.SHOCK_SPEED),
        "density": ("particle_density", plate_impact.DENSITY),
        "spacing": ("spacing_density", plate_impact.DENSITY),
    }
    found = {
        word: min(1.0 - abs(error) / limit for one in shocks for error in one.get(name, [math.inf]))
        for word, (name, limit) in limits.items()
    }
    bar, least = figures["bar"], contact.REBOUND
    taylor = figures["taylor"].get("changes", (math.inf, math.inf))
    found["contact"] = 1.0 - abs(bar.get("time", math.inf)) / contact.CONTACT_TIME
    found["rebound"] = (bar.get("rebound", -math.inf) - least) / (1.0 - least)
    found["Taylor"] = min(1.0 - change / limit for change, limit in zip(taylor, TAYLOR_CHANGES, strict=True))
    found["Noh"] = 1.0 - float(figures["noh"].get("part", math.inf))
    return found


def missed(figures: Figures) -> list[str]:
    """The gates that a variant does not hold."""
    return [word for word, margin in margins(figures).items() if margin < 0.0]


def eligible(figures: Figures) -> bool:
    """Whether nothing failed and every gate is held."""
    return not failures(figures) and not missed(figures)


def scatter(figures: Figures) -> float:
    """Mean scatter of the pressure behind the shocks."""
    values = [value for one in figures["shocks"].values() for value in one.get("scatter", [])]
    return sum(values) / len(values) if values else math.nan


def candidates(scanned: Results) -> list[str]:
    """The candidate of each shape and number of particles with an eligible viscosity, the cheapest first."""

    def price(name: str) -> float:
        return float(scanned[name]["coarse_hole"].get("seconds", math.inf))

    best: dict[tuple[str, int], str] = {}
    for name, figures in scanned.items():
        kind = figures["recipe"]["shape"], figures["recipe"]["particles_per_cell"]
        if eligible(figures) and (kind not in best or scatter(figures) < scatter(scanned[best[kind]])):
            best[kind] = name
    return sorted(best.values(), key=price)


def change_of_hole(figures: Figures, speed: str) -> float | None:
    """(D(4) - D(8)) / D(8) at one sub-cell position, or None where a hole is missing."""
    coarse, fine = (figures["holes"][speed][cells].get("hole_diameter") for cells in ("16", "32"))
    return None if coarse is None or fine is None else float(coarse / fine - 1.0)


def cost(figures: Figures, speed: str) -> float | None:
    """Processor seconds of the finer hole."""
    seconds = figures["holes"][speed]["32"].get("seconds")
    return None if seconds is None else float(seconds)


def total_cost(figures: Figures) -> float:
    """Processor seconds of the finer holes."""
    costs = [cost(figures, speed) for speed in figures["holes"]]
    return sum(math.inf if seconds is None else seconds for seconds in costs)


def mean_holes(final: Holes) -> dict[str, dict[str, float]]:
    """Hole by speed and cells, mean over the sub-cell positions, m."""
    return {
        speed: {cells: sum(values) / len(values) for cells, values in grids.items()} for speed, grids in final.items()
    }


def final_changes(final: Holes, cells: str) -> list[float]:
    """Relative changes of the mean hole to a grid from the one before, speed by speed."""
    before = str(int(cells) // 2)
    return [holes[cells] / holes[before] - 1.0 for holes in mean_holes(final).values()]


def converges(final: Holes) -> bool:
    """Whether the mean hole changes by no more than it may."""
    return all(abs(change) <= limit for cells, limit in CHANGES.items() for change in final_changes(final, cells))


def winner(scanned: Results, finals: Results) -> str:
    """The name of the candidate that the rule chooses; raises ValueError where none holds."""
    for name in candidates(scanned):
        if converges(finals[name]["holes"]):
            return name
    raise ValueError("no candidate holds the gates and converges")
