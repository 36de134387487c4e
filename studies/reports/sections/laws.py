"""Laws and measured shots beside the simulation."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.reports.records import Judgement, MatchedObservation, MeasuredShot, Mixed, Unchecked
from studies.reports.section import Part, Section, Source
from studies.reports.wording import text_template, worded

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Counted:
    """Why a law has no answer, or one outside of its range, with the number of such answers."""

    reason: str
    answers: int


@dataclass(frozen=True)
class LawSource:
    """A law with its equation and source."""

    name: str
    title: str
    quantity: str
    equation: str
    source: str
    range: str
    confidence: str
    scatter: float | None  # published, relative
    variants: tuple[str, ...]  # that it was evaluated with
    reasons: tuple[Counted, ...]


@dataclass(frozen=True)
class Laws:
    """How each law does, what was measured, and what was not checked."""

    judgements: tuple[Judgement, ...]
    shots: tuple[MeasuredShot, ...]  # that a point repeats
    own_shots: tuple[MatchedObservation, ...]  # with the simulation brought to their parameters
    unchecked: tuple[Unchecked, ...]
    mixed: tuple[Mixed, ...]
    sources: tuple[LawSource, ...]


def _part(source: Source) -> Part:
    """Its opening says that runs were measured by several definitions, which nothing can precede."""
    comparison = source.comparison
    record = Laws(
        judgements=comparison.judgements,
        shots=comparison.shots,
        own_shots=comparison.observations,
        unchecked=comparison.unchecked,
        mixed=comparison.mixed,
        sources=tuple(_sources(source.dataset)),
    )
    return Part(record, opening=worded(text_template("mixed.txt"), laws=record) if comparison.mixed else "")


def _sources(dataset: "xr.Dataset") -> Iterator[LawSource]:
    """Each law once, with the constants that it was evaluated with."""
    from studies.cubes import reading
    from studies.cubes import variables as cubes

    of_texts = {
        "name": cubes.LAW_NAME,
        "title": cubes.LAW_TITLE,
        "equation": cubes.LAW_EQUATION,
        "source": cubes.LAW_SOURCE,
        "range": cubes.LAW_RANGE,
        "confidence": cubes.LAW_CONFIDENCE,
    }
    for quantity in (*reading.quantities_of(dataset), *reading.critical_of(dataset)):
        if not cubes.LAW_LABEL.is_in(dataset, quantity):
            continue
        texts = {key: variable.of(dataset, quantity).values for key, variable in of_texts.items()}
        variants, reasons, scatter = (
            variable.of(dataset, quantity).values
            for variable in (cubes.LAW_VARIANT, cubes.BY_LAW_REASON, cubes.LAW_SCATTER)
        )
        for law in dict.fromkeys(texts["name"]):
            rows = [row for row, name in enumerate(texts["name"]) if name == law]
            counts = Counter(str(reason) for reason in reasons[..., rows].ravel() if reason)
            yield LawSource(
                **{key: str(column[rows[0]]) for key, column in texts.items()},
                scatter=reading.finite(float(scatter[rows[0]])),
                quantity=quantity,
                variants=tuple(str(variants[row]) for row in rows if variants[row]),
                reasons=tuple(Counted(reason, count) for reason, count in counts.most_common()),
            )


SECTION = Section(
    "laws", "Laws", 20, Laws, _part, "sections/laws.html", "sections/laws_first.html", "sections/laws_appendix.html", 0
)
