"""Loads on a bar: a pressure on its end away from the wall, and gravity.

``pulse`` is a load curve, a table of time and share; ``pressure`` is what a share of 1 stands for. An axis over
``pressure`` varies the amplitude of one course.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Any, TypeVar

from solver.units import Described, MetrePerSecondSquared, Pascal
from studies.values.errors import Finding, InvalidInput
from studies.values.parameters import LongText
from studies.values.quantities import exact_number, parse_quantity, readable, refusal, round_quantity

FASTEST = 0.3  # of the wave speed: the strain at which matter moves so fast is no small one
# Nodes within two cells of the end carry the pressure (``solver.loads.REACH``), and those of the other end lie within
# one and a half of it: they stay apart until the bar is half as long.
LEAST_CELLS = 8.0
ROW = "rows of a time with its unit and a share of the pressure, apart by commas or lines"


@dataclass(frozen=True, kw_only=True)
class Loading:
    """Parameters of the loads."""

    pressure: Annotated[
        Pascal | None,
        Described(
            "pressure on the end away from the wall, a negative one pulls; by default none", -1e12, 1e12, neutral=True
        ),
    ] = None
    pulse: Annotated[
        str | None,
        LongText(10_000),
        Described(
            f"course of the pressure: {ROW}, such as '0 us 0, 1 us 1, 10 us 1, 11 us 0'; linear in between, no "
            "pressure before and after. By default the pressure stays on",
            neutral=True,
        ),
    ] = None
    gravity: Annotated[
        MetrePerSecondSquared,
        Described(
            "acceleration of all matter by a body force, towards the wall; a negative one lifts off",
            -1e12,
            1e12,
            neutral=True,
        ),
    ] = 0.0


@dataclass(frozen=True)
class Pulse:
    """A table of time and share."""

    time: tuple[float, ...]  # s, ascending from 0 or later
    share: tuple[float, ...]  # of the pressure, from -1 to 1

    @property
    def text(self) -> str:
        """The table as ``read_pulse`` reads it."""
        return ", ".join(f"{time!r} s {share!r}" for time, share in zip(self.time, self.share, strict=True))


Parameters = TypeVar("Parameters", bound=Loading)


def read_pulse(text: str) -> Pulse:
    """The table that a text writes; raises InvalidInput."""
    rows = [_read_row(row.strip()) for row in re.split(r"[,;\n]", text) if row.strip()]
    if len(rows) < 2:
        raise refusal("pulse", f"{len(rows)} rows", "at least two rows", "add a row for the end")
    for (before, _), (after, _) in pairwise(rows):
        if after <= before:
            value, limit = readable(after, "s"), f"a time after {readable(before, 's')}"
            raise refusal("pulse", value, limit, "write each time once, in ascending order")
    return Pulse(*zip(*rows, strict=True))


def _read_row(row: str) -> tuple[float, float]:
    *time, share = row.split()
    try:
        seconds = round_quantity(parse_quantity(" ".join(time), "s", "pulse"))
        part = round_quantity(exact_number(share, "pulse"))
    except InvalidInput as error:
        raise refusal("pulse", row, ROW, "write for example '0.5 us 1'") from error
    if seconds < 0.0:
        raise refusal("pulse", row, "times from 0 s", "let the table begin at 0 s or later")
    if abs(part) > 1.0:
        raise refusal("pulse", row, "shares from -1 to 1", "write the largest into pressure")
    return seconds, part


def filled_loading(parameters: Parameters) -> Parameters:
    """The parameters with the pulse as every spelling of its table gives it; one that is no table stays."""
    if parameters.pulse is None:
        return parameters
    with suppress(InvalidInput):
        return replace(parameters, pulse=read_pulse(parameters.pulse).text)
    return parameters


def is_loaded(parameters: Loading) -> bool:
    """Whether anything acts on the bar besides its wall."""
    return bool(parameters.pressure or parameters.gravity)


def added_speed(parameters: Loading, *, impedance: float, time: float) -> float:
    """Most that loads add to the speed of matter within a time (s), m/s; ``impedance`` is rho c, Pa s/m.

    A wave of pressure p moves matter at p / (rho c), and twice as fast once a free end has reflected it.
    """
    return 2.0 * abs(parameters.pressure or 0.0) / impedance + abs(parameters.gravity) * time


def check_loading(
    parameters: Any, *, density: float, sound: float, time: float, length: tuple[float, float]
) -> list[Finding]:
    """The findings about loads on matter of a density (kg/m3) and wave speed (m/s) within a time (s).

    ``length`` is that of the bar and that of a cell, m.
    """
    return [
        *_check_pulse(parameters, time),
        *_check_strength(parameters, density * sound, FASTEST * sound, time),
        *_check_length(parameters, *length),
    ]


def _check_pulse(parameters: Loading, end_time: float) -> Iterator[Finding]:
    if parameters.pulse is None:
        return
    if parameters.pressure is None:
        cure = "give pressure, or leave pulse out"
        yield Finding("pulse", "a table", "no table without a pressure", cure)
    try:
        begin = read_pulse(parameters.pulse).time[0]
    except InvalidInput as error:
        yield from error.findings
        return
    if begin >= end_time:
        limit = f"a begin before the end of the run, {readable(end_time, 's')}"
        yield Finding("pulse", readable(begin, "s"), limit, "begin earlier, or raise end_time")


def _check_strength(parameters: Any, impedance: float, fastest: float, time: float) -> Iterator[Finding]:
    """Loads keep matter below a speed (m/s), and a bar that rests has some."""
    why = f"at which matter moves at {FASTEST:g} of its wave speed"
    pressure, gravity = abs(parameters.pressure or 0.0), abs(parameters.gravity)
    if pressure > impedance * fastest:
        limit = f"at most {readable(round_quantity(impedance * fastest), 'Pa')}, {why}"
        value = readable(parameters.pressure, "Pa")
        yield Finding("pressure", value, limit, "choose a lower pressure")
    if gravity * time > fastest:
        limit = f"at most {round_quantity(fastest / time):g} m/s2, {why} at the end"
        value = f"{parameters.gravity:g} m/s2"
        yield Finding("gravity", value, limit, "choose less gravity, or an earlier end_time")
    if parameters.speed == 0.0 and not is_loaded(parameters):
        limit = "more than 0 m/s for a bar without loads"
        yield Finding("speed", "0 m/s", limit, "give speed, pressure or gravity")


def _check_length(parameters: Loading, length: float, cell: float) -> Iterator[Finding]:
    least = LEAST_CELLS * cell
    if parameters.pressure and length < least:
        limit = f"at least {LEAST_CELLS:g} cells under a pressure, {readable(least, 'm')}"
        cure = "raise the resolution (cells per diameter)"
        yield Finding("bar_length", readable(length, "m"), limit, cure)


def loads(parameters: Loading, *, axis: int, end_time: float) -> dict[str, Any]:
    """The arguments of ``Problem`` for the loads on its first body, whose wall lies below it across an axis."""
    import numpy as np

    from solver.problem import Traction

    weight = [0.0, 0.0, 0.0]
    weight[axis] = -parameters.gravity
    if not parameters.pressure:
        return {"gravity": tuple(weight)}
    # The last step may end after the end of the run.
    stays = Pulse((0.0, 2.0 * end_time), (1.0, 1.0))
    pulse = read_pulse(parameters.pulse) if parameters.pulse else stays
    traction = Traction(
        body=0, axis=axis, side=1, time=np.array(pulse.time), pressure=parameters.pressure * np.array(pulse.share)
    )
    return {"tractions": (traction,), "gravity": tuple(weight)}
