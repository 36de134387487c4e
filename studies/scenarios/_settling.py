"""Impacts that end when what is measured on the target has settled."""

from dataclasses import dataclass
from typing import Annotated, Literal, TypeVar

from solver.units import Described, Dimensionless, Second
from studies.scenarios._impact import Impact, filled
from studies.values.errors import Finding
from studies.values.quantities import readable, round_quantity

# As the cap: 5 us at 8 mm.
WINDOW_PER_DIAMETER = 5e-6 / 8e-3  # s/m

# Of the default window. In a tenth of it a hole that grows by 5 % in the whole counts as settled (0.5 %); in a shorter
# one it does while it is being made, and the growth in its error bar says nothing.
LEAST_WINDOW = 0.1


@dataclass(frozen=True, kw_only=True)
class SettlingImpact(Impact):
    """Parameters of an impact that may end when what is measured has settled."""

    stop: Annotated[
        Literal["settled", "end_time"], Described("end when the measurement has settled, or only at end_time")
    ] = "settled"
    settled_growth: Annotated[
        Dimensionless, Described("relative growth within settled_window that counts as settled", 0.0, 0.5)
    ] = 0.005
    settled_window: Annotated[
        Second | None,
        Described(
            "time over which growth is judged; by default 5 us at 8 mm, in proportion to the diameter; a tenth of "
            "that at least",
            1e-9,
            1.0,
        ),
    ] = None


Settled = TypeVar("Settled", bound=SettlingImpact)


def filled_settling(parameters: Settled, **derived: float) -> Settled:
    """As ``filled``, with the window over which growth is judged."""
    return filled(parameters, settled_window=settled_window(parameters), **derived)


def settled_window(parameters: SettlingImpact) -> float:
    """Time over which growth is judged, s."""
    return parameters.settled_window or _default_window(parameters)


def check_window(parameters: SettlingImpact) -> list[Finding]:
    """Growth is judged over long enough a time to be seen."""
    window, default = settled_window(parameters), round_quantity(_default_window(parameters))
    least = round_quantity(LEAST_WINDOW * default)
    if window >= least:
        return []
    limit = f"at least {LEAST_WINDOW:g} of its default at this diameter, {readable(least, 's')}"
    cure = f"leave it out: the default is {readable(default, 's')}"
    return [Finding("settled_window", readable(window, "s"), limit, cure)]


def _default_window(parameters: SettlingImpact) -> float:
    return WINDOW_PER_DIAMETER * parameters.projectile_diameter
