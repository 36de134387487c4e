"""Loads on a bar: a pressure on its end away from the wall, and gravity.

``pulse`` is a load curve, a table of time and share; ``pressure`` is what a share of 1 stands for. An axis over
``pressure`` varies the amplitude of one course.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Self

from solver.units import Described, MetrePerSecondSquared, Pascal
from studies.quantities.findings import Finding, InvalidInput, refusal
from studies.quantities.parameters import LongText
from studies.quantities.units import exact_number, parse_quantity, readable, round_quantity

if TYPE_CHECKING:
    from solver.problem import Problem

ROW = "rows of a time with its unit and a share of the pressure, apart by commas or lines"


@dataclass(frozen=True)
class Pulse:
    """A table of time and share."""

    time: tuple[float, ...]  # s, ascending from 0 or later
    share: tuple[float, ...]  # of the pressure, from -1 to 1

    @property
    def text(self) -> str:
        """The table as ``read_pulse`` reads it."""
        return ", ".join(f"{time!r} s {share!r}" for time, share in zip(self.time, self.share, strict=True))


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


@dataclass(frozen=True, kw_only=True)
class Loading:
    """Parameters of the loads."""

    pressure: Annotated[
        Pascal | None,
        Described("pressure on the end away from the wall, a negative one pulls; by default none", -1e12, 1e12),
    ] = None
    pulse: Annotated[
        str | None,
        LongText(10_000),
        Described(
            f"course of the pressure: {ROW}, such as '0 us 0, 1 us 1, 10 us 1, 11 us 0'; linear in between, no "
            "pressure before and after. By default the pressure stays on"
        ),
    ] = None
    gravity: Annotated[
        MetrePerSecondSquared,
        Described(
            "acceleration of all matter by a body force, towards the wall; a negative one lifts off", -1e12, 1e12
        ),
    ] = 0.0

    def filled(self) -> Self:
        """The same loads with the pulse as every spelling of its table gives it; one that is no table stays."""
        if self.pulse is None:
            return self
        with suppress(InvalidInput):
            return replace(self, pulse=read_pulse(self.pulse).text)
        return self

    def added_speed(self, *, impedance: float, time: float) -> float:
        """Most that loads add to the speed of matter within a time (s), m/s; ``impedance`` is rho c, Pa s/m.

        A wave of pressure p moves matter at p / (rho c), and twice as fast once a free end has reflected it.
        """
        return 2.0 * abs(self.pressure or 0.0) / impedance + abs(self.gravity) * time

    def check_pulse(self, end_time: float) -> Iterator[Finding]:
        """The findings about the table: it needs a pressure, and begins before the end of the run (s)."""
        if self.pulse is None:
            return
        if self.pressure is None:
            yield Finding("pulse", "a table", "no table without a pressure", "give pressure, or leave pulse out")
        try:
            begin = read_pulse(self.pulse).time[0]
        except InvalidInput as error:
            yield from error.findings
            return
        if begin >= end_time:
            limit = f"a begin before the end of the run, {readable(end_time, 's')}"
            yield Finding("pulse", readable(begin, "s"), limit, "begin earlier, or raise end_time")

    def applied_to(self, problem: "Problem") -> "Problem":
        """The problem with the loads on its first body, whose wall lies below it."""
        import numpy as np

        from solver.problem import Traction
        from solver.problem.geometry import impact_axis

        axis = impact_axis(problem.geometry)
        weight = [0.0, 0.0, 0.0]
        weight[axis] = -self.gravity
        problem = replace(problem, gravity=(weight[0], weight[1], weight[2]))
        if not self.pressure:
            return problem
        # The last step may end after the end of the run.
        stays = Pulse((0.0, 2.0 * problem.end_time), (1.0, 1.0))
        pulse = read_pulse(self.pulse) if self.pulse else stays
        traction = Traction(
            body=0, axis=axis, side=1, time=np.array(pulse.time), pressure=self.pressure * np.array(pulse.share)
        )
        return replace(problem, tractions=(traction,))
