"""Bands of a sweep's axes in which a law does equally well.

Along the abscissa (the speed, where it varies) neighbouring points with the same word make a band. Where the points at
one value of the abscissa do not agree, each combination of the other axes has bands of its own there. A point that is
not judged divides nothing as long as another point at its place is; it is counted in the band.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from studies.cubes.points import Place
from studies.reports.verdict.evidence import AgreementWord, AxisOfSweep, JudgedPoint, StatedWord
from studies.reports.view import PREFERRED

BandValue = float | str | None
Key = tuple[tuple[str, float | str], ...]  # values of the other axes


@dataclass(frozen=True)
class Band:
    """Points between two values of the abscissa, of all or some combinations of the other axes."""

    word: AgreementWord
    abscissa: str
    values: tuple[BandValue, ...]  # of the abscissa, each once
    begins: bool  # whether the first of them is the first of the sweep
    ends: bool  # whether the last of them is the last of the sweep
    slices: tuple[Place, ...]  # the other axes; empty for all combinations
    points: tuple[JudgedPoint, ...]

    @property
    def judged(self) -> list[JudgedPoint]:
        return [point for point in self.points if point.state == "judged"]

    @property
    def residuals(self) -> list[float]:
        """Residuals of the judged points; of a band outside the range, of all that have one."""
        counted = self.judged
        if self.word == "outside":
            counted = [point for point in self.points if not point.unjudged]
        return [point.residual for point in counted if point.residual == point.residual]

    @property
    def untested(self) -> int:
        """Judged points whose uncertainty is no test."""
        return sum(not point.tests for point in self.judged)

    @property
    def beyond(self) -> int:
        """Judged points whose uncertainty is a test, with a difference beyond it."""
        return sum(point.tests and abs(point.residual) > point.bar for point in self.judged)

    @property
    def stated(self) -> StatedWord:
        """The word for the whole band."""
        if self.word == "close":
            return "within" if self.untested or self.beyond else "trusted"
        if self.word == "agrees" and self.untested:
            return "unjudged"
        return self.word

    @property
    def outside(self) -> list[tuple[str, int]]:
        """Why points are outside the range of the law, the most frequent first."""
        return _counted(point.outside for point in self.points if point.state == "outside")

    @property
    def unjudged(self) -> list[tuple[str, int]]:
        """Why points inside the range are not judged, the most frequent first."""
        return _counted(point.unjudged for point in self.points if point.state == "unjudged")


def _counted(reasons: Iterable[str]) -> list[tuple[str, int]]:
    return Counter(reasons).most_common()


def bands_of(points: Sequence[JudgedPoint], axes: Sequence[AxisOfSweep]) -> tuple[Band, ...]:
    """The bands of all points, along the abscissa."""
    if not points:
        return ()
    abscissa = abscissa_of(axes)
    columns = columns_of(points, abscissa)
    order = list(columns)
    bands: list[Band] = []
    for word, stretch in groupby(order, key=lambda value: _common(columns[value])):
        values = list(stretch)
        if word is not None:
            bands.append(_band(word, abscissa, values, order, (), columns))
        else:
            bands += _by_slice(values, abscissa, order, axes, columns)
    return tuple(bands)


def abscissa_of(axes: Sequence[AxisOfSweep]) -> AxisOfSweep:
    """The speed, else the first axis of numbers, else the first axis."""
    numeric = [axis for axis in axes if axis.unit is not None]
    preferred = [axis for axis in axes if axis.name == PREFERRED]
    return [*preferred, *numeric, *axes][0]


def columns_of(points: Sequence[JudgedPoint], abscissa: AxisOfSweep) -> dict[BandValue, list[JudgedPoint]]:
    """The points at each value of the abscissa; numbers ascend."""
    columns: dict[BandValue, list[JudgedPoint]] = {}
    for point in points:
        columns.setdefault(point.at.get(abscissa.name), []).append(point)
    if abscissa.unit is None:
        return columns
    return dict(sorted(columns.items(), key=lambda item: (item[0] is None, item[0] or 0.0)))


def _common(points: Sequence[JudgedPoint]) -> AgreementWord | None:
    """The word of all judged points; None where they differ."""
    words = {point.word for point in points}
    if "outside" not in words and len(words) > 1:
        words.discard("unjudged")
    return words.pop() if len(words) == 1 else None


def _by_slice(
    values: Sequence[BandValue],
    abscissa: AxisOfSweep,
    order: Sequence[BandValue],
    axes: Sequence[AxisOfSweep],
    columns: dict[BandValue, list[JudgedPoint]],
) -> Iterator[Band]:
    """The bands of a stretch in which combinations of the other axes differ: those that agree have one together."""
    others = [axis.name for axis in axes if axis != abscissa]
    slices: dict[Key, dict[BandValue, list[JudgedPoint]]] = {}
    for value in values:
        for point in columns[value]:
            key = tuple((name, point.at[name]) for name in others if name in point.at)
            slices.setdefault(key, {}).setdefault(value, []).append(point)
    alike: dict[tuple[tuple[AgreementWord | None, tuple[BandValue, ...]], ...], list[Key]] = {}
    for key, mine in slices.items():
        runs = tuple((word, tuple(stretch)) for word, stretch in groupby(mine, key=lambda value: _common(mine[value])))
        alike.setdefault(runs, []).append(key)
    for runs, keys in alike.items():
        places = tuple(dict(key) for key in keys)
        for word, stretch in runs:
            mine = {value: [point for key in keys for point in slices[key][value]] for value in stretch}
            if word is not None:
                yield _band(word, abscissa, stretch, order, places, mine)
                continue
            # Several shots at one place may differ: each then has a band of its own.
            for value, several in mine.items():
                for point in several:
                    only = {value: [point]}
                    yield _band(point.word, abscissa, [value], order, places, only)


def _band(
    word: AgreementWord,
    abscissa: AxisOfSweep,
    values: Sequence[BandValue],
    order: Sequence[BandValue],
    slices: tuple[Place, ...],
    columns: dict[BandValue, list[JudgedPoint]],
) -> Band:
    return Band(
        word,
        abscissa.name,
        tuple(values),
        values[0] == order[0],
        values[-1] == order[-1],
        slices,
        tuple(point for value in values for point in columns[value]),
    )
