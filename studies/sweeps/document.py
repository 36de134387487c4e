"""The document of a sweep (YAML or JSON) becomes a checked ``Sweep``, or a list of all findings."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import yaml

try:  # libyaml's, ten times faster
    from yaml import CSafeLoader as SafeLoader
except ImportError:
    from yaml import SafeLoader  # type: ignore[assignment]  # the same interface in Python

from studies import materials as shipped
from studies import scenarios
from studies.materials import Material, read_document
from studies.observations import AllowedNames, Observation, read_observations, written
from studies.sweeps.axes import Axis, AxisReader, repeated
from studies.sweeps.sweep import OFFSET, RESOLUTION, Combine, Sweep, SweepLimits, known_words
from studies.values.errors import Finding, Findings, InvalidInput
from studies.values.nearest import nearest_cure, shown
from studies.values.parameters import Value, declared, find, missing, parse_value, parse_values
from studies.values.quantities import exact_number, refusal
from studies.values.recipes import ACCURACY

KEYS = (
    "name",
    "title",
    "scenario",
    "fixed",
    "axes",
    "combine",
    "resolution",
    "offsets",
    "accuracy",
    "materials",
    "observations",
)
COMBINATIONS: tuple[Combine, ...] = ("grid", "zip")
LONGEST_NAME = 200  # characters of a sweep's name or title
MOST_OFFSETS = 32  # of one resolution; more say nothing new about a scatter

Read = TypeVar("Read")
Instead = TypeVar("Instead")


def read_sweep(document: Any, limits: SweepLimits) -> Sweep:
    """The sweep of a document; raises InvalidInput with every finding."""
    if not isinstance(document, Mapping):
        raise refusal("sweep", document, "a mapping with scenario and axes", "see the examples")
    return _DocumentReading(document, limits).sweep()


def read_sweep_file(file: Path) -> dict[str, Any]:
    """The document of a YAML file, with the observations of the CSV file that it may name.

    Raises InvalidInput naming the file: unreadable, not YAML, not a mapping.
    """
    document = read_yaml(_text_of(file, str(file)), str(file))
    named = document.get("observations")
    if isinstance(named, str) and "\n" not in named.strip():
        beside = file.parent / named.strip()
        document["observations"] = _text_of(beside, "observations")
    return document


def read_yaml(text: str, source: str) -> dict[str, Any]:
    """A YAML (or JSON) text as a mapping; raises InvalidInput naming line and column."""
    try:
        document = yaml.load(text, _StrictLoader)
    except (yaml.YAMLError, RecursionError, ValueError, OverflowError) as error:
        found = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput([Finding(source, found, "YAML", "correct the line named")]) from None
    if not isinstance(document, dict):
        raise refusal(source, document, "a mapping with scenario and axes", "see the examples")
    return document


class _StrictLoader(SafeLoader):
    """Plain values only, and each key once: the second of two equal keys would win in silence."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str) or key == "<<":
                continue
            if key in seen:
                problem = f"the key {shown(key)} stands twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def _text_of(file: Path, name: str) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(
            [Finding(name, str(file), "a text file that can be read", str(error))]
        ) from None


class _DocumentReading:
    """One document being read: what was found right, and what was found wrong."""

    def __init__(self, document: Mapping[str, Any], limits: SweepLimits):
        self.document = document
        self.limits = limits
        self.findings = Findings()

    def sweep(self) -> Sweep:
        """The whole document, in the order in which one part needs another."""
        self._refuse_unknown_keys()
        combine = self._attempt(self._combine, COMBINATIONS[0])
        own = self._materials()
        scenario = self._attempt(lambda: scenarios.load(self._scenario_name()), None)
        if scenario is None:
            raise InvalidInput(self.findings)
        self.record = declared(scenario.parameters)
        self.given_fixed = self._mapping("fixed")
        self.given_axes = self._mapping("axes")
        known = known_words(scenario.name, self._roles(scenario.materials, own), own)
        fixed = self._fixed(known)
        axes = self._axes(known, combine)
        resolutions, offsets = self._attempt(self._refinement, ((), 1))
        self._check_size(axes, combine, len(resolutions or (0.0,)) * offsets)
        self._check_completeness()
        observations = self._attempt(lambda: self._observations(known), ())
        name = self._attempt(lambda: self._word("name", scenario.name), "")
        title = self._attempt(lambda: self._word("title", name), "")
        if self.findings:
            raise InvalidInput(self.findings)
        return Sweep(
            name=name,
            title=title,
            scenario=scenario.name,
            fixed=fixed,
            axes=axes,
            combine=combine,
            resolutions=resolutions,
            offsets=offsets,
            materials=own,
            observations=observations,
            max_particles=self.limits.max_particles,
        )

    def _attempt(self, part: Callable[[], Read], instead: Instead) -> Read | Instead:
        """A part of the document; where it is refused, the findings are kept."""
        try:
            return part()
        except InvalidInput as error:
            self.findings.extend(error.findings)
            return instead

    def _refuse_unknown_keys(self) -> None:
        for key in self.document:
            if key not in KEYS:
                cure = nearest_cure(key, KEYS)
                self.findings.append(Finding(str(key), shown(key), "a key of a sweep", cure))

    def _word(self, key: str, default: str) -> str:
        given = self.document.get(key, default)
        if not isinstance(given, str) or not 0 < len(given.strip()) <= LONGEST_NAME:
            limit = f"a text of at most {LONGEST_NAME} characters"
            raise refusal(key, given, limit, "write a text, or leave it out")
        return given.strip()

    def _scenario_name(self) -> str:
        given = self.document.get("scenario")
        if not isinstance(given, str):
            cure = nearest_cure(given, scenarios.names())
            raise refusal("scenario", given, "the name of a scenario", cure)
        return given

    def _combine(self) -> Combine:
        given = self.document.get("combine", COMBINATIONS[0])
        for one in COMBINATIONS:
            if given == one:
                return one
        raise refusal("combine", given, "grid or zip", nearest_cure(given, COMBINATIONS))

    def _mapping(self, key: str) -> Mapping[str, Any]:
        given = self.document.get(key)
        if given is None:
            return {}
        if not isinstance(given, Mapping):
            finding = Finding(
                key, shown(given), "names and values", f"write {key}: {{name: value}}"
            )
            self.findings.append(finding)
            return {}
        return given

    def _materials(self) -> dict[str, Material]:
        """The user's own materials that were found right."""
        own: dict[str, Material] = {}
        given, most = self._mapping("materials"), self.limits.max_values
        if len(given) > most:
            limit, cure = f"at most {most} materials", "leave out those that no run has"
            self.findings.append(Finding("materials", f"{len(given)} materials", limit, cure))
            return own
        for name, document in given.items():
            material = self._attempt(partial(_own_material, name, document), None)
            if material is not None:
                own[name] = material
        return own

    def _roles(
        self, roles: tuple[str, ...], own: Mapping[str, Material]
    ) -> dict[str, tuple[str, ...]]:
        """The known materials that each material parameter takes; refused names are found later."""
        names = {*shipped.names(), *own}
        return {role: tuple(n for n in self._named(role) if n in names) for role in roles}

    def _named(self, role: str) -> list[str]:
        given = self.given_axes.get(role)
        if isinstance(given, list | tuple):
            return list(dict.fromkeys(name for name in given if isinstance(name, str)))
        name = self.given_fixed.get(role, self.record[role].default)
        return [name] if isinstance(name, str) else []

    def _fixed(self, known: AllowedNames) -> dict[str, Value]:
        values, findings = parse_values(
            known.parameters, self.given_fixed, "fixed", materials=known.materials
        )
        self.findings.extend(findings)
        return values

    def _axes(self, known: AllowedNames, combine: Combine) -> tuple[Axis, ...]:
        """All axes, and the number of runs that they make."""
        if not self.given_axes:
            limit, cure = "at least one axis", "give an axis; one value is enough: speed: [6 km/s]"
            self.findings.append(Finding("axes", "nothing", limit, cure))
        if len(self.given_axes) > self.limits.max_axes:
            limit = f"at most {self.limits.max_axes} axes"
            count = f"{len(self.given_axes)} axes"
            self.findings.append(Finding("axes", count, limit, "split the sweep"))
            return ()
        reader = AxisReader(self.limits.max_values, known.materials)
        read = [
            self._attempt(partial(self._axis, reader, known, name, given), None)
            for name, given in self.given_axes.items()
        ]
        axes = tuple(axis for axis in read if axis is not None)
        if len(axes) == len(self.given_axes) > 0:
            self._check_combination(axes, combine)
        return axes

    def _axis(self, reader: AxisReader, known: AllowedNames, name: str, given: Any) -> Axis:
        where = f"axes.{name}"
        if name == "resolution" and name not in known.parameters:
            cure = f"the axis is called {RESOLUTION!r}"
            raise refusal(where, name, "a name of a parameter", cure)
        parameter = find(known.parameters, name, "axes")
        if name in self.given_fixed:
            cure = "take it from fixed or from axes"
            raise refusal(where, f"{name} twice", "a parameter that is fixed or varied", cure)
        return reader.read(parameter, name, given, where)

    def _check_combination(self, axes: tuple[Axis, ...], combine: Combine) -> None:
        lengths = {axis.name: len(axis.values) for axis in axes}
        if combine == "zip" and len(set(lengths.values())) > 1:
            counts = ", ".join(f"{name}: {length}" for name, length in lengths.items())
            limit = "axes of equal length where combine is zip"
            self.findings.append(Finding("axes", counts, limit, "make them equal, or use grid"))
            return
        self._refuse_repetition(axes, combine)

    def _check_size(self, axes: tuple[Axis, ...], combine: Combine, times: int) -> None:
        """The number of runs, each point refined so many times; nothing is expanded yet."""
        lengths = [len(axis.values) for axis in axes] or [1]
        points = max(lengths) if combine == "zip" else math.prod(lengths)
        if points * times > self.limits.max_runs:
            limit = f"at most {self.limits.max_runs} runs"
            size = f"{points * times} runs"
            if times > 1:
                size += f" ({points} points, each {times} times for its resolutions and offsets)"
            self.findings.append(Finding("axes", size, limit, "take fewer values"))

    def _refuse_repetition(self, axes: tuple[Axis, ...], combine: Combine) -> None:
        """A value twice on an axis of a grid, or a point twice in a zip, would be one run twice."""
        if combine == "zip":
            rows = tuple(zip(*(axis.values for axis in axes), strict=True))
            texts = {"axes": [str(row) for row in repeated(rows)]}
        else:
            texts = {
                f"axes.{axis.name}": [str(written(v, axis.unit)) for v in repeated(axis.values)]
                for axis in axes
            }
        for where, twice in texts.items():
            for text in twice:
                self.findings.append(Finding(where, text, "each value once", "leave it out"))

    def _refinement(self) -> tuple[tuple[float, ...], int]:
        """Resolutions and the number of offsets, by themselves or by the name of a preset."""
        given = self.document.get("accuracy")
        if given is None:
            return self._attempt(self._resolutions, ()), self._attempt(self._offsets, 1)
        for key in ("resolution", "offsets"):
            if self.document.get(key) is not None:
                limit = f"accuracy, or {key}: a preset sets both resolution and offsets"
                raise refusal("accuracy", given, limit, "give one of the two")
        if not isinstance(given, str) or given not in ACCURACY:
            limit = "one of " + ", ".join(ACCURACY)
            raise refusal("accuracy", given, limit, nearest_cure(given, ACCURACY))
        self._refuse_other_source("accuracy", given, RESOLUTION)
        if ACCURACY[given].offsets > 1:
            self._refuse_other_source("accuracy", given, OFFSET)
        return ACCURACY[given].resolutions, ACCURACY[given].offsets

    def _resolutions(self) -> tuple[float, ...]:
        given = self.document.get("resolution")
        if given is None:
            return ()
        self._refuse_other_source("resolution", given, RESOLUTION)
        if not isinstance(given, list | tuple | Mapping):
            value = parse_value(self.record[RESOLUTION], given, "resolution")
            return () if value is None else (float(value),)
        reader = AxisReader(self.limits.max_values, ())
        axis = reader.read(self.record[RESOLUTION], RESOLUTION, given, "resolution")
        for twice in repeated(axis.values):
            raise refusal("resolution", twice, "each resolution once", "leave it out")
        return tuple(sorted(float(value) for value in axis.values if value is not None))

    def _offsets(self) -> int:
        given = self.document.get("offsets")
        if given is None:
            return 1
        number = exact_number(given, "offsets", "3")
        if number != number.to_integral_value() or not 1 <= number <= MOST_OFFSETS:
            limit = f"a whole number from 1 to {MOST_OFFSETS}"
            cure = "write 3 for offsets of 0, 1/3 and 2/3 of a cell"
            raise refusal("offsets", given, limit, cure)
        if number > 1:
            self._refuse_other_source("offsets", given, OFFSET)
        return int(number)

    def _refuse_other_source(self, key: str, given: Any, parameter: str) -> None:
        """The scenario has the parameter that a key sets, and nothing else in the document sets it."""
        words = parameter.replace("_", " ")
        if parameter not in self.record:
            raise refusal(key, given, f"a scenario with {words}", "leave it out")
        for part, names in (("fixed", self.given_fixed), ("axes", self.given_axes)):
            if parameter in names:
                limit = f"{key}, or {parameter} under {part}"
                raise refusal(key, given, limit, "give one of the two")

    def _check_completeness(self) -> None:
        """Every parameter without a default is fixed, varied, or the resolution."""
        given = {*self.given_fixed, *self.given_axes}
        if {"resolution", "accuracy"} & {k for k, v in self.document.items() if v is not None}:
            given.add(RESOLUTION)
        for parameter in self.record.values():
            if parameter.required and parameter.name not in given:
                finding = missing(parameter, "fixed")
                if parameter.name == RESOLUTION:
                    cure = "give the cells per projectile diameter: resolution: 16"
                    finding = Finding("resolution", "nothing", finding.limit, cure)
                self.findings.append(finding)

    def _observations(self, known: AllowedNames) -> tuple[Observation, ...]:
        given = self.document.get("observations")
        return () if given is None else read_observations(given, known)


def _own_material(name: Any, document: Any) -> Material:
    if name in shipped.names():
        limit = "a name that no shipped material has"
        raise refusal(f"materials.{name}", name, limit, f"call it my-{name}")
    return read_document(document, name=str(name), path=f"materials.{name}")
