"""Headlines of sweeps without a law: their main values, the limits of a search, what methods change."""

from collections.abc import Mapping, Sequence
from typing import Any

from studies.quantities.display import display_of, is_round_off, kind_of, printed_beside
from studies.reports.verdict.texts import capital, difference, joined, number_of, share, shortest, spanned, words


def of_values(extremes: Sequence[Mapping[str, Any]], flagged: str = "") -> str:
    """The main numbers of a sweep without a law: the first of each kind of quantity, as many as there are words for."""
    kinds: dict[str, Mapping[str, Any]] = {}
    for each in extremes:
        ends = (each["smallest"], each["largest"])
        again = any(ends == (other["smallest"], other["largest"]) for other in kinds.values())
        if not again and not (each["unit"] == "1" and any(ends) and all(map(is_round_off, ends))):
            kinds.setdefault(each["quantity"].partition(" ")[0], each)
    values = [_value(each) for each in kinds.values()]
    known = any(each["smallest_uncertainty"] is not None for each in extremes)
    unknown = "" if known else "; mesh error unknown"
    notes = [f"{unknown}; {flagged}", unknown] if flagged else [unknown]
    texts = [f"{capital(', '.join(values[:count]))}{note}." for count in range(3, 0, -1) for note in notes]
    return shortest(texts) if values else "No verdict: no run has a value."


def _value(extreme: Mapping[str, Any]) -> str:
    unit, name = extreme["unit"], extreme["quantity"].removesuffix(" percent")
    ends = {extreme["smallest"], extreme["largest"]}
    if unit == "1" and ends <= {0.0, 1.0}:  # an outcome
        return f"{name} in {'every run' if ends == {1.0} else 'no run' if ends == {0.0} else 'some runs'}"
    low, high = (
        printed_beside(extreme[end], kind_of(unit), extreme[f"{end}_uncertainty"]) for end in ("smallest", "largest")
    )
    shown = display_of(unit).unit
    return f"{name} {spanned(low, high)}{f' {shown}' if shown else ''}"


def of_limits(limits: Mapping[str, Any]) -> str:
    """The limits of a search: "Perforated from speed 183 m/s (180 to 186)"."""
    unit = display_of(limits["unit"]).unit
    known = [row for row in limits["rows"] if row["limit"] is not None]
    if not known:
        return f"No verdict: the search for {words(limits['of'])} found no limit."
    low, high = (number_of(pick(row["limit"] for row in known), limits["unit"]) for pick in (min, max))
    text = f"{capital(words(limits['of']))} from {limits['axis']} {spanned(low, high)} {unit}"
    if len(known) > 1:
        return f"{text} ({len(known)} limits)."
    ends = (number_of(known[0][end], limits["unit"]) for end in ("lower", "upper"))
    return f"{text}, between {' and '.join(ends)} {unit}."


def of_methods(methods: Mapping[str, Any]) -> str:
    """What the methods change of the first quantity that all of them have: "Contact time by fem 3 % low ..."."""
    for quantity in methods["quantities"]:
        rows = [row for row in quantity["rows"] if row["relative"] is not None]
        if rows:
            others = list(dict.fromkeys(row["method"] for row in rows))
            gives = difference([row["relative"] for row in rows])
            joint = [row["joint"] / abs(row["reference"]) for row in rows if row["joint"] is not None]
            bar = f"±{share(max(joint))}" if joint else "mesh error unknown"
            return shortest(
                [
                    f"{capital(quantity['label'])} by {joined(others)}: {gives}, beside {methods['first']}; {bar}.",
                    f"{capital(quantity['label'])}: {gives}, beside {methods['first']}; {bar}.",
                ]
            )
    return ""
