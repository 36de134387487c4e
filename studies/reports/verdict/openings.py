"""Headlines of sweeps without a law: outcomes, the limits of a search, what methods change, their main values."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from studies.quantities.display import display_of, is_round_off, kind_of, printed_beside
from studies.reports.verdict.texts import (
    capital,
    difference,
    joined,
    number_of,
    share,
    shortest,
    spanned,
    unit_of,
    words,
)


def of_values(extremes: Sequence[Mapping[str, Any]], flagged: str = "", shots: Sequence[Mapping[str, Any]] = ()) -> str:
    """The main numbers of a sweep without a law: the first of each kind of quantity, as many as there are words for.

    Beside each stands what the observed shots of a report say of it: "length 17.3 mm (7 % high, 1 shot)". A quantity
    with shots goes before the others.
    """
    compared = _compared(shots)
    kinds: dict[str, Mapping[str, Any]] = {}
    for each in extremes:
        ends = (each["smallest"], each["largest"])
        again = any(ends == (other["smallest"], other["largest"]) for other in kinds.values())
        if not again and not (each["unit"] == "1" and any(ends) and all(map(is_round_off, ends))):
            kinds.setdefault(each["quantity"].partition(" ")[0], each)
    ordered = sorted(kinds.values(), key=lambda each: each["quantity"] not in compared)
    values = [_value(each) + compared.get(each["quantity"], "") for each in ordered]
    known = any(each["smallest_uncertainty"] is not None for each in extremes)
    unknown = "" if known else "; mesh error unknown"
    notes = [f"{unknown}; {flagged}", unknown] if flagged else [unknown]
    texts = [f"{capital(', '.join(values[:count]))}{note}." for count in range(3, 0, -1) for note in notes]
    return shortest(texts) if values else "No verdict: no run has a value."


def _compared(shots: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """How far the simulation is off the observed shots of each quantity, by its words."""
    residuals: dict[str, list[float]] = {}
    for shot in shots:
        if shot["value"] and shot["simulation"] is not None:
            residuals.setdefault(words(shot["quantity"]), []).append(shot["simulation"] / shot["value"] - 1.0)
    return {
        quantity: f" ({difference(each)}, {len(each)} shot{'s' if len(each) > 1 else ''})"
        for quantity, each in residuals.items()
    }


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


def of_outcomes(outcomes: Mapping[str, Any], report: Mapping[str, Any]) -> str:
    """An outcome over the shots of a report: "At 6.7 km/s: wall holds at wall thickness 3 mm, undecided at 4 mm".

    Empty where no run succeeded.
    """
    rows, said = outcomes["rows"], {0.0: outcomes["words"][0], 1.0: outcomes["words"][1], None: "undecided"}
    speed = [each["value"] for each in report["fixed"] if each["name"] == "speed"]
    begin = f"At {number_of(speed[0], 'm s-1')}{unit_of('m s-1')}: " if speed else ""
    if not rows:
        return ""
    if len(rows) == 1:
        outcome, reason = rows[0]["outcome"], rows[0]["reason"]
        texts = [f"{said[outcome]}: {reason}", said[outcome]] if outcome is None else [f"{said[outcome]} ({reason})"]
        return capital(shortest([*(f"{begin}{text}." for text in texts), *(f"{text}." for text in texts)]))
    varied = [each for each in report["axes"] if len({row["at"].get(each["name"]) for row in rows}) > 1]
    if len(varied) == 1 and varied[0]["unit"]:
        texts = [_along(rows, said, varied[0])]
    else:
        texts = []
    counts = Counter(said[row["outcome"]] for row in rows)
    texts.append(", ".join(f"{word} at {counts[word]} of {len(rows)} points" for word in said.values() if counts[word]))
    if counts[said[0.0]] and outcomes.get("found"):
        texts = [f"{text} {outcomes['found']}" for text in texts]
    return capital(shortest([*(f"{begin}{text}." for text in texts), *(f"{text}." for text in texts)]))


def _along(rows: Sequence[Mapping[str, Any]], said: Mapping[float | None, str], axis: Mapping[str, Any]) -> str:
    """Outcomes along an axis: "wall holds at wall thickness 4-5 mm, wall perforated at 2 mm, undecided between"."""
    name, unit = axis["name"], axis["unit"]
    ordered = sorted(rows, key=lambda row: row["at"][name])
    stretches = [(outcome, list(several)) for outcome, several in groupby(ordered, key=lambda row: row["outcome"])]
    texts = []
    for number, (outcome, several) in enumerate(stretches):
        low, high = (number_of(several[end]["at"][name], unit) for end in (0, -1))
        where = f"{words(name)} " if not number and name != "speed" else ""
        texts.append(f"{said[outcome]} at {where}{spanned(low, high)}{unit_of(unit)}")
    if len(stretches) > 1 and all(outcome is not None for outcome, _ in stretches):
        texts.append("undecided between")
    return ", ".join(texts)


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
