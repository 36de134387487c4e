"""The schema of report.json: a type made of the records that sections offer for it."""

from collections.abc import Mapping
from dataclasses import dataclass, make_dataclass

from pydantic import TypeAdapter


@dataclass(frozen=True)
class Report:
    """What every report says; beside it stands the record of each section."""

    report_version: int
    title: str
    headline: str


def schema_of_report(records: Mapping[str, type]) -> TypeAdapter[Report]:
    """The type of a report, from the type of the record that each section offers by its key in the document.

    A record is a dataclass, or a tuple of dataclasses; that of a section without anything to say is null or absent.
    """
    sections = [(name, record | None, None) for name, record in records.items()]
    doc = {"__doc__": Report.__doc__}
    return TypeAdapter(make_dataclass("Report", sections, bases=(Report,), namespace=doc, frozen=True))
