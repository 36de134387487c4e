"""A sweep: a scenario, fixed parameters, axes to vary; checked, canonical, expanded into runs."""

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

from solver.units import Described
from studies import materials as shipped
from studies import scenarios
from studies.convergence.experience import MOST_CELLS
from studies.materials import Material
from studies.observations import Observation, written
from studies.observations.compared import ComparedShots, compared_shots
from studies.quantities.findings import MOST_FINDINGS, Finding, InvalidInput, refusal
from studies.quantities.parameters import LongText, Plain, Value, declared, marks
from studies.quantities.units import round_quantity
from studies.runs.run import Run, resolve
from studies.sweeps.accuracy import cells_of, in_percent
from studies.sweeps.axes import Axis
from studies.sweeps.grid import Grid, Place, product
from studies.sweeps.reading import (
    END,
    MOST_PARTICLES,
    OFFSET,
    RESOLUTION,
    Combine,
    ModelPartChoice,
    SweepLimits,
    read_sweep,
    vocabulary,
)
from studies.sweeps.sampling import Sampling
from studies.sweeps.search import Chance, LimitOutcome, Search, SearchedLimit, guide_of, replay

if TYPE_CHECKING:
    from studies.laws import Shot
    from studies.laws.documents import OwnLaw
    from studies.sweeps.screening import Screen

SCREENING = "screening"  # in place of the coordinates of a run that screens the models
MOST_REFUSED = 200  # points, after which the others are not checked


@dataclass(frozen=True)
class Point:
    """One run of a sweep, in its place."""

    index: tuple[int, ...]  # one number an axis (grid), or one (else); then one a refinement
    coordinates: Mapping[str, Value]  # SI, by axis name
    run: Run


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A checked sweep: every value in SI, at 12 significant digits."""

    name: str
    title: str
    scenario: str
    fixed: Mapping[str, Value]  # by parameter name or dotted material path
    axes: tuple[Axis, ...]
    combine: Combine  # their product, pairs, or points sampled from their ranges
    resolutions: tuple[float, ...]  # cells per projectile diameter; empty: it is fixed or an axis
    offsets: int = 1  # sub-cell positions of the grid for each resolution, evenly over a cell
    materials: Mapping[str, Material] = field(default_factory=dict)  # the user's own, by name
    observations: tuple[Observation, ...] = ()
    sampling: Sampling | None = None  # where the axes are sampled
    # Laws that are compared beside the published ones; they change no run.
    laws: "tuple[OwnLaw, ...]" = ()
    # Mesh error of each point, relative, from which its cells follow; None where they are stated.
    accuracy: float | None = None
    # What it chose for each point (one for all values of a searched axis) when the sweep was accepted, which keeps its
    # runs, whatever experience tells later. Empty, or None of a point: chosen by present experience.
    cells: tuple[float | None, ...] = field(default=(), compare=False)
    # Where the uncertainty of the models comes from: stored sensitivities, screening runs, or nowhere.
    model_part: ModelPartChoice = "stored"
    # Points with a latest end of their own: the value of each axis, and the end (s). Their runs are ordinary ones.
    ends: tuple[tuple[Mapping[str, Value], float], ...] = ()
    # Limit of the service, not of the user.
    max_particles: int = field(default=MOST_PARTICLES, compare=False)

    @staticmethod
    def parse(document: object, limits: SweepLimits | None = None) -> "Sweep":
        """The sweep of a document; raises InvalidInput. Conditions between parameters are checked by ``runs()``."""
        limits = limits or SweepLimits()
        sweep = read_sweep(Sweep, document, limits)
        if sweep.most_runs > limits.max_runs:
            size, limit = f"{sweep.most_runs} runs", f"at most {limits.max_runs} runs"
            raise InvalidInput([Finding("axes", size, limit, "take fewer values, resolutions or offsets")])
        return sweep

    @property
    def definition(self) -> scenarios.Scenario:
        """The scenario of that name."""
        return scenarios.load(self.scenario)

    @property
    def refinements(self) -> tuple[Axis, ...]:
        """The axes over which each point is refined: resolution, offset, both or neither."""
        positions = tuple(round_quantity(place / self.offsets) for place in range(self.offsets))
        both = (Axis(RESOLUTION, "1", self.resolutions), Axis(OFFSET, "1", positions))
        return tuple(axis for axis in both if len(axis.values) > 1)

    @cached_property
    def grid(self) -> Grid:
        """The places of its runs."""
        return Grid(self.axes, self.combine, self.refinements)

    @property
    def size(self) -> int:
        """The number of runs."""
        return self.grid.size

    @property
    def search(self) -> Search | None:
        """The search for a limit on one of its axes."""
        return next((axis.search for axis in self.axes if axis.search), None)

    @property
    def most_runs(self) -> int:
        """The most runs: those of every try where a limit is searched."""
        starts = [(len(axis.values), axis.search.most_tries) for axis in self.axes if axis.search]
        return self.size // starts[0][0] * starts[0][1] if starts else self.size

    def limits(self, outcome_of: Callable[[Run], LimitOutcome | str]) -> list[tuple[dict[str, Value], SearchedLimit]]:
        """The limit at each point of the other axes, from the outcomes of runs or the states of unfinished ones."""
        search = self.search
        assert search is not None

        def limit_at(at: Mapping[str, Value]) -> SearchedLimit:
            return replay(search, lambda value: self._agreed(outcome_of, {**at, search.axis: value}), self._chance(at))

        return [(at, limit_at(at)) for _, at in product(tuple(axis for axis in self.axes if not axis.search))]

    def _agreed(self, outcome_of: Callable[[Run], LimitOutcome | str], at: Mapping[str, Value]) -> LimitOutcome | str:
        """The outcome of all runs of a point; None where they disagree, and the state of one that has not ended."""
        said = [outcome_of(self._run({**at, **refined})) for _, refined in product(self.refinements)]
        unfinished = next((outcome for outcome in said if isinstance(outcome, str)), None)
        return unfinished or (said[0] if len({*said}) == 1 else None)

    def tried(self, limits: Sequence[tuple[Mapping[str, Value], SearchedLimit]]) -> "Sweep":
        """The values that a search tried so far, as pairs with those of the other axes."""
        assert self.search is not None
        points = [{**at, self.search.axis: value} for at, limit in limits for value in limit.tried]
        axes = tuple(
            replace(axis, values=tuple(point[axis.name] for point in points), search=None) for axis in self.axes
        )
        cells = () if self.accuracy is None else tuple(self._cells_at(point) for point in points)
        return replace(self, axes=axes, combine="zip", cells=cells)

    def document(self) -> dict[str, Plain]:
        """The sweep as plain values that ``parse`` reads as itself; the order of axes counts."""
        terms = vocabulary(self.scenario, self.roles(), self.materials)

        def in_units(values: Mapping[str, Value]) -> dict[str, Plain]:
            return {name: written(value, terms.parameters[name].unit) for name, value in values.items()}

        document: dict[str, Plain] = {
            "name": self.name,
            "title": self.title,
            "scenario": self.scenario,
            "fixed": in_units(self.fixed),
            "axes": {axis.name: axis.document() for axis in self.axes},
            "combine": self.combine,
            "points": self.sampling.points if self.sampling else None,
            "seed": self.sampling.seed if self.sampling else None,
            "resolution": list(self.resolutions) if len(self.resolutions) > 1 else next(iter(self.resolutions), None),
            "offsets": self.offsets if self.offsets > 1 else None,
            "accuracy": None if self.accuracy is None else in_percent(self.accuracy),
            "cells": None if self.accuracy is None else [*self._every_cells()],
            "materials": {name: material.document() for name, material in self.materials.items()},
            "observations": [shot.document(terms) for shot in self.observations],
            "laws": [law.document() for law in self.laws],
            "model_part": None if self.model_part == "stored" else self.model_part,
            "ends": [in_units({**at, END: end}) for at, end in self.ends],
        }
        return {key: value for key, value in document.items() if value not in (None, {}, [])}

    def runs(self) -> list[Point]:
        """All runs, the last axis fastest; raises InvalidInput naming the refused points."""
        return [*self._drawn_runs(self.size)]

    def _drawn_runs(self, most: int) -> Iterator[Point]:
        """All runs, or so many drawn evenly; raises InvalidInput after the last, naming the refused points."""
        findings: dict[Finding, str] = {}
        refused = 0
        chosen = {*random.Random(0).sample(range(self.size), min(most, self.size))}
        for number, (index, coordinates) in enumerate(self._places()):
            if number not in chosen:
                continue
            try:
                for at in (*self._ends_of(coordinates), coordinates):
                    resolved = self._run(at)
            except InvalidInput as error:
                place = ", ".join(
                    f"{axis.name} = {written(at[axis.name], axis.unit)}" for axis in (*self.axes, *self.refinements)
                )
                findings |= {finding: place for finding in error.findings if finding not in findings}
                refused += 1
                if len(findings) >= MOST_FINDINGS or refused >= MOST_REFUSED:
                    break
            else:
                yield Point(index, coordinates, resolved)
        if findings:
            raise InvalidInput(
                replace(finding, value=f"{finding.value} (at {place})") for finding, place in findings.items()
            )

    def computed_runs(self, is_computed: Sequence[bool]) -> Iterator[tuple[Place, Run | None]]:
        """All places in the order of ``runs``; those that are not computed have no run, which would cost most time."""
        for number, (index, coordinates) in enumerate(self._places()):
            yield (index, coordinates), self._run(coordinates) if is_computed[number] else None

    def coordinates(self) -> list[dict[str, Value]]:
        """The values of the axes at each point, before it is refined; SI, by axis name."""
        return [at for _, at in self._points()]

    def of_point(self, at: Mapping[str, Value]) -> "Sweep":
        """The sweep of a single run of this one, by its coordinates (SI): the same run, and nothing beside it."""
        axes = (*self.axes, *self.refinements)
        end, cells = self._own_ends.get(self.grid.key(at)), self._cells_at(at)
        return replace(
            self,
            fixed={**self.fixed, **({} if end is None else {END: end})},
            axes=tuple(Axis(axis.name, axis.unit, (at[axis.name],)) for axis in axes),
            combine="grid",
            sampling=None,
            resolutions=() if cells is None else (cells,),
            offsets=1,
            accuracy=None,
            cells=(),
            observations=(),
            model_part="none",
            ends=(),
        )

    def each_constants(self, most: int) -> Iterator[tuple[dict[str, Value], dict[str, Material]]]:
        """Parameters and materials by role of points that differ in constants; of more than so many, of some.

        Those are even ones and the last. Axes of what is no constant have their first values.
        """
        record, kinds = self.definition.parameters, self.definition.materials
        # Those of the scenario that are constants of matter, and the texts that may have some.
        usual = {name for name, mark in marks(record, Described).items() if mark.usual is not None}
        constants = {*kinds, *usual, *marks(record, LongText)}
        chosen = [axis.name for axis in self.axes if axis.name in constants or "." in axis.name]
        distinct: dict[tuple[Value, ...], dict[str, Value]] = {}
        for _, at in self.grid.points:
            distinct.setdefault(tuple(at[name] for name in chosen), at)
        points = [*distinct.values()]
        some = points[:: -(-len(points) // most)]
        for at in [*some, points[-1]] if some[-1] is not points[-1] else some:
            values = {**self.fixed, **at}
            yield values, self._materials_at(values)

    def shots(self) -> "Iterator[Shot]":
        """The shot of each point, before it is refined; none where the scenario describes none."""
        for _, coordinates in self._points():
            shot = self.shot_at(coordinates)
            if shot is not None:
                yield shot

    def shot_at(self, coordinates: Mapping[str, Value]) -> "Shot | None":
        """The shot with some values beside the fixed ones; None where the scenario describes none."""
        from studies.laws import shot_from

        defaults = declared(self.definition.parameters)
        values = {**self.fixed, **coordinates}
        with suppress(KeyError):
            return shot_from(
                {**{name: parameter.default for name, parameter in defaults.items()}, **values},
                self._materials_at(values),
            )
        return None

    def screening(self) -> "tuple[Run, list[Screen]]":
        """The run in the middle of the sweep, on the finest grid, and its changes; raises InvalidInput."""
        from studies.sweeps.screening import screens_of

        finest = {axis.name: axis.values[-1] for axis in self.refinements if axis.name == RESOLUTION}
        first = {axis.name: axis.values[0] for axis in self.refinements if axis.name == OFFSET}
        chosen = self._run({**self.grid.middle, **finest, **first})
        return chosen, list(screens_of(chosen, self.materials.values()))

    def every_run(self, most: int | None = None) -> Iterator[Point]:
        """The runs of all points (of ``most``, drawn evenly), and those that screen its models.

        The latter have no place on its axes. Raises InvalidInput as ``runs`` does, after the last point.
        """
        yield from self._drawn_runs(self.size if most is None else most)
        if self.model_part == "screen":
            _, screens = self.screening()
            for screen in screens:
                if screen.run is not None:
                    yield Point((), {SCREENING: screen.name}, screen.run)

    def roles(self) -> dict[str, tuple[str, ...]]:
        """The names of the materials that each material parameter takes."""
        scenario = self.definition
        varied = {axis.name: axis.values for axis in self.axes}
        defaults = declared(scenario.parameters)
        values = {
            role: varied.get(role, (self.fixed.get(role, defaults[role].default),)) for role in scenario.materials
        }
        return {role: tuple(str(name) for name in names if name is not None) for role, names in values.items()}

    def material(self, name: str) -> Material:
        """A material by name: the user's own, or one that ships."""
        return self.materials[name] if name in self.materials else shipped.load(name)

    def compared_shots(self) -> list[ComparedShots]:
        """What whipple gives for published shots of these quantities, on targets of the same families of materials."""
        roles = self.roles()
        targets = roles.get("target") or tuple(name for names in roles.values() for name in names)
        families = {self.material(name).family for name in targets}
        quantities = self.definition.measurements
        return [
            shots
            for shots in compared_shots()
            if shots.quantity in quantities and shipped.load(shots.materials[-1]).family in families
        ]

    def _places(self) -> Iterator[Place]:
        """Index and coordinates of every run."""
        for place, at in self._points():
            for step, refined in product(self.refinements):
                yield place + step, at | refined

    def _points(self) -> Iterator[Place]:
        """Index and coordinates of every point, before it is refined; of a guided search with the value to start at."""
        return ((place, self._started(at)) for place, at in self.grid.points)

    def _started(self, at: dict[str, Value]) -> dict[str, Value]:
        """The values of a point; of a guided search the one with which it starts there."""
        search = self.search
        if search is None or search.until is None:
            return at
        (first,) = search.start(self._chance(at))
        return {**at, search.axis: first}

    def _ends_of(self, at: Mapping[str, Value]) -> Iterator[dict[str, Value]]:
        """The points at both ends of a guided search, which starts between them; none of another search or sweep."""
        search = self.search
        if search is not None and search.until is not None:
            yield from ({**at, search.axis: end} for end in (search.low, search.high))

    def _chance(self, at: Mapping[str, Value]) -> Chance | None:
        """The chance that a searched limit lies below a value; None where nothing tells it."""
        search = self.search
        if search is None or search.until is None:
            return None
        guide = guide_of(search.quantity, search.axis)
        shot = guide and self.shot_at({**at, search.axis: search.start()[0]})
        return guide.chance(shot) if guide and shot else None

    def _run(self, coordinates: Mapping[str, Value]) -> Run:
        """The run of a point, which fits into a machine."""
        values, cells = self._values(coordinates), self._cells_at(coordinates)
        if cells is not None:
            values[RESOLUTION] = cells
        run = self._resolved(values)
        particles = run.set_up.size(run.materials).particles
        if particles > self.max_particles:
            count = f"about {particles:.2g} particles"
            limit = f"at most {self.max_particles:.12g} in a run"
            raise InvalidInput([Finding("particles", count, limit, "take fewer cells, or smaller bodies")])
        return run

    def _values(self, coordinates: Mapping[str, Value]) -> dict[str, Value]:
        """The values of a point, but for its cells."""
        values = {**self.fixed, **coordinates}
        end = self._own_ends.get(self.grid.key(coordinates))
        return values if end is None else {**values, END: end}

    def _resolved(self, values: Mapping[str, Value]) -> Run:
        parameters = {name: value for name, value in values.items() if "." not in name}
        return resolve(self.scenario, parameters, self._materials_at(values))

    def _cells_at(self, coordinates: Mapping[str, Value]) -> float | None:
        """The cells of a point: the one resolution, or what the accuracy asks for; None where they are coordinates."""
        if self.accuracy is None:
            return self.resolutions[0] if len(self.resolutions) == 1 else None
        key = self.grid.key_of_cells(coordinates)
        if key not in self._chosen:
            # Each try of a search has the same grid; an error is largest at one of the ends.
            search = self.search
            ends = [] if search is None else [{search.axis: search.low}, {search.axis: search.high}]
            points = [{**coordinates, **end} for end in ends or [{}]]
            finest = declared(self.definition.parameters)[RESOLUTION].bounds.nearest(float(MOST_CELLS))
            runs = (self._resolved({**self._values(point), RESOLUTION: finest}) for point in points)
            self._chosen[key] = max(cells_of(run, self.accuracy) for run in runs)
        return self._chosen[key]

    @cached_property
    def _chosen(self) -> dict[tuple[Value, ...], float]:
        """The cells of points by ``Grid.key_of_cells``, as far as they are known."""
        stored = zip(self.grid.of_cells, self.cells, strict=True) if self.cells else ()
        return {self.grid.key_of_cells(at): cells for at, cells in stored if cells is not None}

    def _every_cells(self) -> Iterator[float | None]:
        """What the accuracy chooses for each point; None where it cannot be had, which ``runs`` refuses."""
        for at in self.grid.of_cells:
            try:
                yield self._cells_at(at)
            except InvalidInput:
                yield None

    @cached_property
    def _own_ends(self) -> dict[tuple[Value, ...], float]:
        return {self.grid.key(at): end for at, end in self.ends}

    def _materials_at(self, values: Mapping[str, Value]) -> dict[str, Material]:
        """The materials by role, of those that are named, with the constants among the values of a point."""
        defaults = declared(self.definition.parameters)
        names = {role: values.get(role, defaults[role].default) for role in self.definition.materials}
        materials = {role: self.material(str(name)) for role, name in names.items() if name is not None}
        for path, value in values.items():
            role, dot, constant = path.partition(".")
            if dot:
                if role not in materials:
                    raise refusal(path, value, f"a constant of a material that {role} names", f"give {role}")
                assert value is None or isinstance(value, float)
                materials[role] = materials[role].with_value(constant, value)
        return materials
