"""The schema of report.json: a type made of its head and of the records that sections offer."""

from dataclasses import make_dataclass

from pydantic import TypeAdapter

from studies.reports.document import Head
from studies.reports.section import Section


def schema_of_report(sections: tuple[Section, ...]) -> TypeAdapter[Head]:
    """The type of a report; the record of a section without anything to say is absent."""
    records = [(section.name, section.record | None, None) for section in sections]
    return TypeAdapter(
        make_dataclass("Report", records, bases=(Head,), namespace={"__doc__": Head.__doc__}, frozen=True)
    )
