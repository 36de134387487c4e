"""Reads the document of a sweep (YAML or JSON) into a checked ``Sweep``, or a list of all errors."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args

import yaml

try:  # libyaml's, ten times faster
    from yaml import CSafeLoader as SafeLoader
except ImportError:
    from yaml import SafeLoader  # type: ignore[assignment]  # the same interface in Python

from studies import examples, scenarios
from studies import materials as shipped
from studies import observations as published
from studies.materials import Material, read_own
from studies.observations import AllowedNames, read_observations, written
from studies.sweeps.axes import Axis, AxisReader, repeated
from studies.sweeps.sampling import METHODS, Sampling, read_range, read_sampling, sampled
from studies.sweeps.search import read_search
from studies.sweeps.sweep import ACCEPTED, OFFSET, RESOLUTION, Combine, ModelPart, Sweep, SweepLimits, vocabulary
from studies.values.errors import Finding, Findings, InvalidInput
from studies.values.formats import CONTROLS
from studies.values.nearest import few_suggestions, nearest, nearest_cure, shown
from studies.values.parameters import declared, find, missing, parse_value, parse_values
from studies.values.quantities import exact_number, refusal
from studies.values.recipes import ACCURACY

if TYPE_CHECKING:
    from studies.laws._fitted import FittedLaw

KEYS = (
    "name",
    "title",
    "scenario",
    "fixed",
    "axes",
    "combine",
    "points",
    "seed",
    "resolution",
    "offsets",
    "accuracy",
    "materials",
    "observations",
    "laws",
    "model_part",
)
COMBINATIONS: tuple[Combine, ...] = get_args(Combine)
MODEL_PARTS: tuple[ModelPart, ...] = ("stored", "screen", "none")
LONGEST_NAME = 200  # characters of a sweep's name or title
MOST_BESIDE = 20  # files that are compared with the name of a missing one
MOST_LAWS = 50  # fitted ones of a sweep
MOST_OFFSETS = 32  # offsets of one resolution; more add nothing to a scatter

Read = TypeVar("Read")


def read_sweep(document: Any, limits: SweepLimits) -> Sweep:
    """The sweep of a document; raises InvalidInput with every error."""
    if not isinstance(document, Mapping):
        raise refusal("sweep", document, "a mapping with scenario and axes", "see the examples")
    with few_suggestions():
        return _DocumentReading(document, limits).sweep()


def read_sweep_file(file: Path) -> dict[str, Any]:
    """The document of a YAML file, with the observations of the CSV file that it may name.

    A name that ships (``studies.observations``) is read where no file of that name is beside the document. Files of
    fitted laws, by their paths from the document, are replaced by their content.

    Raises InvalidInput naming the file: unreadable, not YAML, not a mapping.
    """
    document = read_yaml(_text_of(file, str(file)), str(file))
    table = document.get("observations")
    if isinstance(table, str) and "\n" not in table.strip():
        beside = file.parent / table.strip()
        if beside.exists() or table.strip() not in published.names():
            document["observations"] = _text_of(beside, "observations")
    laws = document.get("laws")
    if isinstance(laws, list):
        document["laws"] = [read_law_file(file.parent / law) if isinstance(law, str) else law for law in laws]
    return document


def read_law_file(file: Path) -> dict[str, Any]:
    """The document of a fitted law, JSON or YAML; raises InvalidInput naming the file.

    Its content is part of a sweep's document: what computes the sweep never opens the file.
    """
    document = read_yaml(_text_of(file, str(file)), str(file), "the file of a fit")
    if "form" not in document:
        cure = "write it with `whipple fit CUBE --form power --out FILE`"
        raise refusal(str(file), "no form", "the file of a fit", cure)
    return document


def read_yaml(text: str, source: str, limit: str = "a mapping with scenario and axes") -> dict[str, Any]:
    """A YAML (or JSON) text as a mapping; raises InvalidInput naming line and column."""
    try:
        document = yaml.load(text, _StrictLoader)
    except (yaml.YAMLError, RecursionError, ValueError, OverflowError) as error:
        problem = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput([Finding(source, problem, "YAML", "correct the line named")]) from None
    if not isinstance(document, dict):
        raise refusal(source, document, limit, "see the examples")
    return document


class _StrictLoader(SafeLoader):
    """Plain values only, and each key once: the second of two equal keys would win in silence."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        keys: set[str] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str) or key == "<<":
                continue
            if key in keys:
                problem = f"the key {shown(key)} occurs twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


def _text_of(file: Path, name: str) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise no_such_file(file, name) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput([Finding(name, str(file), "a text file that can be read", str(error))]) from None


def no_such_file(file: Path, name: str = "file", example: str = "") -> InvalidInput:
    """The error for a missing file: files beside its place that have its ending, and an example.

    ``example`` says what is wanted, with a path; else it is a sweep, and the cure lists those that ship.
    """
    beside = sorted(other.name for other in file.parent.glob(f"*{file.suffix}"))[:MOST_BESIDE]
    cure = nearest_cure(file.name, beside) if beside else "correct the path."
    if not file.suffix and not cure.startswith("did you mean"):
        cure = "correct the path."
    if example:
        cure = f"{cure} {example}" if cure.startswith("did you mean") else example
    elif file.suffix in (".yaml", ".yml", ".json", ""):
        cure += f" Examples: {', '.join(f'{each}.yaml' for each in examples.names())} in {examples.folder()}"
    return InvalidInput([Finding(name, f"{file}: no such file", "a file that is there", cure)])


def no_such_cube(file: Path) -> InvalidInput:
    """The error for a missing cube."""
    return no_such_file(file, example="give the cube.nc of a sweep, or its folder, such as demo/holes")


class _DocumentReading:
    """One document being read, with the findings so far."""

    def __init__(self, document: Mapping[str, Any], limits: SweepLimits):
        self.document = document
        self.limits = limits
        self.findings = Findings()

    def sweep(self) -> Sweep:
        """The whole document, in the order in which one part needs another; raises InvalidInput."""
        for key in self.document:
            if key not in KEYS:
                self._refuse(str(key), key, "a key of a sweep", nearest_cure(key, KEYS))
        combine = self._combine()
        own = self._materials()
        scenario = self._attempt(self._scenario)
        if scenario is None:
            raise InvalidInput(self.findings)
        self.record = declared(scenario.parameters)
        self.fixed, self.varied = self._mapping("fixed"), self._mapping("axes")
        roles = {role: self._material_names(role, own) for role in scenario.materials}
        terms = vocabulary(scenario.name, roles, own)
        # A material that is refused is none that is missing.
        terms = replace(terms, materials=sorted({*terms.materials, *self._mapping("materials")}))
        fixed, findings = parse_values(terms.parameters, self.fixed, "fixed", materials=terms.materials)
        self.findings.extend(findings)
        self.sampling = self._attempt(partial(self._sampling, combine))
        axes = self._axes(terms, combine)
        resolutions, offsets = self._attempt(self._refinement) or ((), 1)
        self._check_size(axes, combine, len(resolutions or (0.0,)) * offsets)
        self._check_search(axes, combine, resolutions, offsets)
        self._check_completeness()
        table = self.document.get("observations")
        observations = None if table is None else self._attempt(partial(read_observations, table, terms))
        laws = self._laws(terms)
        model_part = self._model_part()
        if self.limits is not ACCEPTED:
            self._refuse_controls()
        name = self._text("name", scenario.name)
        title = self._text("title", name)
        if self.findings:
            raise InvalidInput(self.findings)
        sweep = Sweep(
            name=name,
            title=title,
            scenario=scenario.name,
            fixed=fixed,
            axes=axes,
            combine=combine,
            sampling=self.sampling,
            resolutions=resolutions,
            offsets=offsets,
            materials=own,
            observations=observations or (),
            laws=laws,
            model_part=model_part,
            max_particles=self.limits.max_particles,
        )
        preset = self.document.get("accuracy")
        return sweep if preset is None else sweep.at_accuracy(preset)

    def _refuse(self, field: str, value: object, limit: str, cure: str) -> None:
        self.findings.append(Finding(field, shown(value), limit, cure))

    def _attempt(self, part: Callable[[], Read]) -> Read | None:
        """A part of the document; None where it is refused, with its findings kept."""
        try:
            return part()
        except InvalidInput as error:
            self.findings.extend(error.findings)
            return None

    def _text(self, key: str, default: str) -> str:
        text = self.document.get(key, default)
        is_text = isinstance(text, str) and 0 < len(text.strip()) <= LONGEST_NAME
        # What was accepted before stays readable.
        if is_text and (text.strip().isprintable() or self.limits is ACCEPTED):
            return str(text.strip())
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

    def _combine(self) -> Combine:
        asked = self.document.get("combine", COMBINATIONS[0])
        for combination in COMBINATIONS:
            if asked == combination:
                return combination
        limit = "one of " + ", ".join(COMBINATIONS)
        self._refuse("combine", asked, limit, nearest_cure(asked, COMBINATIONS))
        return COMBINATIONS[0]

    def _sampling(self, combine: Combine) -> Sampling | None:
        """Count and seed of the points, where axes are sampled."""
        if combine in METHODS:
            return read_sampling(combine, self.document, self.limits.max_runs)
        for key in ("points", "seed"):
            if self.document.get(key) is not None:
                limit = f"combine: {' or '.join(METHODS)}"
                raise refusal(key, self.document[key], limit, "leave it out")
        return None

    def _model_part(self) -> ModelPart:
        asked = self.document.get("model_part", MODEL_PARTS[0])
        for choice in MODEL_PARTS:
            if asked == choice:
                return choice
        cure = nearest_cure(asked, MODEL_PARTS)
        self._refuse("model_part", asked, "stored, screen or none", cure)
        return MODEL_PARTS[0]

    def _mapping(self, key: str) -> Mapping[str, Any]:
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
        read = {name: self._attempt(partial(_own_material, name, document)) for name, document in documents.items()}
        return {name: material for name, material in read.items() if material is not None}

    def _laws(self, terms: AllowedNames) -> "tuple[FittedLaw, ...]":
        """The fitted laws; each has a name of its own and is about what the scenario measures."""
        documents = self.document.get("laws")
        if documents is None:
            return ()
        limit = f"a list of at most {MOST_LAWS} fitted laws"
        if not isinstance(documents, list | tuple) or len(documents) > MOST_LAWS:
            self._refuse("laws", documents, limit, "write laws: [my-law.json]")
            return ()
        from studies.laws._fitted import read_law

        read = [
            self._attempt(partial(read_law, document, f"laws[{place}]")) for place, document in enumerate(documents)
        ]
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
            count = f"{len(self.varied)} axes"
            self.findings.append(Finding("axes", count, limit, "split the sweep"))
            return ()
        read = [self._attempt(partial(self._axis, terms, combine, *item)) for item in self.varied.items()]
        axes = tuple(axis for axis in read if axis is not None)
        if len(axes) == len(self.varied) > 0 and self.sampling is not None:
            axes = sampled(self.sampling, axes)
        if len(axes) == len(self.varied) > 0 and combine not in METHODS:
            self._check_combination(axes, combine)
        return axes

    def _axis(self, terms: AllowedNames, combine: Combine, name: str, values: Any) -> Axis:
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
            search = read_search(parameter, values, field, terms.quantities)
            return Axis(name, parameter.unit, search.start, search=search)
        reader = AxisReader(self.limits.max_values, terms.materials)
        return reader.read(parameter, name, values, field)

    def _check_search(
        self, axes: tuple[Axis, ...], combine: Combine, resolutions: tuple[float, ...], offsets: int
    ) -> None:
        """One axis is searched, for each point of a grid of the others, on the one grid of each."""
        searched = [axis.name for axis in axes if axis.search]
        if not searched:
            return
        field = f"axes.{searched[0]}"
        for refused, value, limit, cure in (
            (len(searched) > 1, ", ".join(searched), "one limit", "give the others as values"),
            (combine != "grid", combine, "combine: grid for a limit", "leave combine out"),
            (
                len(resolutions) > 1 or offsets > 1,
                f"{len(resolutions)} resolutions, {offsets} offsets",
                "one grid for a limit",
                f"vary {RESOLUTION} as an axis",
            ),
            (
                self.document.get("model_part") == "screen",
                "model_part: screen",
                "stored or none for a limit",
                "leave model_part out",
            ),
        ):
            if refused:
                self._refuse(field, value, limit, cure)

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

    def _check_size(self, axes: tuple[Axis, ...], combine: Combine, times: int) -> None:
        """The number of runs, each point refined so many times; nothing is expanded yet."""
        lengths = [axis.search.most_tries if axis.search else len(axis.values) for axis in axes] or [1]
        points = math.prod(lengths) if combine == "grid" else max(lengths)
        if points * times > self.limits.max_runs:
            limit = f"at most {self.limits.max_runs} runs"
            size = f"{points * times} runs"
            if times > 1:
                size += f" ({points} points, each {times} times for its resolutions and offsets)"
            self.findings.append(Finding("axes", size, limit, "take fewer values"))

    def _refinement(self) -> tuple[tuple[float, ...], int]:
        """Resolutions and the number of offsets, by themselves or by the name of a preset."""
        preset = self.document.get("accuracy")
        if preset is None:
            return self._attempt(self._resolutions) or (), self._attempt(self._offsets) or 1
        for key in ("resolution", "offsets"):
            if self.document.get(key) is not None:
                limit = f"accuracy, or {key}: a preset sets both resolution and offsets"
                raise refusal("accuracy", preset, limit, "give one of the two")
        if not isinstance(preset, str) or preset not in ACCURACY:
            limit = "one of " + ", ".join(ACCURACY)
            raise refusal("accuracy", preset, limit, nearest_cure(preset, ACCURACY))
        accuracy = ACCURACY[preset]
        self._require_free("accuracy", preset, RESOLUTION)
        if accuracy.offsets > 1:
            self._require_free("accuracy", preset, OFFSET)
        return accuracy.resolutions, accuracy.offsets

    def _resolutions(self) -> tuple[float, ...]:
        values = self.document.get("resolution")
        if values is None:
            return ()
        self._require_free("resolution", values, RESOLUTION)
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

    def _require_free(self, key: str, value: Any, parameter: str) -> None:
        """The scenario has the parameter that a key sets, and the document does not set it otherwise."""
        if parameter not in self.record:
            limit = f"a scenario with {parameter.replace('_', ' ')}"
            raise refusal(key, value, limit, "leave it out")
        for part, names in (("fixed", self.fixed), ("axes", self.varied)):
            if parameter in names:
                limit = f"{key}, or {parameter} under {part}"
                raise refusal(key, value, limit, "give one of the two")

    def _check_completeness(self) -> None:
        """Every parameter without a default is fixed, varied, or the resolution."""
        names = {*self.fixed, *self.varied}
        if any(self.document.get(key) is not None for key in ("resolution", "accuracy")):
            names.add(RESOLUTION)
        # A misspelt name is refused as such.
        for name in (*self.fixed, *self.varied):
            if name not in self.record:
                names.update(nearest(name, self.record))
        for parameter in self.record.values():
            if parameter.required and parameter.name not in names:
                finding = missing(parameter, "fixed")
                if parameter.name == RESOLUTION:
                    cure = "give the cells per projectile diameter: resolution: 16"
                    finding = Finding("resolution", "nothing", finding.limit, cure)
                self.findings.append(finding)


def _own_material(name: Any, document: Any) -> Material:
    if name in shipped.names():
        limit = "a name that no shipped material has"
        raise refusal(f"materials.{name}", name, limit, f"call it my-{name}")
    return read_own(document, f"materials.{name}", str(name))
