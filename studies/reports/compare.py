"""Simulation, laws and observations side by side: everything that a report says about agreement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import xarray as xr

from studies.cubes import reading
from studies.cubes.points import main_quantities, points_of
from studies.reports.evidence import evidence_of
from studies.reports.judgement import judgements_of
from studies.reports.matched import MatchedObservation, matched_observations
from studies.reports.records import Judgement, MeasuredShot, Unchecked
from studies.reports.shots import measured_shots
from studies.reports.unchecked import unchecked


@dataclass(frozen=True)
class Comparison:
    """Everything that a report says about agreement."""

    points: xr.Dataset  # of the cube: those that are compared
    observations: tuple[MatchedObservation, ...]
    judgements: tuple[Judgement, ...]
    shots: tuple[MeasuredShot, ...]  # that a point repeats
    unchecked: tuple[Unchecked, ...]
    mixed: Mapping[str, Sequence[int]]  # quantities with which nothing is compared: versions of their definition


def compare(cube: xr.Dataset) -> Comparison:
    """Compare the simulation of a cube with its laws, and both with its observations, point by point."""
    points = points_of(cube)
    observations = [shot for name in reading.quantities_of(cube) for shot in matched_observations(points, name)]
    evidence = [each for each in evidence_of(points, [shot for shot in observations if shot.is_alike]) if each.subjects]
    return Comparison(
        points=points,
        observations=tuple(observations),
        judgements=tuple(judgement for each in evidence for judgement in judgements_of(each)),
        shots=tuple(shot for name in main_quantities(points) for shot in measured_shots(points, name, observations)),
        unchecked=unchecked(evidence),
        mixed=mixed(cube),
    )


def mixed(cube: xr.Dataset) -> dict[str, Sequence[int]]:
    """Quantities whose runs mix versions of their definition, with these versions."""
    versions = {name: reading.mixed_versions(cube, name) for name in reading.quantities_of(cube)}
    return {name: each for name, each in versions.items() if each}
