"""Headlines of outcomes, of the limits of a search and of what methods change."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from studies.quantities.display import display_of
from studies.reports.words import capital, difference, joined, number_of, share, shortest, spanned, unit_of, words

NONE = "No run has a value."
MOST_STRETCHES = 4  # of an axis with one outcome each, that a headline lists


def of_mixed(quantities: Sequence[str]) -> str:
    """Runs that were measured by several versions of a definition."""
    named = joined([words(each) for each in quantities[:3]])
    return f"Runs measured {named} by different definitions: remeasure them with `whipple remeasure`."


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
        texts = list(_along(rows, said, varied[0]))
    else:
        texts = []
    counts = Counter(said[row["outcome"]] for row in rows)
    texts.append(", ".join(f"{word} at {counts[word]} of {len(rows)} points" for word in said.values() if counts[word]))
    if counts[said[0.0]] and outcomes.get("found"):
        texts = [f"{text} {outcomes['found']}" for text in texts]
    return capital(shortest([*(f"{begin}{text}." for text in texts), *(f"{text}." for text in texts)]))


def _along(
    rows: Sequence[Mapping[str, Any]], said: Mapping[float | None, str], axis: Mapping[str, Any]
) -> Iterator[str]:
    """Outcomes along an axis: "wall holds at wall thickness 4-5 mm, wall perforated at 2 mm, undecided between"."""
    name, unit = axis["name"], axis["unit"]
    ordered = sorted(rows, key=lambda row: row["at"][name])
    stretches = [(outcome, list(several)) for outcome, several in groupby(ordered, key=lambda row: row["outcome"])]
    if len(stretches) > MOST_STRETCHES:
        return
    texts = []
    for number, (outcome, several) in enumerate(stretches):
        low, high = (number_of(several[end]["at"][name], unit) for end in (0, -1))
        where = f"{words(name)} " if not number and name != "speed" else ""
        texts.append(f"{said[outcome]} at {where}{spanned(low, high)}{unit_of(unit)}")
    if len(stretches) > 1 and all(outcome is not None for outcome, _ in stretches):
        texts.append("undecided between")
    yield ", ".join(texts)


def of_limits(limits: Mapping[str, Any]) -> str:
    """The limits of a search: "Perforated from speed 183 m/s (180 to 186)"."""
    unit = display_of(limits["unit"]).unit
    known = [row for row in limits["rows"] if row["limit"] is not None]
    if not known:
        return f"The search for {words(limits['of'])} found no limit."
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
