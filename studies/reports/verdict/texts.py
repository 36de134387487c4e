"""The verdict on a law in words: its bands, what an average would hide, definitions of the words, printed numbers."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction

from studies.cubes.points import Place
from studies.laws.fitting.least_squares import CONFIDENCE
from studies.quantities.display import NARROW_SPACE, decimals, digits, display_of, printed_in, signed
from studies.reports.verdict.bands import Band
from studies.reports.verdict.evidence import TRUST, AxisOfSweep, Reference, StatedWord, Subject, beside
from studies.reports.verdict.stated import LawVerdict
from studies.reports.verdict.trends import UNEVEN, Exponent, Trend

MOST_WORDS = 20  # of a headline
MOST_SLICES = 3  # combinations of other axes that a band lists
MOST_REASONS = 3
SIMPLE = 1e-6  # an exponent this close to a fraction of small numbers is that fraction
LARGEST_DENOMINATOR = 6
SAME = 5e-4  # a difference that rounds to 0.0 %
OF = {"simulation": "the simulation", "observation": "the observed shots"}
NONE_AT_ALL = "no difference"
OF_POINTS: Mapping[StatedWord, str] = {
    "trusted": "holds",
    "numerically": "meets the simulation",
    "within": "close",
    "agrees": "covered by wide error bars",
    "under": "too low",
    "over": "too high",
    "outside": "outside its range",
    "unjudged": "not judged",
}
UNTESTED = {
    ("simulation", False): "mesh error unknown",
    ("observation", False): "the shots state no uncertainty",
    ("observation", True): "an error of simulation or shot is unknown",
}


# ---- bands ---------------------------------------------------------------------------------------


def word_of(band: Band, reference: Reference, is_simulation: bool) -> str:
    """How a law does in a band: "meets the simulation: 1 % low to 2 % high, ±7 %", "too low: 16 to 25 % low"."""
    if band.word == "unjudged":
        return f"not judged: {listed(band.unjudged)}"
    if band.word == "outside":
        gives = f" (it is {difference(band.residuals)})" if band.residuals and not is_simulation else ""
        return f"{'not simulated' if is_simulation else OF_POINTS['outside']}: {listed(band.outside)}{gives}"
    bar = max(point.bar for point in band.judged)
    text = difference(band.residuals) + (f", ±{share(bar)}" if bar else "")
    reasons = [f"beyond the joint uncertainty{_at(band.beyond, len(band.judged))}"] if band.stated == "within" else []
    reasons = reasons if band.beyond else []
    if band.untested and band.stated in ("within", "unjudged"):
        reasons.append(f"{UNTESTED[reference, is_simulation]}{_at(band.untested, len(band.judged))}")
    return f"{OF_POINTS[beside(reference, band.stated)]}: {text}" + (f" ({', '.join(reasons)})" if reasons else "")


def _at(count: int, judged: int) -> str:
    return "" if count == judged else f" at {count} of {judged} points"


def where(band: Band, axes: Sequence[AxisOfSweep]) -> str:
    """The place of a band: "from 6 km/s", "at 4 km/s with plate thickness 2 mm"."""
    (axis,) = [axis for axis in axes if axis.name == band.abscissa]
    text = _along(band, axis)
    if not band.slices:
        return text
    units = {axis.name: axis.unit for axis in axes}
    if len(band.slices) > MOST_SLICES:
        return f"{text} at {len(band.slices)} combinations of the other axes"
    return f"{text} with {_places(band.slices, units)}" if any(band.slices) else text


def _along(band: Band, axis: AxisOfSweep) -> str:
    name = "" if axis.name == "speed" else f"{words(axis.name)} "
    values = [value for value in band.values if value is not None]
    if not values:
        return f"without a {words(axis.name)}"
    if axis.unit is None:
        return f"for {name}{' and '.join(map(str, values))}"
    low, high = (number_of(value, axis.unit) for value in (values[0], values[-1]))
    unit = unit_of(axis.unit)
    if len(values) == 1:
        return f"at {name}{high}{unit}"
    if band.begins == band.ends:
        return f"from {name}{low} to {high}{unit}"
    return f"from {name}{low}{unit}" if band.ends else f"up to {name}{high}{unit}"


def _places(slices: Sequence[Place], units: Mapping[str, str | None]) -> str:
    """Combinations of the other axes: "plate thickness 2 and 3 mm"."""
    names = {name for place in slices for name in place}
    if len(names) == 1:
        (name,) = names
        values = joined([number_of(place[name], units[name]) for place in slices if name in place])
        return f"{words(name)} {values}{unit_of(units[name])}"
    return " and ".join(_place(place, units) for place in slices)


def _place(place: Place, units: Mapping[str, str | None]) -> str:
    return ", ".join(
        f"{words(name)} {value if isinstance(value, str) else number_of(value, units[name]) + unit_of(units[name])}"
        for name, value in place.items()
    )


def listed(reasons: Sequence[tuple[str, int]]) -> str:
    """Reasons, those of the same kind once: "t/d = 0.25 is below 0.55" is "t/d below 0.55"."""
    kinds = list(
        dict.fromkeys(
            re.sub(r" = \S+(?: [^\d\s]\S*)? is (?=below|above|narrower)", " ", reason)
            for several, _ in reasons
            for reason in several.split("; ")
        )
    )
    more = f"; and {len(kinds) - MOST_REASONS} more" if len(kinds) > MOST_REASONS else ""
    return "; ".join(kinds[:MOST_REASONS]) + more


# ---- laws ----------------------------------------------------------------------------------------


def residual_text(law: LawVerdict) -> str:
    """The average where residuals are alike, else the trend."""
    if not law.judged or law.smallest is None or law.largest is None:
        return ""
    if law.judged == 1:
        return f"At the one judged point {difference([law.smallest])}."
    if law.average is not None:
        average, ends = difference([law.average]), difference([law.smallest, law.largest])
        return f"On average {average}." if ends == average else f"On average {average}, from {ends}."
    text = f"From {difference([law.smallest, law.largest])}, so no average is given"
    return f"{text}; {_trend(law.trend)}."


def _trend(trend: Trend | None) -> str:
    if trend is None or not trend.slopes:
        return "too few points for a trend"
    clear = [slope for slope in trend.slopes if abs(slope.value) > slope.interval]
    lost = [slope for slope in trend.slopes if slope not in clear]
    texts = [
        f"{signed(100.0 * slope.value, 1)} ± {decimals(100.0 * slope.interval, 1)} percentage points per "
        f"{slope.unit or 'unit'} of {words(slope.axis)}"
        for slope in clear
    ]
    if lost:
        texts.append(f"none beyond its interval along {joined([words(slope.axis) for slope in lost])}")
    return f"linear trend over {trend.n} points: {' and '.join(texts)} ({share(CONFIDENCE)} interval)"


def exponents_text(law: LawVerdict) -> str:
    """The fitted exponents of the reference beside those of the law."""
    texts = []
    for axis in dict.fromkeys(each.axis for each in law.exponents):
        mine = [each for each in law.exponents if each.axis == axis]
        text = f"of {words(axis)} {_exponents(mine)} in {OF[law.reference]} against {_of_law(mine)} in the law"
        refuted = sum(each.is_refuted for each in mine)
        fits = f" in {refuted} of {len(mine)} fits" if len(mine) > 1 else ""
        texts.append(f"{text}, which is refuted{fits}" if refuted else text)
    return f"Exponents fitted to the same points: {'; '.join(texts)}." if texts else ""


def _exponents(mine: Sequence[Exponent]) -> str:
    """Fitted exponents; one whose interval is larger than its value is not determined."""
    sure = [each for each in mine if each.interval <= abs(each.reference)]
    if not sure:
        low, high = (
            pick(each.reference + sign * each.interval for each in mine) for pick, sign in ((min, -1.0), (max, 1.0))
        )
        return f"not determined (interval {decimals(low, 2)} to {decimals(high, 2)})"
    if len(mine) == 1:
        return f"{decimals(sure[0].reference, 2)} ± {decimals(sure[0].interval, 2)}"
    values = [each.reference for each in sure]
    lost = len(mine) - len(sure)
    note = f" (not determined in {lost} of {len(mine)} fits)" if lost else ""
    return f"{decimals(min(values), 2)} to {decimals(max(values), 2)}{note}"


def _of_law(mine: Sequence[Exponent]) -> str:
    low, high = (_simple(pick(each.law for each in mine)) for pick in (min, max))
    return low if low == high else f"{low} to {high}"


def _simple(number: float) -> str:
    """An exponent; as a fraction where it is one.

    >>> _simple(0.6666666666), _simple(0.52)
    ('2/3', '0.52')
    """
    fraction = Fraction(number).limit_denominator(LARGEST_DENOMINATOR)
    if fraction.denominator > 1 and abs(number - float(fraction)) < SIMPLE:
        return str(fraction)
    return decimals(number, 2)


def outside_texts(laws: Sequence[LawVerdict]) -> tuple[str, ...]:
    """The laws that no point can judge, with the reasons: a sentence for all that have the same, and for all that are
    for targets of other materials.
    """
    groups: dict[tuple[str, str], dict[str, list[LawVerdict]]] = {}
    others = list(dict.fromkeys(law.title for law in laws if law.other_material))
    for law in laws:
        if not law.other_material:
            says = "; ".join(f"{band.where} {band.says.partition(' (it is')[0]}" for band in law.bands)
            # The sentence names its variants at the beginning.
            says = says.replace(f"{law.subject.partition('/')[2]} is not stated", "not stated")
            groups.setdefault((law.reference, says), {}).setdefault(law.title, []).append(law)
    sentences = []
    for (reference, says), mine in groups.items():
        # Names of laws have commas and "and" of their own.
        names = "; ".join(f"{name}{_variants(variants)}" for name, variants in mine.items())
        shots = "" if reference == "simulation" else ", for the observed shots"
        sentences.append(f"{names}{shots}: {says}.")
    if others:
        sentences.append(f"For targets of other materials: {'; '.join(others)}.")
    return tuple(sentences)


def drawn_texts(subjects: Sequence[Subject]) -> tuple[str, ...]:
    """The laws that are compared and drawn alone, each once, with the reason."""
    reasons = {each.title: each.drawn_only for each in subjects if each.drawn_only}
    return tuple(f"{title}: drawn and compared, and in no verdict: {reason}." for title, reason in reasons.items())


def _variants(laws: Sequence[LawVerdict]) -> str:
    variants = [law.subject.partition("/")[2] for law in laws]
    return f" ({'; '.join(variants)})" if any(variants) else ""


def agreement_text(law: LawVerdict, has_model: bool) -> str:
    """How many differences lie inside the joint uncertainty, and what that does not say."""
    if not law.tested:
        why = UNTESTED[law.reference, law.subject == "simulation"]
        return f"No point tests it: {why}." if law.judged else ""
    text = f"Inside the joint uncertainty at {law.inside} of {law.tested} tested points"
    if has_model or law.inside == law.tested or law.subject == "simulation" or law.reference == "observation":
        return f"{text}."
    return (
        f"{text}; the error of the models was not measured at all of these points, and may be larger than the joint "
        "uncertainty says."
    )


def hanging_text(law: LawVerdict) -> str:
    """At how many points a failure alone decides whether the difference is inside the joint uncertainty."""
    counts = Counter(each for point in law.each for each in point.hangs_on)
    return " ".join(
        f"{'Inside' if each.agrees else 'Beyond'} it only if matter breaks by {each.failure}, which the joint "
        f"uncertainty does not count: at {count} of {plural(law.tested, 'tested point')}."
        for each, count in counts.items()
    )


# ---- definitions ---------------------------------------------------------------------------------


def terms() -> tuple[tuple[str, str], ...]:
    """Each word of the verdict with its definition."""
    limit = share(TRUST)
    return (
        (
            "low, high",
            'difference of the law from its reference, over the reference: "8 % low to 2 % high" is the range of all '
            "points that judge.",
        ),
        (
            "±, joint uncertainty",
            "the largest over the points: root of the sum of the squares of the parts that are assessed: numerical, "
            "definition of the measure, material and model, scatter of the law, and of an observed shot the error that "
            "it states.",
        ),
        (
            "use",
            f"differences and joint uncertainties are at most {limit}, most points have an error bar that is a test, "
            "at most a fifth of these reject, and the exponent of the law is not refuted.",
        ),
        ("reject", "the difference at a tested point is beyond the joint uncertainty."),
        (
            "untested",
            "error bars are no test at half of the points or more: the mesh error of a single resolution, or the error "
            "of an observed shot, is unknown.",
        ),
        (
            "exponent refuted",
            "the exponent of the law is outside of the interval of the exponent that is fitted to its reference at the "
            "same points.",
        ),
        ("doubtful shot", "nobody here read its source; it judges no law alone."),
        (
            "holds, meets the simulation",
            "of a band: inside the joint uncertainty at every judged point, beside observed shots that state their "
            f"error, or beside this simulation alone; difference and joint uncertainty are at most {limit}.",
        ),
        (
            "close",
            f"of a band: difference and joint uncertainty are at most {limit}, and the brackets say at how many points "
            "the difference is beyond the joint uncertainty, or which error is unknown.",
        ),
        (
            "too low, too high",
            f"of a band: the difference is larger than {limit} and than the joint uncertainty at every judged point.",
        ),
        (
            "covered by wide error bars",
            f"of a band: the difference is inside the joint uncertainty, which is wider than {limit}: neither "
            "confirmed to that nor contradicted.",
        ),
        (
            "outside its range",
            "a limit that the law's source states, or that its formula has, is not met; what it gives there is no "
            "test of the law.",
        ),
        (
            "not judged",
            "the point has no value, or carries a flag; or error bars that are no test cover the difference.",
        ),
        (
            "average, trend",
            f"an average is given where residuals have one sign and vary by no more than a factor of {digits(UNEVEN)}; "
            "elsewhere a linear trend against the axes that vary, by least squares, with its interval.",
        ),
    )


# ---- numbers -------------------------------------------------------------------------------------


def title(law: LawVerdict) -> str:
    """The title of a law with its variant."""
    return law.title + _variants([law])


def share(size: float) -> str:
    """A share in per cent: "6 %", "0.4 %".

    >>> share(0.0601), share(0.004)
    ('6\u202f%', '0.4\u202f%')
    """
    return f"{_whole(size)}{NARROW_SPACE}%"


def difference(residuals: Sequence[float]) -> str:
    """Relative differences in words, without a side that rounds to nothing.

    >>> difference([-0.25, -0.16]), difference([-0.03, 0.04]), difference([-0.0003, 0.009])
    ('16 to 25\u202f% low', '3\u202f% low to 4\u202f% high', '0 to 0.9\u202f% high')
    """
    low, high = min(residuals), max(residuals)
    if max(-low, high) < SAME:
        return NONE_AT_ALL
    if min(-low, high) >= SAME:
        return f"{share(-low)} low to {share(high)} high"
    ends = dict.fromkeys(map(_whole, sorted((abs(low), abs(high)))))
    return f"{' to '.join(ends)}{NARROW_SPACE}% {'low' if -low > high else 'high'}"


def _whole(share: float) -> str:
    return decimals(100.0 * share, 0 if abs(share) >= 0.01 else 1).removesuffix(".0")


def number_of(value: float | str, unit: str | None) -> str:
    return value if isinstance(value, str) else printed_in(value, unit)


def unit_of(unit: str | None) -> str:
    name = display_of(unit).unit
    return f" {name}" if name else ""


def words(name: str) -> str:
    return name.replace("_", " ")


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def joined(parts: Sequence[str], last: str = "and") -> str:
    """ "a", "a and b", "a, b and c"."""
    return f" {last} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def shortest(texts: Sequence[str]) -> str:
    """The first text with at most ``MOST_WORDS`` words; where none has so few, the beginning of the last one."""
    short = (text for text in texts if len(text.split()) <= MOST_WORDS)
    return next(short, f"{' '.join(texts[-1].split()[:MOST_WORDS])}…")


def spanned(low: str, high: str) -> str:
    """Two printed numbers as a range: "2-7", and one where they are the same.

    >>> spanned("2", "7"), spanned("6", "6"), spanned("−1", "2")
    ('2-7', '6', '−1 to 2')
    """
    if low == high:
        return low
    return f"{low} to {high}" if "−" in low + high else f"{low}-{high}"
