"""The pages: a report's document printed as one HTML file, and what is left of it as another, the appendix.

A template cannot print a number: it hands it to one of the filters, with its place in the document.
So every number and every text of the page carries its place in ``report.json`` (``data-path``), and every
number its value in full.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import islice

from jinja2 import Environment
from markupsafe import Markup
from pydantic import TypeAdapter

from studies.materials.schema import CONFIDENCES
from studies.quantities.display import (
    MESH_UNKNOWN,
    display_alone,
    display_of,
    is_round_off,
    kind_of,
    printed_alone,
    printed_beside,
    printed_in,
    with_unit,
)
from studies.quantities.measured import flags_in_words
from studies.quantities.parameters import Plain
from studies.reports.drawing import charts
from studies.reports.figure import Figure, SeriesKind
from studies.reports.section import Files, Section, sections
from studies.reports.view import spread
from studies.reports.wording import environment_of, source_of, words

MOST_ROWS = 100  # rows of a table on the page; report.json has all rows
CUT = "Only the first rows are printed; report.json contains all rows."
MOST_LAWS = 8  # rows of the first screen; all laws stand on the appendix
MOST_FIRST = 2  # sections on the first screen
MOST_POINTS = 12  # rows of a table of the page, evenly over the points
MOST_FURTHER, MOST_FURTHER_PANELS = 4, 8  # figures beside the first, and their panels

FIGURES = TypeAdapter(tuple[Figure, ...])


class Node:
    """A value of the document that knows its place in it (a JSON pointer)."""

    def __init__(self, value: Plain, path: str = ""):
        self._value = value
        self._path = path

    def __getitem__(self, key: str | int | slice) -> "Node | list[Node]":
        """A part; of a slice a list of parts."""
        return [*self][key] if isinstance(key, slice) else self._part(key)

    def __getattr__(self, name: str) -> "Node":
        try:
            return self._part(name)
        except (KeyError, TypeError) as error:
            raise AttributeError(name) from error

    def _part(self, key: str | int) -> "Node":
        step = str(key).replace("~", "~0").replace("/", "~1")
        return Node(self._value[key], f"{self._path}/{step}")  # type: ignore[index]

    def __iter__(self) -> Iterator["Node"]:
        return map(self._part, self._value if isinstance(self._value, Mapping) else range(len(self)))

    def __len__(self) -> int:
        assert isinstance(self._value, Mapping | Sequence)
        return len(self._value)

    def __bool__(self) -> bool:
        return bool(self._value)


def bare(node: "Node | Plain") -> Plain:
    """The value of a node, for tests in a template."""
    return node._value if isinstance(node, Node) else node


def _value(node: "Node | Plain") -> float | str | None:
    value = bare(node)
    assert value is None or isinstance(value, int | float | str)
    return value


def _number(node: "Node | Plain") -> float | None:
    value = _value(node)
    assert not isinstance(value, str)
    return value


def _text(node: "Node | Plain") -> str:
    """A text; empty of None."""
    value = _value(node) or ""
    assert isinstance(value, str)
    return value


def number(node: Node, kind: str, bar: Node | None = None) -> Markup:
    """A number of the document on the page: in full for programs, as its kind for people, as exact as its error bar."""
    return _marked(node, printed_beside(_number(node), kind, _number(bar)))


def quantity(node: Node, unit: Node | str) -> Markup:
    """A number (or a text) with a unit, in the unit that people read."""
    value = _value(node)
    return _marked(node, value if isinstance(value, str) else printed_in(value, _text(unit) or None))


def _alone(node: Node, unit: Node | str) -> Markup:
    """A number (or a text) that stands alone, in the unit of its size: GPa of a modulus, MPa of a yield stress."""
    value = _value(node)
    return _marked(node, value if isinstance(value, str) else printed_alone(value, _text(unit) or None))


def _marked(node: Node, text: str) -> Markup:
    value = bare(node)
    full = "" if value is None else json.dumps(value, ensure_ascii=False)
    return Markup('<data value="{}" data-path="{}">{}</data>').format(full, node._path, text)


def _only_marked(value: "Node | Plain") -> str:
    """Print texts of the document with their place, and refuse numbers: the output of ``{{ }}``."""
    text = bare(value)
    if not isinstance(text, str):
        raise TypeError(f"{text!r} is printed without a format: use number or quantity")
    return Markup('<span data-path="{}">{}</span>').format(value._path, text) if isinstance(value, Node) else text


def page(report: Mapping[str, Plain], files: Files | None = None) -> str:
    """A document as one HTML file that needs no network; ``files`` are those of sections by run id, for the pictures.

    It prints on at most six sheets of A4, whatever the sweep: the appendix has what is left.
    """
    every = FIGURES.validate_python(report["figures"])
    opening = opening_figure(every)
    names = [figure.name for figure in every]
    ratio_name = "" if opening is None else f"{names[opening]}_ratio"
    ratio = names.index(ratio_name) if ratio_name in names else None
    # The first figure again where the first screen does not show all of its panels.
    further = _further(every, opening)
    template = environment().get_template("page.html")
    return template.render(
        **_shared(report, files),
        shown=[section for section in sections() if section.template and section.name in report],
        first=_first(report),
        opening_figure=opening,
        opening_drawing="" if opening is None else charts.opening(every[opening]),
        ratio_figure=ratio,
        ratio_drawing="" if ratio is None else charts.opening(every[ratio]),
        beside=[section for section in sections() if section.beside and section.name in report],
        further=further,
        drawings={number: charts.of_page(every[number], f"figure-{number}") for number in further},
    )


def opening_figure(figures: Sequence[Figure]) -> int | None:
    """The number of the figure with which a page opens: the first that sets laws or shots beside the runs."""
    return next((n for n, figure in enumerate(figures) if _says(figure, "law", "band", "observation")), None)


def appendix(report: Mapping[str, Plain], files: Files | None = None) -> str:
    """What is left of a document: every run, its audit, all laws, grids and constants."""
    every = FIGURES.validate_python(report["figures"])
    further = [number for number, figure in enumerate(every) if figure.where == "appendix"]
    template = environment().get_template("appendix.html")
    return template.render(
        **_shared(report, files),
        shown=[section for section in sections() if section.appendix and section.name in report],
        further=further,
        drawings={number: charts.of_page(every[number], f"figure-{number}") for number in further},
    )


def _first(report: Mapping[str, Plain]) -> list[Section]:
    """The sections of the first screen: that which opens the report, then by rank; values where there is no other."""
    ranked = [section for section in sections() if section.first and section.name in report]
    ranked.sort(key=lambda section: (section.name != report["opened_by"], section.rank))
    # A record says nothing where all of its lists are empty.
    others = [section for section in ranked if not section.is_fallback and any(Node(report)._part(section.name))]
    return others[:MOST_FIRST] or ranked[:1]


def _shared(report: Mapping[str, Plain], files: Files | None) -> Mapping[str, object]:
    """What templates of both pages call."""
    told = [section.words for section in sections() if section.words and section.name in report]
    return {
        "report": Node(report),
        "script": Markup(source_of("report.js")),
        "style": Markup(source_of("report.css")),
        **{name: function for words in told for name, function in words(report, files or {}).items()},
    }


def _sweep_text(node: Node) -> Markup:
    """The submitted document, indented."""
    text = json.dumps(bare(node), ensure_ascii=False, indent=2)
    return Markup('<pre data-path="{}">{}</pre>').format(node._path, text)


def _says(figure: Figure, *kinds: SeriesKind) -> bool:
    """Whether a figure of the page has series of some kinds, or more than single points."""
    series = [series for panel in figure.panels for series in panel.series]
    return figure.where == "page" and any(line.kind in kinds or len(line.x) > 1 for line in series)


def _further(figures: Sequence[Figure], opening: int | None) -> list[int]:
    """Numbers of the figures behind the first screen, as many as two sheets take."""
    chosen: list[int] = []
    for number, figure in enumerate(figures):
        is_whole = number == opening and len(figure.panels) <= charts.OPENING["wide"][1]
        panels = sum(len(figures[shown].panels) for shown in (*chosen, number))
        if _says(figure) and not is_whole and len(chosen) < MOST_FURTHER and panels <= MOST_FURTHER_PANELS:
            chosen.append(number)
    return chosen


def _compared_laws(judgements: Node) -> list[str]:
    """Names of the laws that are nearest to the simulation, without their variants."""
    names = (_text(judgement.law).partition("/")[0] for judgement in judgements if bare(judgement.compared))
    return list(dict.fromkeys(names))[:MOST_LAWS]


@cache
def environment() -> Environment:
    environment = environment_of(is_html=True)
    environment.finalize = _only_marked
    environment.tests["is"] = lambda node, other: bare(node) == bare(other)
    environment.filters.update(
        bare=bare,
        number=number,
        quantity=quantity,
        document=_sweep_text,
        kind_of=lambda unit: kind_of(_text(unit)),
        residual_kind=lambda unit: kind_of(_text(unit), residual=True),
        # A name as a column heading, with the unit that people read.
        heading=lambda name, unit: with_unit(words(_text(name)), _text(unit) or "1"),
        unit=lambda unit: display_of(_text(unit) or None).unit,
        flag=lambda name: flags_in_words([_text(name)])[0],
        keys=lambda node: list(node._value),
        evenly=lambda rows, most=MOST_POINTS: spread(list(rows), most),
        compared_laws=_compared_laws,
        troubled=lambda runs: [run for run in runs if bare(run.doubted) or bare(run.state) != "succeeded"],
        is_round_off=lambda value: is_round_off(_number(value)),
        alone=_alone,
        unit_alone=lambda value, unit: display_alone(_value(value), _text(unit) or None).unit,
        first_rows=lambda rows: list(islice(rows, MOST_ROWS)),
        quantities_of=lambda laws: list(dict.fromkeys(bare(law.quantity) for law in laws)),
        # Above a table that does not show all rows.
        cut_note=lambda rows: CUT if len(rows) > MOST_ROWS else "",
    )
    environment.globals.update(mesh_unknown=MESH_UNKNOWN, confidences=CONFIDENCES)
    return environment
