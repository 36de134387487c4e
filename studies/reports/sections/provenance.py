"""Where a report comes from: versions and the submitted sweep."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydantic import JsonValue

from studies.reports.section import Part, Section, Source

SHOWN = ("Conventions", "institution", "source", "date_created", "undeclared_numbers")  # attributes of the cube


@dataclass(frozen=True)
class Provenance:
    """Attributes of the cube, versions of the software, and the sweep with all defaults filled in."""

    cube: Mapping[str, str | int]
    schema_version: int
    software: Mapping[str, tuple[str, ...]]
    sweep: dict[str, JsonValue]


def _part(source: Source) -> Part | None:
    import json

    attributes = source.dataset.attrs
    return Part(
        Provenance(
            cube={name: attributes[name] for name in SHOWN if name in attributes},
            schema_version=int(attributes["schema_version"]),
            software=json.loads(attributes["software"]),
            sweep=json.loads(attributes["sweep"]),
        )
    )


SECTION = Section(
    "provenance",
    "Provenance",
    100,
    Provenance,
    _part,
    "sections/provenance.html",
    appendix="sections/provenance_appendix.html",
)
