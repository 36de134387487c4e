"""A flyer of 100 cells hits a target at rest: the plateaus behind both fronts and the speed of each front.

The problem of plate impact and of elastic waves alike, in the laboratory frame. It ends when the front has crossed nine
tenths of the flyer; the first reading is taken at half that time.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from solver.matter.laws import Matter
from solver.problem import Problem
from solver.simulation import Outcome, simulate
from solver.state import Snapshot
from solver.units import Metre, MetrePerSecond
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification.setups.column import (
    ColumnProfile,
    Plateau,
    Stretch,
    column,
    half_front,
    mirrored,
    profile,
)

FLYER_CELLS = 100
SPACING: Metre = 1e-4
CROSSED = 0.9  # of the flyer, at the end
SPARE_CELLS = 10  # behind the front in the target, and around both bodies


@dataclass(frozen=True)
class Piece:
    """One of the two bodies: its matter, and how fast its front will run into it (m/s)."""

    matter: Matter
    density: float
    front_speed: MetrePerSecond


@dataclass(frozen=True)
class Wave:
    """The measured wave in one of the bodies."""

    speed: MetrePerSecond  # of the front relative to the matter ahead of it
    plateau: Plateau


@dataclass(frozen=True)
class Collision:
    """The result of a collision."""

    flyer: Wave
    target: Wave
    outcome: Outcome


def collision_problem(
    flyer: Piece, target: Piece, speed: float, recipe: Recipe, *, boost: float = 0.0, flyer_cells: int = FLYER_CELLS
) -> Problem:
    """The problem; with ``boost`` (m/s) seen from a frame that moves the other way."""
    end_time = CROSSED * flyer_cells * SPACING / flyer.front_speed
    target_cells = math.ceil(target.front_speed * end_time / SPACING) + SPARE_CELLS
    before = SPARE_CELLS + math.ceil(max(-boost, 0.0) * end_time / SPACING)
    behind = SPARE_CELLS + math.ceil((speed + max(boost, 0.0)) * end_time / SPACING)
    return column(
        [
            Stretch("flyer", flyer.matter, flyer.density, -flyer_cells * SPACING, 0.0, speed),
            Stretch("target", target.matter, target.density, 0.0, target_cells * SPACING),
        ],
        recipe,
        lower=-(flyer_cells + before) * SPACING,
        cells=flyer_cells + before + target_cells + behind,
        spacing=SPACING,
        end_time=end_time,
        boost=boost,
    )


def collide(problem: Problem) -> Collision:
    """Run the problem and read both waves off it."""
    lines: list[tuple[ColumnProfile, ColumnProfile]] = []

    def watch(snapshot: Snapshot) -> None:
        if snapshot.time > 0.0:
            lines.append((profile(snapshot, 0), profile(snapshot, 1)))

    flyer, target = (float(body.velocity[0, 0]) for body in problem.bodies)
    outcome = simulate(problem, watch, interval=0.5 * problem.end_time)
    return Collision(
        flyer=_wave([(mirrored(first), mirrored(second)) for first, second in lines], -flyer),
        target=_wave([(second, first) for first, second in lines], target),
        outcome=outcome,
    )


def _wave(pairs: list[tuple[ColumnProfile, ColumnProfile]], ahead: float) -> Wave:
    """The wave towards larger x into matter of velocity ``ahead``; each pair is the body and the one behind it."""
    readings = [_reading(body, behind) for body, behind in pairs]
    (begin, _), (end, plateau) = readings[0], readings[-1]
    elapsed = pairs[-1][0].time - pairs[0][0].time
    return Wave((end - begin) / elapsed - ahead, plateau)


def _reading(body: ColumnProfile, behind: ColumnProfile) -> tuple[float, Plateau]:
    """Front and plateau; the interface lies halfway between the particles that face each other."""
    interface = 0.5 * (float(body.place.min()) + float(behind.place.max()))
    return half_front(body, SPACING, interface)


def waves(result: Collision) -> Iterator[tuple[str, Wave]]:
    """Both waves by the name of the body."""
    yield "target", result.target
    yield "flyer", result.flyer
