"""The stored experience of mesh errors, fitted to the ensemble anew: ``python -m docs.mesh_fit``.

By the rule of docs/pages/mesh_error.py, which was written before the ensemble was computed: series that count, terms
of the bias, maximum likelihood, groups that are left out, and the domain.
"""

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cache

import numpy as np
from scipy.optimize import minimize

from docs.pages import mesh_error as ensemble
from solver import PHYSICS_VERSION
from studies.convergence.experience import (
    FREEDOM,
    NINETY_FIVE,
    STORED,
    Domain,
    Experience,
    MeshGrid,
    MeshModel,
    bias_terms,
    combined,
    scale_terms,
)

LOWERS = 0.9  # share of what is left of left-out metals, to which a further term must lower it
LEAST_SCALE = 1e-4  # relative: below what any run resolves
HELD = (0.90, 0.99)  # share of left-out differences that intervals of 95 % hold
FEWEST_SERIES = 0.8  # share of the series that a domain keeps
FURTHER = ("strength", "density")  # factors beside 1
THICKNESSES, SPEEDS = (0.15, 0.4), (3e3, 5.5e3)  # t/d, and m/s, between bands
DIGITS = 6

# From one domain to the next narrower one: the field of a grid, and its new least value.
NARROWER = (("through", 3.0), ("through", 4.0), ("across", 14.0), ("speed", 2e3), ("speed", 2.5e3), ("thickness", 0.1))


@dataclass(frozen=True)
class Value:
    """A quantity on one grid of a series."""

    grid: MeshGrid
    value: float


@dataclass(frozen=True)
class Shot:
    """A series that counts, the finest grid last."""

    number: int
    kind: str
    metal: str  # name of the material of the target or bar
    values: tuple[Value, ...]

    @property
    def finest(self) -> Value:
        """What the others are compared with."""
        return self.values[-1]

    def inside(self, domain: Domain) -> "Shot | None":
        """The series on the grids that a domain has; None where its finest grid or all others are outside."""
        kept = tuple(each for each in self.values if not domain.why_not(each.grid))
        return replace(self, values=kept) if len(kept) > 1 and kept[-1] == self.finest else None


# ---- what counts ---------------------------------------------------------------------------------


@cache
def shots() -> Mapping[str, tuple[Shot, ...]]:
    """The series that count, by quantity."""
    rows = {row["id"]: row for row in ensemble.stored() if row["physics"] == str(PHYSICS_VERSION)}
    found: dict[str, list[Shot]] = {}
    for series in ensemble.drawn():
        computed = [(run, rows[run.id]) for _, _, run in series.runs() if run.id in rows]
        for quantity in ensemble.QUANTITIES[series.scenario]:
            values = tuple(
                Value(run.mesh_grids[quantity], float(row[quantity]))
                for run, row in computed
                if row["state"] == "succeeded" and row[quantity]
            )
            complete = len(computed) == len(series.grids) and values and values[-1].grid.across == series.grids[-1][0]
            if complete and len(values) > 1:
                metal = str(series.parameters.get("target") or series.parameters["bar"])
                found.setdefault(quantity, []).append(Shot(series.number, series.kind, metal, values))
    return {quantity: tuple(each) for quantity, each in found.items()}


def is_complete(quantity: str) -> bool:
    """Whether every run of the ensemble that measures a quantity is in the table."""
    rows = {row["id"] for row in ensemble.stored() if row["physics"] == str(PHYSICS_VERSION)}
    return all(
        run.id in rows
        for series in ensemble.drawn()
        if quantity in ensemble.QUANTITIES[series.scenario]
        for _, _, run in series.runs()
    )


# ---- fitted --------------------------------------------------------------------------------------


def terms_of(shots: Sequence[Shot]) -> tuple[list[str], list[list[str]]]:
    """The terms of a smallest model, and those that are added one group after the other where they help."""
    kinds = {shot.kind for shot in shots}
    if kinds & {"plate", "cloud"}:
        return ["through", "across"], [[f"through {name}", f"across {name}"] for name in FURTHER]
    names = FURTHER if "block" in kinds else FURTHER[:-1]
    return ["across"], [*([f"across {name}"] for name in names), ["across squared"]]


def fit(shots: Sequence[Shot], wider: float = 1.0) -> MeshModel:
    """The model of some series, with the further terms that predict metals which they were not fitted to.

    Its scale is so many times that of the fit.
    """
    names, further = terms_of(shots)
    left = _left(shots, names)
    for group in further:
        tried = _left(shots, [*names, *group])
        if tried <= LOWERS * left:
            names, left = [*names, *group], tried
    model = fitted(shots, names)
    return replace(model, scale={name: wider * value for name, value in model.scale.items()})


def _left(shots: Sequence[Shot], names: Sequence[str]) -> float:
    """Median size of what a model leaves of metals that it was not fitted to."""
    left = []
    for inside, outside in left_out(shots, lambda shot: shot.metal):
        model = fitted(inside, names)
        left += [abs(difference - expected) for difference, expected, _ in differences(model, outside)]
    return float(np.median(left))


def left_out(shots: Sequence[Shot], group: Callable[[Shot], str]) -> Iterator[tuple[list[Shot], list[Shot]]]:
    """The series but for one group, and that group, for each; of one group alone nothing can be left out."""
    names = sorted({group(shot) for shot in shots})
    for name in names if len(names) > 1 else ():
        yield [shot for shot in shots if group(shot) != name], [shot for shot in shots if group(shot) == name]


def differences(model: MeshModel, shots: Iterable[Shot]) -> Iterator[tuple[float, float, float]]:
    """ln(value / value on the finest grid) of each coarser grid, as it is and as a model expects it, and its scale."""
    for shot in shots:
        finest = model.error_on(shot.finest.grid)
        for each in shot.values[:-1]:
            error = model.error_on(each.grid)
            seen = math.log(each.value / shot.finest.value)
            yield seen, error.bias - finest.bias, math.hypot(error.scale, finest.scale)


def fitted(shots: Sequence[Shot], names: Sequence[str]) -> MeshModel:
    """The most likely model with these terms of the bias."""
    pairs = [
        (value.grid, shot.finest.grid, math.log(value.value / shot.finest.value))
        for shot in shots
        for value in shot.values[:-1]
    ]
    design = np.array([[bias_terms(a)[name] - bias_terms(b)[name] for name in names] for a, b, _ in pairs])
    squares = np.array(
        [
            [x**2 + y**2 for x, y in zip(scale_terms(a).values(), scale_terms(b).values(), strict=True)]
            for a, b, _ in pairs
        ]
    )
    values = np.array([value for _, _, value in pairs])
    used: np.ndarray = squares.max(axis=0) > 0.0
    squares = squares[:, used]
    start = np.linalg.lstsq(design, values, rcond=None)[0]
    size = max(float(np.median(np.abs(values - design @ start))), 10.0 * LEAST_SCALE)
    logs = np.log(size / np.sqrt(squares.mean(axis=0) * squares.shape[1]))

    def unlikely(parameters: np.ndarray) -> tuple[float, np.ndarray]:
        """Minus the logarithm of the likelihood, and its gradient."""
        bias, shares = parameters[: len(names)], squares * np.exp(2.0 * parameters[len(names) :])
        # Sums without BLAS, whose threads cost more than they save on matrices of a few columns.
        left, variance = values - (design * bias).sum(axis=1), shares.sum(axis=1) + LEAST_SCALE**2
        square = left**2 / variance
        pull = (FREEDOM + 1.0) / (FREEDOM + square)
        of_variance = 0.5 * (1.0 - pull * square) / variance
        weights = (pull * left / variance)[:, None], 2.0 * of_variance[:, None]
        gradient = [-(weights[0] * design).sum(axis=0), (weights[1] * shares).sum(axis=0)]
        value = 0.5 * (np.log(variance) + (FREEDOM + 1.0) * np.log1p(square / FREEDOM)).sum()
        return float(value), np.concatenate(gradient)

    # A part of the scale that the data do not show tends to nothing.
    bounds = [(None, None)] * len(names) + [(math.log(LEAST_SCALE) - 5.0, None)] * len(logs)
    found = minimize(unlikely, np.concatenate([start, logs]), jac=True, method="L-BFGS-B", bounds=bounds)
    scale = np.zeros(len(used))
    scale[used] = np.exp(found.x[len(names) :])
    return MeshModel(
        {name: float(value) for name, value in zip(names, found.x, strict=False)},
        dict(zip(scale_terms(pairs[0][0]), map(float, scale), strict=True)),
    )


# ---- tested --------------------------------------------------------------------------------------


def _band(value: float, ends: tuple[float, float]) -> str:
    return "low" if value < ends[0] else "high" if value > ends[1] else "between"


GROUPS: Mapping[str, Callable[[Shot], str]] = {
    "metal": lambda shot: shot.metal,
    "speed": lambda shot: _band(shot.finest.grid.speed, SPEEDS),
    "t/d": lambda shot: _band(shot.finest.grid.thickness, THICKNESSES),
}


@cache
def _sizes_left_out(shots: tuple[Shot, ...]) -> dict[str, list[float]]:
    """Sizes of the differences of series that a model was not fitted to, by group."""
    plates = all(math.isfinite(shot.finest.grid.through) for shot in shots)
    groups = {name: group for name, group in GROUPS.items() if plates or name != "t/d"}
    found = {
        name: sizes((fit(inside), outside) for inside, outside in left_out(shots, group))
        for name, group in groups.items()
    }
    return {name: each for name, each in found.items() if each}


def sizes(tested: Iterable[tuple[MeshModel, Sequence[Shot]]]) -> list[float]:
    """How far each difference is from what a model expects, in half-widths of its interval of 95 %."""
    return [
        abs(seen - expected) / (NINETY_FIVE * scale)
        for model, shots in tested
        for seen, expected, scale in differences(model, shots)
    ]


def share_held(sizes: Sequence[float], wider: float = 1.0) -> float:
    """Share of some differences that the intervals hold, these so many times wider."""
    return sum(size <= wider for size in sizes) / len(sizes)


def wider_until_held(sizes: Iterable[Sequence[float]]) -> float:
    """The least factor, from one on, with which intervals hold the least share of each of some differences."""
    return max([1.0, *(sorted(each)[math.ceil(HELD[0] * len(each)) - 1] for each in sizes if each)])


# ---- the domain ----------------------------------------------------------------------------------


def domains(shots: Sequence[Shot]) -> Iterator[Domain]:
    """The ranges of some series, and narrower ones."""
    grids = [each.grid for shot in shots for each in shot.values]

    def ends(name: str) -> tuple[float, float]:
        values = [getattr(grid, name) for grid in grids]
        return min(values), max(values)

    domain = Domain(**{each.name: ends(each.name) for each in fields(Domain)})
    yield domain
    for name, least in NARROWER:
        low, high = getattr(domain, name)
        if low < least < high < math.inf:
            domain = replace(domain, **{name: (least, high)})
            yield domain


@dataclass(frozen=True)
class Tested:
    """Experience of a quantity, with the series and the coverage that tested it."""

    experience: Experience
    shots: tuple[Shot, ...]  # of one plane, inside of the domain
    of: int  # series that count
    wider: float  # factor of the scale, with which left-out differences are held
    covered: Mapping[str, tuple[float, int]]  # share of the left-out differences that is held, of how many; by group

    @property
    def holds(self) -> bool:
        """Whether left-out series lie where they should, and bars are narrow."""
        covered = all(HELD[0] <= share <= HELD[1] for share, _ in self.covered.values())
        return covered and self.widest_bar <= ensemble.WIDEST_BAR

    @property
    def widest_bar(self) -> float:
        """The widest bar of a series on ``ensemble.FINE`` cells inside the domain."""
        grids = [shot.finest.grid.refined(ensemble.FINE) for shot in self.shots]
        inside = [grid for grid in grids if not self.experience.domain.why_not(grid)]
        return max((self.experience.model.error_on(grid).bar for grid in inside), default=math.inf)


@cache
def tested(quantity: str) -> Tested:
    """The widest domain of a quantity in which it holds, with wider bars only where none does; else the last one."""
    plane = [shot for shot in shots()[quantity] if shot.kind != "space"]
    last = None
    for widens in (False, True):
        for domain in domains(plane):
            kept = tuple(inside for shot in plane if (inside := shot.inside(domain)))
            if len(kept) < FEWEST_SERIES * len(plane):
                break
            left = _sizes_left_out(kept)
            wider = wider_until_held(left.values()) if widens else 1.0
            covered = {name: (share_held(each, wider), len(each)) for name, each in left.items()}
            last = Tested(Experience(fit(kept, wider), domain), kept, len(plane), wider, covered)
            if last.holds:
                return last
    assert last is not None
    return last


def in_space(shots: Iterable[Shot], known: Experience) -> Experience:
    """Experience with the factor of its scale in three dimensions, with which intervals hold the least share there."""
    shots = [inside for shot in shots if (inside := shot.inside(replace(known.domain, obliquity=(0.0, math.pi))))]
    if not shots:
        return known
    factor = wider_until_held([sizes([(replace(known.model, in_space=1.0), shots)])])
    steepest = max(shot.finest.grid.obliquity for shot in shots)
    model = replace(known.model, in_space=factor)
    return Experience(model, replace(known.domain, obliquity=(0.0, steepest)))


def held_by_two(shots: Sequence[Shot], wider: float) -> tuple[int, int]:
    """Series of left-out metals whose finest value is inside the 95 % of their two coarsest grids, of how many."""
    inside = []
    for others, group in left_out(shots, GROUPS["metal"]):
        model = replace(fit(others, wider), independent=True)
        for shot in group:
            if len(shot.values) > 2:
                two = [([each.value], model.error_on(each.grid)) for each in reversed(shot.values[:2])]
                finest = model.error_on(shot.finest.grid)
                value, point = finest.corrected(shot.finest.value), combined(two)
                inside.append(abs(point.value - value) <= math.hypot(point.bar, finest.bar * value))
    return sum(inside), len(inside)


def experience_of(quantity: str) -> Experience | None:
    """Experience of a quantity to be stored; None where no domain holds."""
    test = tested(quantity)
    if not test.holds:
        return None
    count, of = held_by_two(test.shots, test.wider)
    model = replace(test.experience.model, independent=bool(of) and count / of >= HELD[0])
    in_three = [shot for shot in shots()[quantity] if shot.kind == "space"]
    known = in_space(in_three, replace(test.experience, model=model))
    return replace(known, model=rounded(known.model))


def rounded(model: MeshModel) -> MeshModel:
    """A model with the digits that are stored."""
    bias, scale = ({name: float(f"{c:.{DIGITS}g}") for name, c in part.items()} for part in (model.bias, model.scale))
    return replace(model, bias=bias, scale=scale, in_space=model.in_space and float(f"{model.in_space:.{DIGITS}g}"))


def bars_over_errors(shots: Sequence[Shot], wider: float) -> list[float]:
    """The bar on each grid over how far its corrected value is from the finest one, of left-out metals."""
    ratios = []
    for others, group in left_out(shots, GROUPS["metal"]):
        model = fit(others, wider)
        for shot in group:
            bars = [model.error_on(each.grid).bar for each in shot.values[:-1]]
            errors = [abs(seen - expected) for seen, expected, _ in differences(model, [shot])]
            ratios += [bar / max(error, LEAST_SCALE) for bar, error in zip(bars, errors, strict=True)]
    return ratios


def main() -> None:
    """Store what holds of the quantities whose runs are all computed, with how it was tested."""
    known = {}
    for quantity in filter(is_complete, shots()):
        test, experience = tested(quantity), experience_of(quantity)
        about = {
            "series": [len(test.shots), test.of],
            "covered": {name: [round(share, 3), of] for name, (share, of) in test.covered.items()},
            "wider": round(test.wider, 3),
            "widest_bar": round(test.widest_bar, 4),
            "bar_over_error": round(float(np.median(bars_over_errors(test.shots, test.wider))), 2),
        }
        print(quantity, about, experience or "unknown", flush=True)
        if experience is not None:
            known[quantity] = {**asdict(experience), "tested": about}
    STORED.write_text(json.dumps({"physics": PHYSICS_VERSION, "quantities": known}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
