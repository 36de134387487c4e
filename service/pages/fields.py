"""Fields of forms, made from the parameters of a record, and the places of findings among them."""

import re
from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Literal

from studies.quantities.findings import Finding
from studies.quantities.parameters import LONGEST_WORD, Parameter
from studies.quantities.units import readable
from studies.sweeps.axes import RANGE_KEYS
from studies.sweeps.schema import Schema, suggested

NOTHING = "nothing"  # the value in the finding of a field that is missing
OF_PARAMETERS = re.compile(r"(?:fixed|axes|parameters)\.(.+)")  # the field of a finding
# Keys whose fields have several lines, with an example.
LINES = {
    "materials": "my-alloy:\n  base: al-6061-t6\n  strength:\n    A: 300 MPa",
    "observations": "speed [km/s],hole_diameter [mm],source\n6.18,27.5,my notebook",
}
OF_MORE = ("laws", "ends")


@dataclass(frozen=True)
class FormField:
    name: str
    label: str
    hint: str
    kind: Literal["line", "lines", "choice"] = "line"
    placeholder: str = ""
    choices: tuple[str, ...] = ()
    options: str = ""  # id of the list of names that a line may have
    required: bool = False


@dataclass(frozen=True)
class FieldGroup:
    title: str
    fields: tuple[FormField, ...]


def field_of(parameter: Parameter) -> FormField:
    limit = "" if parameter.kind in ("text", "boolean") else f"; {parameter.limit()}"
    default = parameter.default
    if parameter.kind == "quantity" and isinstance(default, float):
        default = readable(default, parameter.unit or "1")
    choices = ("true", "false") if parameter.kind == "boolean" else parameter.choices
    own_list = f"choices-{parameter.name}" if choices else ""
    return FormField(
        name=parameter.name,
        label=label_of(parameter.name),
        hint=f"{parameter.meaning}{limit}",
        kind="lines" if parameter.longest > LONGEST_WORD else "line",
        placeholder="" if default is None else str(default).lower() if isinstance(default, bool) else str(default),
        choices=choices,
        options="names-of-materials" if parameter.kind == "material" else own_list,
        required=parameter.required,
    )


def field_of_key(name: str, schema: Schema) -> FormField:
    """The field of a key of a sweep's document."""
    choices = suggested(schema)
    return FormField(
        name=name,
        label=label_of(name),
        hint=schema["description"],
        kind="lines" if name in LINES else "choice" if "enum" in schema else "line",
        placeholder=LINES.get(name, ""),
        choices=choices,
        options=f"choices-{name}" if choices else "",
    )


def label_of(name: str) -> str:
    """The name of a parameter in words."""
    return name.replace("stand_off", "stand-off").replace("_", " ").capitalize()


def is_missing(found: Iterable[Finding]) -> bool:
    """Whether findings say no more than that a field is empty."""
    return all(finding.value == NOTHING for finding in found)


def placed(findings: Iterable[Finding], names: Collection[str], more: str = "") -> dict[str, list[Finding]]:
    """The findings at each field; those of no field under an empty name, or under that of a field for ``more``.

    >>> paths = ("axes.speed[1]", "axes.speed.stop", "axes.target.strength.A", "deck line 1", "axes")
    >>> [*placed([Finding(path, "", "", "") for path in paths], {"speed", "target", "deck"}, "more")]
    ['speed', 'more', 'deck', '']
    """
    at = defaultdict[str, list[Finding]](list)
    for finding in findings:
        at[_place(finding, names, more)].append(finding)
    return dict(at)


def _place(finding: Finding, names: Collection[str], more: str) -> str:
    inside = OF_PARAMETERS.fullmatch(finding.field)
    path, _, _ = (inside[1] if inside else finding.field).partition("[")
    stem, _, end = path.rpartition(".")
    if path in names:
        return path
    if inside:
        return stem if stem in names and end in RANGE_KEYS else more
    head = re.split(r"\W", path, maxsplit=1)[0]
    return head if head in names else more if head in OF_MORE else ""
