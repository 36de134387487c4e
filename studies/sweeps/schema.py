"""The JSON Schema (2020-12) of a sweep's document: a union by scenario, made from the records that the reader reads.

Names that others may add (materials and their constants, tables, models) are suggestions beside any other text.
``Sweep.parse`` refuses more, since it knows what parameters mean together. ``/v1/schema/sweep``, OpenAPI,
``whipple schema`` and the forms of sweeps have it from here.
"""

import re
from collections.abc import Collection, Sequence
from typing import Any

from studies import materials, measurements, observations, scenarios
from studies.laws.targets import targets
from studies.materials.schema import CONFIDENCES, SECTIONS, TEXTS, Scalars, models
from studies.quantities.parameters import Choice, Parameter, Places, declared, lists_of, marks
from studies.quantities.units import LONGEST_TEXT, a_quantity, dimension_of, pattern_of, readable
from studies.scenarios import Scenario
from studies.sweeps.accuracy import ACCURACY, LEAST, MOST, USUAL, in_percent
from studies.sweeps.axes import RANGE_KEYS
from studies.sweeps.reading import (
    COMBINATIONS,
    END,
    LONGEST_NAME,
    MODEL_PARTS,
    MOST_LAWS,
    MOST_OFFSETS,
    OFFSET,
    RESOLUTION,
    SweepLimits,
)
from studies.sweeps.sampling import LARGEST_SEED, METHODS

Schema = dict[str, Any]
Schemas = dict[str, Schema]

DIALECT = "https://json-schema.org/draft/2020-12/schema"
FILE = "sweep.schema.json"
MODELINE = f"# yaml-language-server: $schema={FILE}"  # of a sweep beside that file, for editors
DEFINITIONS = "#/$defs/"
SWEEP = "Sweep"  # the name of the whole
LIMITS = SweepLimits()
TEXT: Schema = {"type": "string", "minLength": 1, "pattern": r"\S"}
SHARE: Schema = {"type": ["number", "string"], "pattern": pattern_of("1").replace("$", r"%?\s*$")}
# A number, with its unit or without, of which no record is known.
CONSTANT: Schema = {"type": ["number", "string", "null"]}
WITHOUT_NULL = ("name", "title", "combine", "model_part")  # keys that are left out, and not empty
NULL: Schema = {"type": "null"}
CELL: Schema = {"type": ["string", "number", "boolean", "null"]}  # of a table of shots


def schema_of_sweep() -> Schema:
    """The schema as one document."""
    parts = definitions()
    return {"$schema": DIALECT, **parts.pop(SWEEP), "$defs": parts}


def definitions(place: str = DEFINITIONS) -> Schemas:
    """The parts of the schema by name, of which ``SWEEP`` is the whole; they refer to each other at a ``place``."""
    return _Definitions(place).every()


def definitions_of_shot(name: str, records: Sequence[type], place: str) -> Schemas:
    """A part of a name: a shot whose parameters are in records, or a sweep; and the parts that it refers to."""
    made = _Definitions(place)
    stated = {**made.stated(records), "materials": {"type": "object", "additionalProperties": made.material()}}
    needed = sorted({p.name for record in records for p in declared(record).values() if p.required})
    shot = made.part(f"Shot{name}", _object(stated, needed))
    return {**made.parts, name: {"anyOf": [shot, {"$ref": f"{place}{SWEEP}"}]}}


def keys_of(scenario: Scenario) -> Schemas:
    """The keys of a document of a scenario, but for those that hold parameters."""
    return _Definitions(DEFINITIONS).keys(scenario)


def suggested(schema: Schema) -> tuple[str, ...]:
    """The words that a schema allows or suggests."""
    return tuple(word for part in (schema, *schema.get("anyOf", ())) for word in part.get("enum", ()))


class _Definitions:
    """The parts so far; each is made where it is first referred to."""

    def __init__(self, place: str):
        self.place = place
        self.is_file = place == DEFINITIONS  # and not part of OpenAPI
        self.parts: Schemas = {}

    def every(self) -> Schemas:
        members = {name: self._scenario(scenarios.load(name)) for name in scenarios.names()}
        about = "A scenario, its fixed parameters and the axes that vary; or a shot, its parameters at the top."
        union = self._chosen(members) if self.is_file else self._discriminated(members)
        return dict(sorted({**self.parts, SWEEP: {"title": SWEEP, "description": about, **union}}.items()))

    def _chosen(self, members: Schemas) -> Schema:
        """The union as conditions: what is wrong is then told of the scenario that is meant, and of no other."""
        is_shot: Schema = {"required": ["speed"], "not": {"required": ["scenario"]}}
        named: Schema = {"properties": {"scenario": {"enum": [*members]}}, "required": ["scenario"]}
        of_each = [
            {"if": {"properties": {"scenario": {"const": name}}, "required": ["scenario"]}, "then": member}
            for name, member in members.items()
        ]
        return {"type": "object", "allOf": [{"if": is_shot, "then": self._shot(), "else": named}, *of_each]}

    def _discriminated(self, members: Schemas) -> Schema:
        """The union as OpenAPI has it, and as generated clients know it."""
        mapping = {name: member["$ref"] for name, member in members.items()}
        discriminator = {"propertyName": "scenario", "mapping": mapping}
        return {"oneOf": [*members.values(), self._shot()], "discriminator": discriminator}

    def part(self, name: str, schema: Schema) -> Schema:
        """A reference to a part, which is there from now on."""
        self.parts.setdefault(name, schema)
        return {"$ref": f"{self.place}{name}"}

    # --- documents ------------------------------------------------------------------------------

    def _scenario(self, scenario: Scenario) -> Schema:
        record, roles, head = scenario.parameters, scenario.materials, _camel(scenario.name)
        fixed = {name: self._fixed(parameter, record) for name, parameter in declared(record).items()}
        fixed |= {key: self._listed(*found) for key, found in lists_of(record).items()}
        axes = {name: self._axis(parameter, record) for name, parameter in declared(record).items()}
        varied = {**_with_constants(axes, roles, self._several(CONSTANT)), "minProperties": 1}
        properties = {
            "scenario": {"type": "string", "const": scenario.name, "description": scenario.description},
            "fixed": _any_of(self.part(f"{head}Fixed", _with_constants(fixed, roles, CONSTANT)), NULL),
            "axes": self.part(f"{head}Axes", {**varied, "maxProperties": LIMITS.max_axes}),
            **self.keys(scenario),
        }
        rules = [SAMPLED, *(_stated(parameter.name) for parameter in declared(record).values() if parameter.required)]
        document = {**_object(properties, ["scenario", "axes"]), **self._rules(rules)}
        return self.part(f"{head}Sweep", {"description": scenario.title, **document})

    def _shot(self) -> Schema:
        """A sweep that is written as a shot, at any target."""
        hit = [scenarios.load(target.scenario) for target in targets()]
        needed = [{name for name, p in declared(each.parameters).items() if p.required} for each in hit]
        roles = {role for scenario in hit for role in scenario.materials}
        constant = _any_of(CONSTANT, self._several(CONSTANT))
        properties = {**self.stated([scenario.parameters for scenario in hit]), **self.keys(hit[0])}
        shot = _with_constants(properties, sorted(roles), constant)
        about = "A shot, whose target tells the scenario. Parameters with several values vary; without any, its speed."
        rules = {"required": sorted(set.intersection(*needed)), **self._rules([SAMPLED])}
        return self.part("ShotSweep", {"description": about, **shot, **rules})

    def _rules(self, rules: list[Schema]) -> Schema:
        """Rules between keys; OpenAPI has none, since clients and tests that are made from it cannot use them."""
        return {"allOf": rules} if self.is_file else {}

    def stated(self, records: Sequence[type]) -> Schemas:
        """The parameters of records, each with one value or several."""
        properties: Schemas = {}
        for record in records:
            for name, parameter in declared(record).items():
                stated = _any_of(self._value(parameter, record), self._axis(parameter, record))
                before = [properties[name]] if name in properties else []
                properties[name] = _described(_any_of(*before, stated), parameter)
            properties |= {key: self._listed(*found) for key, found in lists_of(record).items()}
        return properties

    def keys(self, scenario: Scenario) -> Schemas:
        parameters = declared(scenario.parameters)
        name: Schema = {**TEXT, "maxLength": LONGEST_NAME}
        rows: Schema = {"type": "array", "items": {"type": "object", "additionalProperties": CELL}, "minItems": 1}
        own: Schema = {"type": "object", "propertyNames": {"not": {"enum": materials.names()}}}
        keys: Schemas = {
            "name": name | _about("names files; by default the scenario"),
            "title": name | _about("stands above the report"),
            "combine": {"enum": [*COMBINATIONS]}
            | _about("every value with every other is grid; zip takes them in pairs; the others sample points"),
            "points": _whole(1, LIMITS.max_runs)
            | _about("of axes that are sampled between two ends: {low: 4 km/s, high: 8 km/s}"),
            "seed": _whole(0, LARGEST_SEED) | _about("of sampled points"),
            "materials": {**own, "additionalProperties": self.material()}
            | _about("by name; a base gives all that you leave out, and parameters may then name them"),
            "observations": _any_of(_suggestions(observations.names()), rows)
            | _about("measured shots: the name of a table that ships, or your own as CSV or in rows"),
            "laws": {"type": "array", "items": {"type": ["object", "string"]}, "maxItems": MOST_LAWS}
            | _about("what whipple fit wrote: the content of files, or on this machine their paths"),
            "model_part": {"enum": [*MODEL_PARTS]}
            | _about(
                "uncertainty due to strength, failure and equation of state, stated beside the error bar: stored from "
                "earlier studies, or screened by runs of this sweep with other models"
            ),
        }
        if scenario.accurate:
            words = ", ".join(f"{word} ({in_percent(error)})" for word, error in ACCURACY.items())
            keys["accuracy"] = _any_of({"enum": [*ACCURACY]}, {**SHARE, "minimum": LEAST, "maximum": MOST}) | _about(
                f"mesh error of what is measured, in per cent or by name: {words}; the cells of each point follow from "
                f"it; {in_percent(USUAL)} where no resolution is stated"
            )
            keys["cells"] = {"type": "array", "items": {"type": ["number", "null"]}} | _about(
                "what the accuracy of a stored document chose; of a new one it chooses anew"
            )
        if RESOLUTION in parameters:
            one = self._value(parameters[RESOLUTION], scenario.parameters)
            keys["resolution"] = _any_of(one, self._list(one), self._range("number")) | _about(
                "in place of an accuracy: cells across the projectile or bar, one number or several: 16, 24, 32"
            )
        if OFFSET in parameters:
            keys["offsets"] = _any_of(_whole(1, MOST_OFFSETS), self._number("integer")["anyOf"][1]) | _about(
                "runs at each resolution, the grid shifted by a part of a cell from one to the next; their scatter is "
                "part of the error bar"
            )
        if END in parameters:
            keys["ends"] = {"type": "array", "items": {"type": "object"}} | _about(
                "points with a latest end of their own: a value of each axis, and end_time"
            )
        return {
            key: schema if key in WITHOUT_NULL else {**_any_of(schema, NULL), **_about(schema["description"])}
            for key, schema in keys.items()
        }

    # --- parameters -----------------------------------------------------------------------------

    def _fixed(self, parameter: Parameter, record: type) -> Schema:
        one = self._value(parameter, record)
        return _described(_any_of(one, NULL) if parameter.optional else one, parameter)

    def _listed(self, places: Places, record: type) -> Schema:
        """A list of records such as bumpers."""
        inside = {name: self._fixed(parameter, record) for name, parameter in declared(record).items()}
        items = {name: {**schema, "description": ""} for name, schema in inside.items()}
        return {
            **{"type": "array", "maxItems": len(places.names), "items": _object(items)},
            **_about(f"each with {', '.join(items)}: {places.example}"),
        }

    def _value(self, parameter: Parameter, record: type) -> Schema:
        """One value of a parameter of a record."""
        if parameter.kind == "quantity":
            return self._quantity(parameter)
        if parameter.kind == "integer":
            return self._number("integer", parameter)
        if parameter.kind == "boolean":
            return {"type": "boolean"}
        if parameter.kind == "material":
            return self._material_name()
        if parameter.kind == "choice":
            one = self._choice(_camel(parameter.name), record.__name__, parameter.choices)
            return _any_of(one, TEXT) if parameter.name in marks(record, Choice) else one
        return {**TEXT, "maxLength": parameter.longest}

    def _choice(self, name: str, of: str, words: Collection[str]) -> Schema:
        """One of some words: a part of a name, or of another one where that has other words."""
        choice: Schema = {"type": "string", "enum": [*words]}
        return self.part(name if self.parts.get(name, choice) == choice else f"{of}{name}", choice)

    def _quantity(self, parameter: Parameter) -> Schema:
        unit = parameter.unit or "1"
        if unit == "1":
            return self._number("number", parameter)
        about = f"{a_quantity(unit)} with its unit"
        text: Schema = {"type": "string", "maxLength": LONGEST_TEXT, "pattern": pattern_of(unit)}
        told = {"patternErrorMessage": about} if self.is_file else {}  # in editors, in place of the pattern
        return self.part(_camel(dimension_of(unit)), {**_about(about), **text, **told})

    def _number(self, kind: str, parameter: Parameter | None = None) -> Schema:
        """A number within the bounds of a parameter, or its text."""
        bounds = {"minimum": parameter.minimum, "maximum": parameter.maximum} if parameter else {}
        stated = {name: bound for name, bound in bounds.items() if bound is not None}
        text = self.part("NumberText", {"type": "string", "pattern": pattern_of("1")})
        return _any_of({"type": kind, **stated}, text)

    def _axis(self, parameter: Parameter, record: type) -> Schema:
        """What an axis may be: values, and of a number a range, two ends to sample between, or a search."""
        one = self._value(parameter, record)
        if parameter.kind == "integer":
            forms = _any_of(self._list(one), self._range("integer"))
        elif parameter.kind != "quantity":
            forms = self._list(one)
        elif parameter.unit == "1":
            forms = _any_of(self._list(one), *self._several(self._number("number"), "Number")["anyOf"][1:])
        else:
            name = _camel(dimension_of(parameter.unit or "1"))
            forms = self.part(f"{name}Axis", self._several(one, name))
        return _described(forms, parameter)

    def _several(self, one: Schema, name: str = "Constant") -> Schema:
        """The values of an axis of quantities; the other forms are parts of a name."""
        ends = _object({"low": one, "high": one, "values": {"type": "array", "items": one}}, ["low", "high"])
        outcomes = [name for name in measurements.names() if measurements.load(name).is_outcome]
        search = {
            "limit_of": _suggestions(outcomes) | _about("what is measured as 1 or 0"),
            "between": {"type": "array", "items": one, "minItems": 2, "maxItems": 2},
            "tolerance": one,
            "until": SHARE | _about("width of the interval over its values, in place of a tolerance: 10 %"),
        }
        return _any_of(
            self._list(one),
            self.part(f"{name}Range", _object(dict.fromkeys(RANGE_KEYS, one), RANGE_KEYS)),
            self.part(f"{name}Between", {"description": "Ends between which points are sampled", **ends}),
            self.part(f"{name}Limit", {"description": "A search", **_object(search, ["limit_of", "between"])}),
        )

    def _list(self, one: Schema) -> Schema:
        return {"type": "array", "items": one, "minItems": 1, "maxItems": LIMITS.max_values}

    def _range(self, kind: str) -> Schema:
        numbers = dict.fromkeys(RANGE_KEYS, self._number(kind))
        return self.part(f"{kind.capitalize()}Range", _object(numbers, RANGE_KEYS))

    # --- materials ------------------------------------------------------------------------------

    def _material_name(self) -> Schema:
        return _any_of(self._choice("Material", "Name", materials.names()), TEXT)

    def material(self) -> Schema:
        """A material of the user's own: the constants of each section, of every kind that it may have."""
        stated: Schemas = {"value": {"type": ["number", "string"]}, "unit": {"type": "string"}, "source": TEXT}
        stated["confidence"] = {"enum": [*CONFIDENCES]}
        number = self.part("StatedNumber", _object(stated, ["value"]))
        label = _object({"label": TEXT, **stated}, ["label", "value"])
        own = {name: _any_of(self._quantity(scalar), number) for name, scalar in declared(Scalars).items()}
        for section, record in SECTIONS.items():
            kinds = {} if isinstance(record, type) else models(section)
            constants: Schemas = {"kind": _suggestions([*kinds])} if kinds else {}
            for each in [record] if isinstance(record, type) else [model.record for model in kinds.values()]:
                for name, parameter in declared(each).items():
                    forms = [self._quantity(parameter), number, *([{"const": "none"}] if parameter.optional else [])]
                    constants[name] = _any_of(*([constants[name]] if name in constants else []), *forms)
            own[section] = self.part(f"{_camel(section)}OfMaterial", _object(constants))
        own |= {"base": self._material_name(), "yield_stresses": {"type": "array", "items": label}}
        return self.part("OwnMaterial", _object({**dict.fromkeys(TEXTS, TEXT), **own}))


def _camel(name: str) -> str:
    return "".join(word.capitalize() for word in re.split(r"\W|_", name))


def _about(text: str) -> Schema:
    return {"description": text}


def _described(schema: Schema, parameter: Parameter) -> Schema:
    """A schema with what the parameter is, its limit and its default."""
    default = parameter.default
    if isinstance(default, float) and parameter.unit:
        default = readable(default, parameter.unit)
    usual = "" if default is None else f"; by default {default}"
    return {**schema, "description": f"{parameter.meaning}; {parameter.limit()}{usual}"}


def _object(properties: Schemas, required: Collection[str] = ()) -> Schema:
    """An object with these properties alone."""
    needed = {"required": [*required]} if required else {}
    return {"type": "object", "properties": properties, **needed, "additionalProperties": False}


def _with_constants(properties: Schemas, roles: Collection[str], constant: Schema) -> Schema:
    """An object with these properties, and constants of the materials of roles by their dotted paths."""
    if not roles:
        return _object(properties)
    names = [{"enum": [*properties]}, {"pattern": rf"^(?:{'|'.join(roles)})\.[A-Za-z]"}]
    closed = {"propertyNames": {"anyOf": names}, "additionalProperties": constant}
    return {"type": "object", "properties": properties, **closed}


def _any_of(*schemas: Schema) -> Schema:
    """Each of the schemas once."""
    bare = [{key: part for key, part in schema.items() if key != "description"} for schema in schemas]
    parts = [part for schema in bare for part in (schema["anyOf"] if [*schema] == ["anyOf"] else [schema])]
    once = [part for place, part in enumerate(parts) if part not in parts[:place]]
    return once[0] if len(once) == 1 else {"anyOf": once}


def _suggestions(names: Collection[str]) -> Schema:
    """Some names, and any other text."""
    return {"anyOf": [{"enum": [*names]}, TEXT]}


def _whole(least: int, most: int) -> Schema:
    return {"type": "integer", "minimum": least, "maximum": most}


def _stated(name: str) -> Schema:
    """The rule that a parameter without a default is fixed where it does not vary."""
    return {
        "if": {"properties": {"axes": {"not": {"required": [name]}}}},
        "then": {"properties": {"fixed": {"required": [name]}}, "required": ["fixed"]},
    }


# The rule that sampled points have a number and a seed, and others have none.
SAMPLED: Schema = {
    "if": {"properties": {"combine": {"enum": [*METHODS]}}, "required": ["combine"]},
    "then": {"required": ["points", "seed"]},
    "else": {"properties": {"points": NULL, "seed": NULL}},
}
