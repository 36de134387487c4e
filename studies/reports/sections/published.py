"""What whipple itself gives for the published shots on the metal of the target."""

from dataclasses import dataclass

from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class PublishedGroup:
    """Shots of one table: simulation over observation, less one."""

    table: str
    quantity: str
    materials: tuple[str, ...]
    shots: int
    bias: tuple[float, float] | None  # interval of the mean (95 %), from five shots on
    scatter: float | None
    stated: float | None  # largest error that a shot states


@dataclass(frozen=True)
class Published:
    """All groups."""

    groups: tuple[PublishedGroup, ...]


def _part(source: Source) -> Part | None:
    import json

    groups = json.loads(source.dataset.attrs["compared_shots"]) or []
    return Part(Published(tuple(PublishedGroup(**group) for group in groups))) if groups else None


SECTION = Section("published", "Published shots", 80, Published, _part, "sections/published.html")
