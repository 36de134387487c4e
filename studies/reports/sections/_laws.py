"""Computes the section of laws from the comparison and the cube."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.reading import finite
from studies.reports.section import Part, Source
from studies.reports.sections.laws import Counted, Laws, LawSource
from studies.reports.wording import text_template, worded


def laws_of(source: Source) -> Part:
    """The section; its opening says that runs were measured by several definitions, which nothing can precede."""
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


LAW_TEXTS = {
    "name": cubes.LAW_NAME,
    "title": cubes.LAW_TITLE,
    "equation": cubes.LAW_EQUATION,
    "source": cubes.LAW_SOURCE,
    "range": cubes.LAW_RANGE,
    "confidence": cubes.LAW_CONFIDENCE,
}


def _sources(dataset: xr.Dataset) -> Iterator[LawSource]:
    """Each law once, with the constants that it was evaluated with."""
    for quantity in (*reading.quantities_of(dataset), *reading.critical_of(dataset)):
        if not cubes.LAW_LABEL.is_in(dataset, quantity):
            continue
        texts = {key: variable.of(dataset, quantity).values for key, variable in LAW_TEXTS.items()}
        variants, reasons, scatter = (
            variable.of(dataset, quantity).values
            for variable in (cubes.LAW_VARIANT, cubes.BY_LAW_REASON, cubes.LAW_SCATTER)
        )
        for law in dict.fromkeys(texts["name"]):
            rows = np.flatnonzero(texts["name"] == law)
            counts = Counter(str(reason) for reason in reasons[..., rows].ravel() if reason)
            yield LawSource(
                **{key: str(column[rows[0]]) for key, column in texts.items()},
                scatter=finite(float(scatter[rows[0]])),
                quantity=quantity,
                variants=tuple(str(variants[row]) for row in rows if variants[row]),
                reasons=tuple(Counted(reason, count) for reason, count in counts.most_common()),
            )
