"""Simulation, laws and observations side by side: everything that a report says about agreement."""

from dataclasses import dataclass, replace

import xarray as xr

from studies.cubes import reading
from studies.cubes.points import main_quantities, points_of
from studies.reports.judgement import judgements_of
from studies.reports.matched import matched_observations, measured_shots
from studies.reports.records import Judgement, MatchedObservation, MeasuredShot, Mixed, Unchecked


@dataclass(frozen=True)
class Comparison:
    """Everything that a report says about agreement."""

    points: xr.Dataset  # of the cube: those that are compared
    observations: tuple[MatchedObservation, ...]
    judgements: tuple[Judgement, ...]
    shots: tuple[MeasuredShot, ...]  # that a point repeats
    unchecked: tuple[Unchecked, ...]
    mixed: tuple[Mixed, ...]


def compare(cube: xr.Dataset) -> Comparison:
    """Compare the simulation of a cube with its laws, and both with its observations, point by point."""
    points = points_of(cube)
    observations = [shot for name in reading.quantities_of(cube) for shot in matched_observations(points, name)]
    judged = [
        judgements_of(points, name, [shot for shot in observations if shot.is_alike and shot.quantity == name])
        for name in main_quantities(points)
    ]
    # What was not checked once for the quantities that share it.
    unchecked: dict[Unchecked, tuple[str, ...]] = {}
    for one in (one for _, several in judged for one in several):
        alike = replace(one, quantities=())
        unchecked[alike] = unchecked.get(alike, ()) + one.quantities
    return Comparison(
        points=points,
        observations=tuple(observations),
        judgements=tuple(judgement for judgements, _ in judged for judgement in judgements),
        shots=tuple(shot for name in main_quantities(points) for shot in measured_shots(points, name, observations)),
        unchecked=tuple(replace(one, quantities=names) for one, names in unchecked.items()),
        mixed=tuple(
            Mixed(name, tuple(versions))
            for name in reading.quantities_of(cube)
            if (versions := reading.mixed_versions(cube, name))
        ),
    )
