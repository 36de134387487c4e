"""The report: what its sections say about a sweep, as one document of plain objects in SI.

:func:`report_of` gathers it from the cube alone, for ``report.json``. :mod:`studies.reports.page` prints the same
document as HTML that opens from disk without a network.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.long_texts import short_texts, with_short_texts
from studies.cubes.points import axes_of, main_quantities, plain, refinements_of
from studies.quantities.parameters import Plain
from studies.reports.compare import compare
from studies.reports.document import Axis, Head, MeasuredQuantity
from studies.reports.section import Source, sections
from studies.reports.wording import words

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

REPORT_VERSION = 1
NOTHING = "No run has a value."


@dataclass(frozen=True)
class Report:
    """A report: its head, and the record of each section that has something to say."""

    head: Head
    records: "Mapping[str, DataclassInstance]"  # by the name of the section
    texts: Mapping[str, str]  # long texts of the cube with their short forms

    def as_json(self) -> dict[str, Plain]:
        """Plain objects; a text of several lines, a deck, stands by its first line and digest."""
        parts = {name: asdict(record) for name, record in self.records.items()}
        whole = with_short_texts({**asdict(self.head), **parts}, self.texts)
        assert isinstance(whole, dict)
        return whole


def report_of(dataset: xr.Dataset, files: Mapping[str, Path] | None = None) -> Report:
    """Everything that the report says about a cube; ``files`` are those of sections by run id, for the pictures."""
    source = Source(dataset, compare(dataset), files or {})
    parts = [(section, part) for section in sections() if (part := section.part(source))]
    opener = min((pair for pair in parts if pair[1].opening), key=lambda pair: pair[0].rank, default=None)
    # Those of the section that opens the report first.
    figures = (figure for pair in sorted(parts, key=lambda pair: pair is not opener) for figure in pair[1].figures)
    points, main = source.points, main_quantities(dataset)
    head = Head(
        report_version=REPORT_VERSION,
        title=dataset.attrs["title"],
        scenario=dataset.attrs["scenario"],
        scenario_title=dataset.attrs["scenario_title"],
        headline=opener[1].opening if opener else _nothing(points, main),
        opened_by=opener[0].name if opener else "",
        axes=tuple(_axis(dataset, name) for name in axes_of(points)),
        coordinates=tuple(_axis(dataset, name) for name in axes_of(dataset)),
        quantities=tuple(
            MeasuredQuantity(name, str(dataset[name].attrs["units"]), reading.meaning_of(dataset[name]), name in main)
            for name in reading.quantities_of(dataset)
        ),
        figures=tuple(figures),
    )
    return Report(head, {section.name: part.record for section, part in parts}, short_texts(dataset))


def _nothing(points: xr.Dataset, main: Sequence[str]) -> str:
    """That no run has a value, with what the runs that ended say of the first main quantity."""
    flags = reading.flag_words(cubes.FLAGS.of(points, main[0])) if main else []
    told = [words(flag) for flag in dict.fromkeys(flag for flags_of_point in flags for flag in flags_of_point)]
    return f"No run has a value: {', '.join(told)}." if told else NOTHING


def as_json(report: Mapping[str, Plain]) -> str:
    """The report as JSON."""
    return json.dumps(report, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _axis(dataset: xr.Dataset, name: str) -> Axis:
    axis = dataset[name]
    values = tuple(dict.fromkeys(plain(value) for value in axis.values))
    return Axis(name, axis.attrs.get("units"), reading.meaning_of(axis), values, name in refinements_of(dataset))
