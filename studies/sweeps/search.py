"""The search for a limit: the value of a parameter from which on an outcome, 1 or 0, is 1.

``speed: {limit_of: perforated, between: [150 m/s, 250 m/s]}`` asks for the limit at each point of the other axes. The
next value is a pure function of the results of the runs so far, and nothing else is stored: whoever has the document
and the results goes on with a search, or says where it ended.

The first runs are those at both ends and in the middle. From then on the next value halves the widest gap between
neighbours within the interval, from the highest 0 to the lowest 1, until no gap is wider than the tolerance or the
most tries are used up. A run without an outcome, or with a 0 that a flag leaves open, is a try, so that it leaves the
interval wider.

``until: 10 %`` asks for an interval of this width over its values, and spends its runs where the answer is least known:
each value halves the chance that the limit lies between two neighbours. That chance is half what a ``Guide`` says and
half even in the logarithm, so that a guide that errs costs one run. An end is tried only where no run bounds the limit.
"""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from solver.registry import entries
from studies import measurements
from studies.observations import written
from studies.quantities.findings import Finding, Findings, nearest_cure, refusal, shown, unknown_keys
from studies.quantities.measured import doubting_flags
from studies.quantities.parameters import Parameter, Plain, parse_value
from studies.quantities.units import exact_share, parse_quantity, readable, round_quantity

if TYPE_CHECKING:
    from studies.laws import Shot

KEYS = ("limit_of", "between", "tolerance", "until")
EXAMPLE = "write {limit_of: perforated, between: [150 m/s, 250 m/s]}"
TOLERANCE = 1.0 / 64.0  # of the interval, by default: six halvings
FINEST = 1e-6  # of the interval: the least tolerance
LEAST_UNTIL, MOST_UNTIL = 1e-3, 1.0  # of the values: widths that may be asked for
EVEN = 0.5  # of the chance: what is even in the logarithm
HALVINGS = 40  # of a gap, in the logarithm, until the value is found that halves its chance

LimitOutcome = bool | None  # of an ended run; None: it failed, or ended undecided
Chance = Callable[[float], float]  # that the limit lies below a value


@dataclass(frozen=True)
class Guide:
    """The chance that a searched limit lies below a value of an axis, before any run.

    A feature guides the searches for an outcome of its own through the entry-point group
    ``whipple.studies.sweeps.search``.
    """

    name: str
    outcome: str  # of which the limit is searched
    axis: str
    chance: "Callable[[Shot], Chance | None]"  # None where it is not known
    doubt: str = ""  # why a limit of the outcome is experimental, along any axis


class SearchVerdict(StrEnum):
    """Where a search stands."""

    UNFINISHED = "unfinished"  # some of its runs have not ended
    BRACKETED = "bracketed"
    NON_MONOTONE = "non_monotone"  # a 1 lies below a 0
    NOT_BRACKETED = "not_bracketed"  # no 0 below a 1


@dataclass(frozen=True)
class Search:
    """A question for the limit of an outcome."""

    quantity: str  # a measurement that is 1 or 0
    low: float  # SI
    high: float
    tolerance: float  # of the interval that is asked for, SI
    until: float | None = None  # in its place: the width of the interval over its values
    axis: str = ""  # the parameter whose limit is searched, as a user writes it
    unit: str = "1"  # SI symbol

    def document(self) -> dict[str, Plain]:
        """The search as a document writes it."""
        low, high, tolerance = (written(value, self.unit) for value in (self.low, self.high, self.tolerance))
        width: dict[str, Plain] = {"tolerance": tolerance} if self.until is None else {"until": self.until}
        return {"limit_of": self.quantity, "between": [low, high], **width}

    def start(self, chance: Chance | None = None) -> tuple[float, ...]:
        """The values of the first runs, which need no result."""
        if self.until is not None:
            return (self.halving(self.low, self.high, chance),)
        return self.low, round_quantity(0.5 * (self.low + self.high)), self.high

    @property
    def most_tries(self) -> int:
        """The most runs of a search."""
        if self.until is not None:
            # Each halves a chance, of which a gap that is wide enough has more than EVEN of its share of the logarithm.
            return 2 + max(1, math.ceil(math.log2(math.log(self.high / self.low) / (EVEN * self.until))))
        return 2 + max(1, math.ceil(math.log2((self.high - self.low) / self.tolerance) - 1e-9))

    def is_too_wide(self, low: float, high: float) -> bool:
        """Whether an interval is wider than asked."""
        if self.until is not None:
            return math.log(high / low) > self.until * (1.0 + 1e-9)
        return high - low > self.tolerance * (1.0 + 1e-9)

    def mass(self, low: float, high: float, chance: Chance | None) -> float:
        """The chance that the limit lies between two values."""
        even = math.log(high / low) / math.log(self.high / self.low)
        whole = chance(self.high) - chance(self.low) if chance else 0.0
        if chance is None or whole <= 0.0:  # a chance that is certain from end to end tells nothing
            return even
        return EVEN * even + (1.0 - EVEN) * (chance(high) - chance(low)) / whole

    def halving(self, low: float, high: float, chance: Chance | None) -> float:
        """The value below which the limit lies as likely as above, given that it lies between two values."""
        half, below, above = 0.5 * self.mass(low, high, chance), low, high
        for _ in range(HALVINGS if chance else 1):
            middle = math.sqrt(below * above)
            below, above = (below, middle) if self.mass(low, middle, chance) > half else (middle, above)
        return round_quantity(middle)


@dataclass(frozen=True)
class SearchedLimit:
    """The answer to a search, and the values that it tried."""

    verdict: SearchVerdict
    tried: tuple[float, ...]  # ascending, SI
    next: float | None  # the value to try next; None where no run is due
    lower: float = math.nan  # the highest 0 below the lowest 1
    upper: float = math.nan  # the lowest 1 above the highest 0
    reason: str = ""  # why there is no limit, or a wider one than was asked for

    @property
    def value(self) -> float:
        """The middle of the interval; NaN without one."""
        return 0.5 * (self.lower + self.upper)


def guide_of(outcome: str, axis: str) -> Guide | None:
    """The guide of a search; None where there is none."""
    every: list[Guide] = [*entries(__name__, "GUIDE").values()]
    return next((guide for guide in every if (guide.outcome, guide.axis) == (outcome, axis)), None)


def doubts_of_searches(outcomes: Collection[str]) -> Iterator[str]:
    """A sentence for each searched outcome whose limit is experimental."""
    every: list[Guide] = [*entries(__name__, "GUIDE").values()]
    for guide in every:
        if guide.doubt and guide.outcome in outcomes:
            yield f"limit_of {guide.outcome} is experimental: {guide.doubt}"


def replay(
    search: Search, outcome_of: Callable[[float], LimitOutcome | str], chance: Chance | None = None
) -> SearchedLimit:
    """A search by ``outcome_of`` values, which may be the state of an unfinished run; ``chance`` guides ``until``."""
    tried = list(search.start(chance))
    while True:
        outcomes = {value: outcome_of(value) for value in sorted(tried)}
        limit = _limit(search, outcomes, chance)
        if limit.next is None:
            return limit
        tried.append(limit.next)
        if isinstance(outcome_of(limit.next), str):
            return SearchedLimit(SearchVerdict.UNFINISHED, tuple(sorted(tried)), limit.next)


def _limit(search: Search, outcomes: Mapping[float, LimitOutcome | str], chance: Chance | None) -> SearchedLimit:
    """Where a search stands with these outcomes, by ascending value."""
    tried = tuple(outcomes)
    if any(isinstance(outcome, str) for outcome in outcomes.values()):
        return SearchedLimit(SearchVerdict.UNFINISHED, tried, None)
    ones = [value for value, outcome in outcomes.items() if outcome]
    zeros = [value for value, outcome in outcomes.items() if outcome is False]
    is_reversed = outcomes.get(search.low) and outcomes.get(search.high) is False
    lower, upper = interval_of(outcomes)
    if not is_reversed and ones and zeros and max(zeros) > min(ones):
        lower = search.low if math.isnan(lower) else lower
        upper = search.high if math.isnan(upper) else upper
        return SearchedLimit(SearchVerdict.NON_MONOTONE, tried, None, lower, upper)
    following = None
    if len(tried) < search.most_tries:
        following = _guided(search, outcomes, chance) if search.until is not None else _halved(search, outcomes)
    if following is None and (is_reversed or not (zeros and ones)):
        ends = [end for end in (search.low, search.high) if end in outcomes] or [*zeros[-1:], *ones[:1]]
        gave = " and ".join(f"{_shown(outcomes[end])} at {readable(end, search.unit)}" for end in ends) or "undecided"
        reason = (
            f"{search.quantity.replace('_', ' ')} is {gave}; it has to be 0 at the lower end and 1 at the upper one"
        )
        return SearchedLimit(SearchVerdict.NOT_BRACKETED, tried, None, reason=reason)
    reason = ""
    if following is None and search.is_too_wide(lower, upper):
        inside = [value for value, outcome in outcomes.items() if outcome is None and lower < value < upper]
        at = ", ".join(readable(float(f"{value:.3g}"), search.unit) for value in inside)
        reason = f"wider than asked: {f'{search.quantity} is open at {at}' if at else 'no try is left'}"
    return SearchedLimit(SearchVerdict.BRACKETED, tried, following, lower, upper, reason)


def _halved(search: Search, outcomes: Mapping[float, LimitOutcome | str]) -> float | None:
    """The middle of the widest gap; None where none is wider than the tolerance, or nothing is bracketed."""
    lower, upper = interval_of(outcomes)
    inside = [value for value in outcomes if lower <= value <= upper]
    gaps = [(after - before, before) for before, after in pairwise(inside)]
    width, before = max(gaps, key=lambda gap: (gap[0], -gap[1]), default=(0.0, 0.0))
    return round_quantity(before + 0.5 * width) if search.is_too_wide(before, before + width) else None


def _guided(search: Search, outcomes: Mapping[float, LimitOutcome | str], chance: Chance | None) -> float | None:
    """The value that halves the most likely gap of those that are too wide; then an end that bounds no run."""
    assert search.until is not None
    lower, upper = interval_of(outcomes)
    low, high = (search.low if math.isnan(lower) else lower), (search.high if math.isnan(upper) else upper)
    inside = sorted({low, high, *(value for value in outcomes if low < value < high)})
    wide = [(a, b) for a, b in pairwise(inside) if search.is_too_wide(a, b)]
    if wide:
        return search.halving(*max(wide, key=lambda gap: search.mass(gap[0], gap[1], chance)), chance)
    return next((end for end in (low, high) if end not in outcomes), None)


def interval_of(outcomes: Mapping[float, LimitOutcome | str]) -> tuple[float, float]:
    """The highest 0 below the lowest 1, and the lowest 1 above the highest 0; NaN where there is none.

    >>> interval_of({2.0: False, 3.0: None, 4.0: True, 5.0: False, 6.0: True}), interval_of({2.0: True})
    ((2.0, 6.0), (nan, 2.0))
    """
    ones = [value for value, outcome in outcomes.items() if outcome]
    zeros = [value for value, outcome in outcomes.items() if outcome is False]
    lower = max((value for value in zeros if value < min(ones, default=math.inf)), default=math.nan)
    upper = min((value for value in ones if value > max(zeros, default=-math.inf)), default=math.nan)
    return lower, upper


def _shown(outcome: LimitOutcome | str) -> str:
    return "without an outcome" if outcome is None else str(int(bool(outcome)))


def decided(value: float | None, flags: Iterable[str]) -> LimitOutcome:
    """The outcome of a measured value, 1 or 0; None without one, or where it may change."""
    return None if value is None or doubting_flags(value, flags) else value > 0.5


def outcome_in(summary: Mapping[str, Any] | None, quantity: str) -> LimitOutcome:
    """The outcome among the measurements of a result, as plain values; None without one, or where it may change."""
    measured = ((summary or {}).get("measurements") or {}).get(quantity) or {}
    return decided(measured.get("value"), measured.get("flags", ()))


def read_search(parameter: Parameter, raw: Mapping[str, Plain], name: str, quantities: Collection[str]) -> Search:
    """The search of a document's axis; ``quantities`` are those of the scenario. Raises InvalidInput."""
    field = f"axes.{name}"
    if parameter.kind != "quantity":
        raise refusal(field, raw, "a list of values", "search for the limit of a quantity")
    findings = Findings()
    findings.extend(unknown_keys(raw, KEYS, field, "limit_of and between"))
    outcomes = [name for name in quantities if measurements.load(name).is_outcome]
    quantity = raw["limit_of"]
    if not isinstance(quantity, str) or quantity not in outcomes:
        limit = "what the scenario measures as 1 or 0: " + (", ".join(outcomes) or "nothing")
        findings.append(Finding(f"{field}.limit_of", shown(quantity), limit, nearest_cure(quantity, outcomes)))
    between = raw.get("between")
    pair = [*between] if isinstance(between, list | tuple) and len(between) == 2 else []
    if not pair:
        findings.append(Finding(f"{field}.between", shown(between), "two values", EXAMPLE))
    ends = [
        findings.attempt(read_end, parameter, end, f"{field}.between[{place}]", parameter.limit())
        for place, end in enumerate(pair)
    ]
    findings.check()
    low, high = (end for end in ends if end is not None)
    unit = parameter.unit or "1"
    if not low < high:
        limit = f"more than {readable(low, unit)}"
        raise refusal(f"{field}.between[1]", pair[1], limit, EXAMPLE)
    tolerance = round_quantity(TOLERANCE * (high - low))
    if raw.get("until") is not None:
        if raw.get("tolerance") is not None:
            raise refusal(f"{field}.until", raw["until"], "until, or a tolerance", "give one of the two")
        if low <= 0.0:
            raise refusal(f"{field}.between[0]", pair[0], "more than zero for until", "give a tolerance instead")
        until = exact_share(raw["until"], f"{field}.until", "10 %")
        if not LEAST_UNTIL <= until <= MOST_UNTIL:
            limit = f"{100.0 * LEAST_UNTIL:g} % to {100.0 * MOST_UNTIL:g} %"
            raise refusal(f"{field}.until", raw["until"], limit, "write until: 10 %")
        return Search(str(quantity), low, high, tolerance, until, axis=name, unit=unit)
    if raw.get("tolerance") is not None:
        # A difference of two values, without the bounds of these.
        tolerance = float(parse_quantity(raw["tolerance"], unit, f"{field}.tolerance"))
        if not FINEST * (high - low) <= tolerance <= high - low:
            limit = f"a millionth of the interval to all of it, {readable(high - low, unit)}"
            raise refusal(f"{field}.tolerance", raw["tolerance"], limit, "choose another one")
    return Search(str(quantity), low, high, tolerance, axis=name, unit=unit)


def read_end(parameter: Parameter, raw: Plain, field: str, limit: str, example: str = EXAMPLE) -> float:
    """An end of the range of a quantity (SI); ``limit`` says what is allowed where it is missing."""
    if raw is None:
        raise refusal(field, raw, limit, example)
    value = parse_value(parameter, raw, field)
    assert isinstance(value, float)
    return value
