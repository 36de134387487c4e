"""The section of a debris cloud: shares of the number and mass of its pieces over their size."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class SmallestSizes:
    """Sizes below which pieces at a point mean nothing, over the projectile's diameter."""

    at: Place
    cell: float  # of the mesh
    grady: float | None  # nominal size after Grady (1988)


@dataclass(frozen=True)
class FragmentSizes:
    """A size for each point; the distributions are a figure."""

    points: tuple[SmallestSizes, ...]


def _part(source: Source) -> Part | None:
    from studies.clouds.sizes import fragment_sizes_of

    return fragment_sizes_of(source)


SECTION = Section("fragments", "Fragments", 35, FragmentSizes, _part)
