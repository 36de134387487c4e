"""Sections: what a report consists of, each with a record of the document, figures, words for the headline, templates.

A section of the spine is a file of :mod:`studies.reports.sections`; a feature offers its own through the entry-point
group ``whipple.studies.reports.sections``. Modules with sections import nothing heavy: what computes a part does so
where it is called, so that the types of a report's document are known without datasets (``when_called``).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, TypeAlias

from solver.registry import entries
from studies.quantities.parameters import Plain
from studies.reports.figure import Figure

if TYPE_CHECKING:
    import xarray as xr
    from _typeshed import DataclassInstance
    from markupsafe import Markup

    from studies.reports.compare import Comparison


Files = Mapping[str, Path]  # of sections through runs, by run id
Words: TypeAlias = "Mapping[str, Callable[..., Plain | Markup | Sequence[object] | None]]"  # what templates call


@dataclass(frozen=True)
class Source:
    """What sections read: the cube, its points beside laws and shots, and files of sections by run id."""

    dataset: "xr.Dataset"
    comparison: "Comparison"
    files: Files

    @property
    def points(self) -> "xr.Dataset":
        """The points of the cube, one value each."""
        return self.comparison.points


@dataclass(frozen=True)
class Part:
    """What a section says about one sweep."""

    record: "DataclassInstance"  # of the document
    figures: tuple[Figure, ...] = ()
    opening: str = ""  # what it would say in the headline; empty for nothing


@dataclass(frozen=True)
class Section:
    """A section of reports.

    Templates are named by their file in the folder ``templates`` of reports, or as "package:file".
    """

    name: str  # key in the document
    title: str
    place: int  # in the order of the page
    record: "type[DataclassInstance]"
    part: Callable[[Source], Part | None]  # None where a sweep has nothing of the kind
    template: str = ""  # of the page; without one the section is on the appendix alone, or draws figures alone
    first: str = ""  # of the first screen
    appendix: str = ""
    rank: int = 100  # the section of lowest rank with words for it opens the report
    is_fallback: bool = False  # on the first screen only where no other section is
    beside: str = ""  # of the first screen, beside its figure
    # What its templates call, beside what those of all sections do, for a document and the files of its runs.
    words: Callable[[Mapping[str, Plain], Files], Words] | None = None
    # What the picture of the cover shows, the picture, and a small one; None where there is none.
    cover: "Callable[[Mapping[str, Plain], Files], tuple[str, Markup, Markup] | None] | None" = None


def when_called(place: str) -> Callable[..., Any]:
    """The function at "module:name", whose module is imported at its first call."""
    return lambda *arguments: resolve_name(place)(*arguments)


def sections() -> tuple[Section, ...]:
    """All sections by their place."""
    known = entries("studies.reports.sections", "SECTION").values()
    return tuple(sorted(known, key=lambda section: section.place))
