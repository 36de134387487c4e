"""Reads the document of a sweep, YAML or JSON as plain values, into checked fields, or a list of all errors."""

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeVar, get_args

from studies import materials as shipped
from studies import measurements, scenarios
from studies.laws.documents import OwnLaw, read_law
from studies.materials import Material, read_own
from studies.observations import AllowedNames, Observation, read_observations, written
from studies.quantities.display import CONTROLS
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest, nearest_cure, refusal, shown
from studies.quantities.parameters import (
    Parameter,
    Plain,
    Value,
    by_place,
    declared,
    find,
    missing,
    parse_value,
    parse_values,
)
from studies.quantities.units import exact_number
from studies.sweeps.accuracy import ACCURACY, USUAL, read_accuracy, tells_errors
from studies.sweeps.axes import Axis, AxisReader, repeated
from studies.sweeps.flat import as_sweep
from studies.sweeps.sampling import METHODS, Sampling, read_range, read_sampling, sampled
from studies.sweeps.search import read_search

KEYS = (
    *("name", "title", "scenario", "fixed", "axes", "combine", "points", "seed", "resolution", "offsets", "accuracy"),
    *("cells", "materials", "observations", "laws", "model_part", "ends"),
)
Combine = Literal["grid", "zip", "latin-hypercube", "sobol"]
ModelPartChoice = Literal["stored", "screen", "none"]
COMBINATIONS: tuple[Combine, ...] = get_args(Combine)
MODEL_PARTS: tuple[ModelPartChoice, ...] = get_args(ModelPartChoice)
LONGEST_NAME = 200  # characters of a sweep's name or title
MOST_LAWS = 50  # fitted ones of a sweep
MOST_OFFSETS = 32  # offsets of one resolution; more add nothing to a scatter

Allowed = TypeVar("Allowed", bound=str)
Sweep = TypeVar("Sweep")

END = "end_time"  # the parameter that rows of "ends" set
RESOLUTION = "cells_per_diameter"  # the parameter that the word "resolution" of a document sets
OFFSET = "offset"  # and the one that the word "offsets" varies: position of the grid, in cells

# The most that could sensibly run. A particle takes 500 bytes of memory (a plate as thick as its projectile is wide, in
# three dimensions, with its nodes), 120 of a stored state and a microsecond of one core a step: 2e9 of them are 1 TB,
# 0.24 TB and half an hour a step.
MOST_PARTICLES = 2_000_000_000


@dataclass(frozen=True)
class SweepLimits:
    """Limits of the size of a sweep and of each run, checked before the sweep is expanded."""

    max_runs: int = 10_000
    max_axes: int = 20
    max_values: int = 1_000  # on one axis
    max_particles: int = MOST_PARTICLES  # of one run, as estimated


# Limits for a sweep that was already accepted, under the limits at the time of its submission.
ACCEPTED = SweepLimits(max_runs=sys.maxsize, max_particles=sys.maxsize)


def read_sweep(make: Callable[..., Sweep], document: object, limits: SweepLimits) -> Sweep:
    """What ``make`` makes of the checked fields of a document: the sweep; raises InvalidInput with every error."""
    if not isinstance(document, Mapping):
        raise refusal("sweep", document, "a mapping with scenario and axes", "see the examples")
    swept = as_sweep(document, KEYS)
    try:
        return _DocumentReading(swept, limits).sweep(make)
    except InvalidInput as error:
        if swept is document:
            raise
        # The parameters of a shot stand at the top.
        at_top = (replace(each, field=re.sub(r"^(fixed|axes)\.", "", each.field)) for each in error.findings)
        raise InvalidInput(at_top) from None


class _DocumentReading:
    """One document being read, with the findings so far."""

    def __init__(self, document: Mapping[str, Plain], limits: SweepLimits):
        self.document = document
        self.limits = limits
        self.findings = Findings()

    def sweep(self, make: Callable[..., Sweep]) -> Sweep:
        """The whole document, in the order in which one part needs another; raises InvalidInput."""
        for key in self.document:
            if key not in KEYS:
                self._refuse(str(key), key, "a key of a sweep", nearest_cure(key, KEYS))
        combine = self._choice("combine", COMBINATIONS)
        own = self._materials()
        scenario = self.findings.attempt(self._scenario)
        if scenario is None:
            raise InvalidInput(self.findings)
        self.record = declared(scenario.parameters)
        self.fixed = self.findings.attempt(by_place, self._mapping("fixed"), "fixed", scenario.parameters) or {}
        self.varied = self._mapping("axes")
        roles = {role: self._material_names(role, own) for role in scenario.materials}
        terms = vocabulary(scenario.name, roles, own)
        # A material that is refused is none that is missing.
        names = {name for name in self._mapping("materials") if isinstance(name, str)}
        terms = replace(terms, materials=sorted({*terms.materials, *names}))
        fixed = parse_values(terms.parameters, self.fixed, "fixed", self.findings, materials=terms.materials)
        self.sampling = self.findings.attempt(self._sampling, combine)
        axes = self._axes(terms, combine)
        resolutions = self.findings.attempt(self._resolutions) or ()
        offsets = self.findings.attempt(self._offsets) or 1
        accuracy = self.findings.attempt(self._accuracy, scenario)
        cells = () if accuracy is None else self.findings.attempt(self._cells) or ()
        self._check_search(axes, combine)
        self._check_completeness()
        ends = self._ends(terms, axes)
        table = self.document.get("observations")
        observations = None if table is None else self.findings.attempt(read_observations, table, terms)
        laws = self._laws(terms)
        model_part = self._choice("model_part", MODEL_PARTS)
        self._refuse_controls()
        name = self._text("name", scenario.name)
        title = self._text("title", name)
        self.findings.check()
        return make(
            name=name,
            title=title,
            scenario=scenario.name,
            fixed=fixed,
            axes=axes,
            combine=combine,
            sampling=self.sampling,
            resolutions=resolutions,
            offsets=offsets,
            accuracy=accuracy,
            cells=cells,
            materials=own,
            observations=observations or (),
            laws=laws,
            model_part=model_part,
            ends=ends,
            max_particles=self.limits.max_particles,
        )

    def _refuse(self, field: str, value: object, limit: str, cure: str) -> None:
        self.findings.append(Finding(field, shown(value), limit, cure))

    def _text(self, key: str, default: str) -> str:
        text = self.document.get(key, default)
        if isinstance(text, str) and 0 < len(text.strip()) <= LONGEST_NAME and text.strip().isprintable():
            return text.strip()
        limit = f"a text of at most {LONGEST_NAME} characters, all of them printable"
        self._refuse(key, text, limit, "write a text, or leave it out")
        return default

    def _refuse_controls(self) -> None:
        """Refuse texts that would command the terminal of a reader, once for each part of the document."""
        for key, part in self.document.items():
            left = [part]
            while left:
                item = left.pop()
                if isinstance(item, Mapping):
                    left += [*item, *item.values()]
                elif isinstance(item, list | tuple):
                    left += item
                elif isinstance(item, str) and CONTROLS.search(item):
                    limit = "text without control characters"
                    self._refuse(str(key), item, limit, "remove them")
                    break

    def _scenario(self) -> scenarios.Scenario:
        name = self.document.get("scenario")
        if not isinstance(name, str):
            cure = nearest_cure(name, scenarios.names())
            raise refusal("scenario", name, "the name of a scenario", cure)
        return scenarios.load(name)

    def _choice(self, key: str, choices: tuple[Allowed, ...]) -> Allowed:
        """One of some words; the first of them where there is none."""
        asked = self.document.get(key, choices[0])
        for choice in choices:
            if asked == choice:
                return choice
        self._refuse(key, asked, f"one of {', '.join(choices)}", nearest_cure(asked, choices))
        return choices[0]

    def _sampling(self, combine: Combine) -> Sampling | None:
        """Count and seed of the points, where axes are sampled."""
        if combine in METHODS:
            return read_sampling(combine, self.document, self.limits.max_runs)
        for key in ("points", "seed"):
            if self.document.get(key) is not None:
                limit = f"combine: {' or '.join(METHODS)}"
                raise refusal(key, self.document[key], limit, "leave it out")
        return None

    def _mapping(self, key: str) -> Mapping[str, Plain]:
        part = self.document.get(key)
        if isinstance(part, Mapping):
            return part
        if part is not None:
            self._refuse(key, part, "names and values", f"write {key}: {{name: value}}")
        return {}

    def _materials(self) -> dict[str, Material]:
        """The user's own materials; refused ones are left out."""
        documents, most = self._mapping("materials"), self.limits.max_values
        if len(documents) > most:
            limit, cure = f"at most {most} materials", "remove materials that no run uses"
            self.findings.append(Finding("materials", f"{len(documents)} materials", limit, cure))
            return {}
        read = {name: self.findings.attempt(self._material, name, document) for name, document in documents.items()}
        return {name: material for name, material in read.items() if material is not None}

    def _material(self, name: str, document: Plain) -> Material:
        if not isinstance(name, str):
            raise refusal("materials", name, "names that are texts", f"write it in quotes: '{name}'")
        if name in shipped.names():
            limit = "a name that no shipped material has"
            raise refusal(f"materials.{name}", name, limit, f"call it my-{name}")
        return read_own(document, f"materials.{name}", name)

    def _laws(self, terms: AllowedNames) -> tuple[OwnLaw, ...]:
        """The fitted laws; each has a name of its own and is about what the scenario measures."""
        documents = self.document.get("laws")
        if documents is None:
            return ()
        limit = f"a list of at most {MOST_LAWS} fitted laws"
        if not isinstance(documents, list | tuple) or len(documents) > MOST_LAWS:
            self._refuse("laws", documents, limit, "write laws: [my-law.json]")
            return ()
        read = [self.findings.attempt(read_law, document, f"laws[{place}]") for place, document in enumerate(documents)]
        laws = tuple(law for law in read if law is not None)
        for twice in repeated(tuple(law.name for law in laws)):
            self._refuse("laws", twice, "each law once", "give it another name: whipple fit --name")
        for law in laws:
            if law.quantity not in terms.quantities:
                cure = nearest_cure(law.quantity, terms.quantities)
                self._refuse("laws", law.quantity, "what the scenario measures", cure)
        return laws

    def _material_names(self, role: str, own: Mapping[str, Material]) -> tuple[str, ...]:
        """The materials that a material parameter takes; names of no material are refused later."""
        values = self.varied.get(role)
        if not isinstance(values, list | tuple):
            values = [self.fixed.get(role, self.record[role].default)]
        names = {*shipped.names(), *own}
        return tuple(dict.fromkeys(v for v in values if isinstance(v, str) and v in names))

    def _axes(self, terms: AllowedNames, combine: Combine) -> tuple[Axis, ...]:
        """All axes, with the rules that hold between them."""
        if not self.varied:
            limit, cure = "at least one axis", "give an axis; one value is enough: speed: [6 km/s]"
            self.findings.append(Finding("axes", "nothing", limit, cure))
        if len(self.varied) > self.limits.max_axes:
            limit = f"at most {self.limits.max_axes} axes"
            self.findings.append(Finding("axes", f"{len(self.varied)} axes", limit, "split the sweep"))
            self.findings.check()
        read = [self.findings.attempt(self._axis, terms, combine, *item) for item in self.varied.items()]
        axes = tuple(axis for axis in read if axis is not None)
        if len(axes) == len(self.varied) > 0 and self.sampling is not None:
            axes = sampled(self.sampling, axes)
        if len(axes) == len(self.varied) > 0 and combine not in METHODS:
            self._check_combination(axes, combine)
        return axes

    def _axis(self, terms: AllowedNames, combine: Combine, name: str, values: Plain) -> Axis:
        field = f"axes.{name}"
        if name == "resolution" and name not in terms.parameters:
            cure = f"the axis is called {RESOLUTION!r}"
            raise refusal(field, name, "a name of a parameter", cure)
        parameter = find(terms.parameters, name, "axes")
        if name in self.fixed:
            cure = "remove it from fixed or from axes"
            raise refusal(field, f"{name} twice", "a parameter that is fixed or varied", cure)
        if combine in METHODS:
            points = self.sampling.points if self.sampling else None
            reader = AxisReader(self.limits.max_runs, terms.materials)
            return read_range(parameter, name, values, reader, points)
        if isinstance(values, Mapping) and "limit_of" in values:
            search = read_search(parameter, values, name, terms.quantities)
            return Axis(name, parameter.unit, search.start(), search=search)
        reader = AxisReader(self.limits.max_values, terms.materials)
        return reader.read(parameter, name, values, field)

    def _ends(self, terms: AllowedNames, axes: tuple[Axis, ...]) -> tuple[tuple[Mapping[str, Value], float], ...]:
        """Rows of points with a latest end of their own: the value of each axis, and the end."""
        rows = self.document.get("ends")
        if rows is None:
            return ()
        names = {axis.name for axis in axes}
        limit = "a list of rows with a value of each axis and end_time"
        if not isinstance(rows, list | tuple) or END in names or END not in terms.parameters:
            self._refuse("ends", rows, f"{limit}, where end_time is a parameter and no axis", "leave it out")
            return ()
        ends = []
        for place, row in enumerate(rows):
            field = f"ends[{place}]"
            if not isinstance(row, Mapping) or {*row} != {*names, END}:
                self._refuse(field, row, limit, f"give {', '.join([*names, END])}")
                continue
            at = parse_values(terms.parameters, row, field, self.findings, materials=terms.materials)
            end = at.pop(END, None)
            if any(axis.search or at.get(axis.name) not in axis.values for axis in axes):
                self._refuse(field, row, "values that stand on the axes, none of them searched", "leave it out")
            elif isinstance(end, float):
                ends.append((at, end))
        return tuple(ends)

    def _check_search(self, axes: tuple[Axis, ...], combine: Combine) -> None:
        """One axis is searched, for each point of a grid of the others."""
        searched = [axis.name for axis in axes if axis.search]
        if not searched:
            return
        field = f"axes.{searched[0]}"
        if len(searched) > 1:
            self._refuse(field, ", ".join(searched), "one limit", "give the others as values")
        if combine != "grid":
            self._refuse(field, combine, "combine: grid for a limit", "leave combine out")
        if self.document.get("model_part") == "screen":
            self._refuse(field, "model_part: screen", "stored or none for a limit", "leave model_part out")

    def _check_combination(self, axes: tuple[Axis, ...], combine: Combine) -> None:
        """Axes of a zip are equally long; no value of an axis (of a zip: no point) stands twice."""
        lengths = {axis.name: len(axis.values) for axis in axes}
        if combine == "grid":
            twice = [
                (f"axes.{axis.name}", str(written(value, axis.unit)))
                for axis in axes
                for value in repeated(axis.values)
            ]
        elif len(set(lengths.values())) == 1:
            points = tuple(zip(*(axis.values for axis in axes), strict=True))
            twice = [("axes", str(point)) for point in repeated(points)]
        else:
            counts = ", ".join(f"{name}: {length}" for name, length in lengths.items())
            limit = "axes of equal length where combine is zip"
            self.findings.append(Finding("axes", counts, limit, "make them equal, or use grid"))
            return
        for field, text in twice:
            self.findings.append(Finding(field, text, "each value once", "leave it out"))

    def _accuracy(self, scenario: scenarios.Scenario) -> float | None:
        """The mesh error from which the cells of each point follow; None where they are stated.

        A sweep that states neither has the usual one where experience tells errors of its scenario, and else the cells
        that its scenario has by default, as a sweep has that an older version accepted.
        """
        wanted = self.document.get("accuracy")
        if wanted is None:
            is_stated = self.document.get("resolution") is not None or RESOLUTION in {*self.fixed, *self.varied}
            return None if is_stated or not tells_errors(scenario) or self.limits is ACCEPTED else USUAL
        error = read_accuracy(wanted)
        if self.document.get("resolution") is not None:
            limit = "accuracy, or resolution: the resolution follows from an accuracy"
            raise refusal("accuracy", wanted, limit, "give one of the two")
        self._require_free("accuracy", wanted, RESOLUTION)
        if not scenario.accurate:
            limit = "a scenario whose mesh error is known from experience"
            raise refusal("accuracy", wanted, limit, "give a resolution: resolution: 16")
        return error

    def _cells(self) -> tuple[float | None, ...]:
        """The cells that an accuracy chose for each point when a sweep was accepted; at the door it chooses anew."""
        chosen = self.document.get("cells")
        if not isinstance(chosen, list | tuple) or self.limits is not ACCEPTED:
            return ()
        cells = self.record[RESOLUTION]
        return tuple(None if one is None else float(parse_value(cells, one, "cells") or 0.0) for one in chosen)

    def _resolutions(self) -> tuple[float, ...]:
        values = self.document.get("resolution")
        if values is None:
            return ()
        self._require_free("resolution", values, RESOLUTION)
        if isinstance(values, str) and (meant := next((name for name in nearest(values, ACCURACY)), "")):
            limit = "cells across the projectile or bar; a mesh error by its name is an accuracy"
            raise refusal("resolution", values, limit, f"write accuracy: {meant}")
        parameter = self.record[RESOLUTION]
        if not isinstance(values, list | tuple | Mapping):
            value = parse_value(parameter, values, "resolution")
            return () if value is None else (float(value),)
        reader = AxisReader(self.limits.max_values, ())
        axis = reader.read(parameter, RESOLUTION, values, "resolution")
        for twice in repeated(axis.values):
            raise refusal("resolution", twice, "each resolution once", "leave it out")
        return tuple(sorted(float(value) for value in axis.values if value is not None))

    def _offsets(self) -> int:
        count = self.document.get("offsets")
        if count is None:
            return 1
        number = exact_number(count, "offsets", "3")
        if number != number.to_integral_value() or not 1 <= number <= MOST_OFFSETS:
            limit = f"a whole number from 1 to {MOST_OFFSETS}"
            cure = "write 3 for offsets of 0, 1/3 and 2/3 of a cell"
            raise refusal("offsets", count, limit, cure)
        if number > 1:
            self._require_free("offsets", count, OFFSET)
        return int(number)

    def _require_free(self, key: str, value: Plain, parameter: str) -> None:
        """The scenario has the parameter that a key sets, and the document does not set it otherwise."""
        if parameter not in self.record:
            limit = f"a scenario with {parameter.replace('_', ' ')}"
            raise refusal(key, value, limit, "leave it out")
        for part, names in (("fixed", self.fixed), ("axes", self.varied)):
            if parameter in names:
                limit = f"{key}, or {parameter} under {part}"
                raise refusal(key, value, limit, "give one of the two")

    def _check_completeness(self) -> None:
        """Every parameter without a default is fixed or varied."""
        names = {*self.fixed, *self.varied}
        # A misspelt name is refused as such.
        for name in (*self.fixed, *self.varied):
            if name not in self.record:
                names.update(nearest(name, self.record))
        for parameter in self.record.values():
            if parameter.required and parameter.name not in names:
                self.findings.append(missing(parameter, "fixed"))


def vocabulary(scenario_name: str, roles: Mapping[str, tuple[str, ...]], own: Mapping[str, Material]) -> AllowedNames:
    """The names that a document of a scenario may use, with the constants that all materials of a role have."""
    scenario = scenarios.load(scenario_name)
    parameters = dict(declared(scenario.parameters))
    for role, names in roles.items():
        parameters |= _constants(role, [own[n] if n in own else shipped.load(n) for n in names])
    present = [role for role, names in roles.items() if names]
    quantities = {name: measurements.load(name).unit for name in scenario.measured(present)}
    return AllowedNames(quantities, parameters, sorted({*shipped.names(), *own}))


def published_shots(table: str, scenario_name: str) -> tuple[Observation, ...]:
    """The shots of a published table that ships, by the names of a scenario; raises InvalidInput."""
    roles = dict.fromkeys(scenarios.load(scenario_name).materials, ())
    return read_observations(table, vocabulary(scenario_name, roles, {}))


def _constants(role: str, candidates: list[Material]) -> dict[str, Parameter]:
    """The constants that all materials of a role have, by dotted path; of one name and two units, they are two.

    Where no material of the role is known, one finding says so; any constant is let through then.
    """
    every = [material.parameters for material in candidates or map(shipped.load, shipped.names())]
    constants = every if candidates else [{path: constant for own in every for path, constant in own.items()}]
    units = [{(path, constant.unit) for path, constant in own.items()} for own in constants]
    shared = set.intersection(*units)
    return {f"{role}.{path}": constant for path, constant in constants[0].items() if (path, constant.unit) in shared}
