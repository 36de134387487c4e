"""The verdict: for each law, in which bands of the axes it may be used, how wrong it is elsewhere, how sure that is.

A pure function of the ``evidence``, which is read from a cube of points: the same numbers give the same words.
``bands`` groups the points, ``trends`` fits what an average would hide, ``texts`` has every word with its definition,
``headline`` the few words that come first (``openings`` where there is no law), ``summary`` what was not checked.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from studies.cubes.reading import finite
from studies.laws import OTHER_MATERIAL
from studies.reports.verdict import headline, summary, texts
from studies.reports.verdict.bands import Band, bands_of
from studies.reports.verdict.evidence import AxisOfSweep, Evidence, JudgedPoint, Reference, Subject, beside
from studies.reports.verdict.stated import LawVerdict, QuantityVerdict, StatedBand, StatedPoint, Verdict
from studies.reports.verdict.trends import exponents_of, is_uneven, trend_of


def verdict(
    evidence: Sequence[Evidence],
    axes: Sequence[AxisOfSweep],
    mixed: Mapping[str, str],
    published: Sequence[Mapping[str, Any]],
    run: str,
) -> Verdict:
    """The verdict on the quantities of a sweep.

    ``mixed`` has the quantities whose runs mix versions of the definition, each with a sentence: their values do not
    compare, so there is no verdict. ``published`` has the groups of published shots (``ComparedShots`` as plain
    values), and ``run`` is what a point is called.
    """
    if unlike := [texts.words(each.quantity) for each in evidence if each.quantity in mixed]:
        return Verdict(
            f"No verdict: runs measured {texts.joined(unlike[:3])} by different definitions; remeasure them."
        )
    names = _names([each.quantity for each in evidence]) if len(evidence) > 1 else {}
    quantities = [_of_quantity(each, axes, names.get(each.quantity, "")) for each in evidence if each.subjects]
    # The first quantity for which a law is recommended, else the first that has a judged law.
    quantities.sort(key=lambda each: (not each.recommends, not each.verdict.headline))
    stated = tuple(each.verdict for each in quantities)
    first = stated[0].headline if stated else ""
    return Verdict(
        first or headline.why_none(evidence, run),
        stated,
        summary.unchecked([each for each in evidence if each.subjects]),
        summary.shots_text(published),
        texts.terms(),
    )


class _Ranked(NamedTuple):
    recommends: bool
    verdict: QuantityVerdict


def _of_quantity(evidence: Evidence, axes: Sequence[AxisOfSweep], name: str) -> _Ranked:
    laws = tuple(
        of_law(subject, axes, has_model=evidence.has_model) for subject in evidence.subjects if not subject.drawn_only
    )
    judged = headline.judged(evidence, axes, name)
    order = list(dict.fromkeys([*(judged.order if judged else ()), *(law.subject for law in laws)]))
    return _Ranked(
        judged is not None and judged.recommends,
        QuantityVerdict(
            evidence.quantity,
            judged.text if judged else "",
            judged.rows if judged else (),
            tuple(sorted(laws, key=lambda law: (law.reference, not law.judged, order.index(law.subject)))),
            texts.outside_texts([law for law in laws if not law.judged]),
            texts.drawn_texts(evidence.subjects),
        ),
    )


def _names(quantities: Sequence[str]) -> dict[str, str]:
    """What a headline calls each quantity: without a first word that all share.

    >>> _names(["crater_depth", "crater_volume"]), _names(["final_length", "crater_depth"])
    ({'crater_depth': 'depth', 'crater_volume': 'volume'}, {'final_length': 'final length', \
'crater_depth': 'crater depth'})
    """
    shared = {name.partition("_")[0] for name in quantities}
    return {name: texts.words(name.partition("_")[2] if len(shared) == 1 else name) for name in quantities}


def of_law(subject: Subject, axes: Sequence[AxisOfSweep], *, has_model: bool = False) -> LawVerdict:
    """The verdict on one law against one reference."""
    judged = [point for point in subject.points if point.state == "judged"]
    residuals = np.array([point.residual for point in judged])
    uneven = is_uneven(residuals)
    tested = [point for point in judged if point.tests]
    is_simulation = subject.name == "simulation"
    law = LawVerdict(
        subject=subject.name,
        title=subject.title,
        reference=subject.reference,
        caveat=subject.caveat,
        no_range=subject.no_range,
        other_material=bool(subject.points) and all(OTHER_MATERIAL in point.outside for point in subject.points),
        bands=tuple(_stated(band, axes, subject.reference, is_simulation) for band in bands_of(subject.points, axes)),
        points=len(subject.points),
        judged=len(judged),
        smallest=float(residuals.min()) if judged else None,
        largest=float(residuals.max()) if judged else None,
        average=float(residuals.mean()) if judged and not uneven else None,
        trend=trend_of([point.at for point in judged], residuals, axes) if uneven else None,
        exponents=() if is_simulation else tuple(exponents_of(judged, axes)),
        tested=len(tested),
        inside=sum(abs(point.residual) <= point.bar for point in tested),
        each=tuple(_stated_point(point, subject.reference, is_simulation) for point in subject.points),
    )
    details = (
        texts.residual_text(law),
        texts.exponents_text(law),
        texts.agreement_text(law, has_model),
        texts.hanging_text(law),
    )
    return replace(law, details=tuple(filter(None, details)))


def _stated_point(point: JudgedPoint, reference: Reference, is_simulation: bool) -> StatedPoint:
    word = beside(reference, point.stated)
    return StatedPoint(
        point.at,
        finite(point.law),
        finite(point.reference),
        finite(point.residual) if point.reference else None,
        word,
        texts.OF_POINTS[word],
        "" if point.tests else texts.UNTESTED[reference, is_simulation],
        point.hangs_on,
    )


def _stated(band: Band, axes: Sequence[AxisOfSweep], reference: Reference, is_simulation: bool) -> StatedBand:
    residuals = band.residuals
    return StatedBand(
        word=beside(reference, band.stated),
        where=texts.where(band, axes),
        says=texts.word_of(band, reference, is_simulation),
        abscissa=band.abscissa,
        values=band.values,
        slices=band.slices,
        points=len(band.points),
        judged=len(band.judged),
        smallest=min(residuals, default=None),
        largest=max(residuals, default=None),
        uncertainty=max((point.bar for point in band.judged), default=None),
        beyond=band.beyond,
        untested=band.untested,
        unjudged=tuple(f"{reason} ({count})" for reason, count in band.unjudged),
    )
