"""The words of a law's range: what catalogue, command line, cube and reports print of its limits and of reasons."""

import math
import re
from collections.abc import Iterable, Mapping

from studies.laws._range import Code, Limit, Range, Reason

# What is printed in place of an SI unit, and its size.
UNITS: Mapping[str, tuple[str, float]] = {
    "1": ("", 1.0),
    "m s-1": (" km/s", 1e3),
    "kg m-3": (" g/cm3", 1e3),
    "rad": (" deg", math.radians(1.0)),
}
# Symbols of limits in LaTeX, where it is another text.
LATEX: Mapping[str, str] = {"rho_p/rho_t": r"\rho_p/\rho_t", "projectile L/d": r"\text{projectile } L/d"}


def range_in_words(limits: Range) -> str:
    """All limits, after the words that no source states any, where none does."""
    text = "; ".join(
        f"{limit_in_words(limit)} ({limit.source}; {'checked' if limit.machine_checked else 'not checked'})"
        for limit in limits.every
    )
    return text if limits.is_published else f"no range stated by its source: {text}"


def limit_in_words(limit: Limit) -> str:
    """A limit without its source: "4 <= v <= 7 km/s"."""
    unit, size = UNITS[limit.unit]
    if limit.code is Code.BETWEEN:
        return _bounded(limit, limit.symbol, "<=", ">=") + unit
    return limit.code.limit.format(**_names(limit.names), high=limit.high / size, unit=unit)


def limit_in_latex(limit: Limit) -> str:
    """A limit without its source for pages: bounds of a number between dollar signs, words otherwise."""
    if limit.code is not Code.BETWEEN:
        return limit_in_words(limit)
    bounded = _bounded(limit, LATEX.get(limit.symbol, limit.symbol), r"\leq", r"\geq")
    return f"${bounded}${UNITS[limit.unit][0]}"


def in_words(reasons: Iterable[Reason]) -> str:
    """Why an answer is outside of the range, or there is none; empty without a reason."""
    return "; ".join(f"{_reason(reason)} ({reason.source})" if reason.source else _reason(reason) for reason in reasons)


def without_markup(latex: str) -> str:
    r"""An equation without fractions and roots as plain text.

    >>> without_markup(r"$D/d = 2.4 (\rho_p/\rho_t)^{-0.5} (t/d)^{2/3}$, $D_{\text{min}}$ in cm")
    'D/d = 2.4 (rho_p/rho_t)^-0.5 (t/d)^(2/3), D_min in cm'
    """
    text = re.sub(r"\\text{(.*?)}", r"\1", latex.replace("$", ""))
    text = re.sub(r"[\^]{([^{}]*/[^{}]*)}", r"^(\1)", text)
    return re.sub(r"[\\{}]", "", text)


def _bounded(limit: Limit, symbol: str, at_most: str, at_least: str) -> str:
    """Bounds and symbol, without the unit."""
    _, size = UNITS[limit.unit]
    low, high = limit.low / size, limit.high / size
    if not math.isfinite(high):
        return f"{symbol} {at_least} {low:g}"
    return f"{f'{low:.3g} {at_most} ' if low > 0.0 else ''}{symbol} {at_most} {high:.3g}"


def _reason(reason: Reason) -> str:
    unit, size = UNITS[reason.unit]
    value, low, high = (number / size for number in (reason.value, reason.low, reason.high))
    if reason.code is Code.BETWEEN:
        if not math.isfinite(value):
            return f"{reason.symbol} is not defined for this shot"
        side, bound = ("below", low) if value < low else ("above", high)
        return f"{reason.symbol} = {value:.3g}{unit} is {side} {bound:g}{unit}"
    return reason.code.reason.format(
        **_names(reason.names),
        found=reason.found,
        others=", ".join(f"the {role} is {material}" for role, material in reason.found.items()),
        largest=f"up to {high:.3g}{unit}" if high else "normal impact",
        **{"symbol": reason.symbol, "value": value, "low": low, "high": high, "unit": unit},
    )


def _names(names: tuple[str, ...]) -> dict[str, str]:
    return {"first": names[0] if names else "", "names": " on ".join(names)}
