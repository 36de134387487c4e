"""Points to which laws are fitted: measured sizes with their shots, from a cube or a table of shots."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import xarray as xr

from studies import laws, observations, scenarios
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, comparable, is_same, places_of, points_of, simulated
from studies.cubes.variable import variable_name
from studies.laws import Shot
from studies.quantities.findings import InvalidInput, nearest_cure, refusal
from studies.quantities.parameters import Value, declared
from studies.quantities.units import parse_quantity
from studies.sweeps.document import text_of
from studies.sweeps.reading import ACCEPTED, vocabulary
from studies.sweeps.sweep import Sweep

TABLE = "give a table of shots (CSV), such as docs/own-shots.csv, or one that ships by its name"
SHORT_DIGEST = 16  # hexadecimal digits of a SHA-256 in a source


@dataclass(frozen=True)
class MeasuredShots:
    """Sizes with the shots that they belong to."""

    title: str  # "craters": of the sweep or the table
    source: str  # with the digest of the file
    quantity: str
    places: tuple[Mapping[str, float | str], ...]  # values of the axes of each point; empty of a table
    shots: tuple[Shot, ...]
    values: np.ndarray  # (points,) m
    errors: np.ndarray | None  # (points,) m, standard uncertainties; None where some are unknown
    left_out: Mapping[str, int] = field(default_factory=dict)  # other points, by reason
    units: Mapping[str, str | None] = field(default_factory=dict)  # of the axes; SI

    def read_place(self, texts: Sequence[str]) -> dict[str, float | str]:
        """Values of axes from texts, "target=copper-ofhc", "speed=6 km/s"; raises InvalidInput."""
        axes = {name: value for place in self.places for name, value in place.items()}
        chosen: dict[str, float | str] = {}
        for text in texts:
            name, _, value = (part.strip() for part in text.partition("="))
            if name not in axes:
                raise refusal("--at", text, "an axis of the points", nearest_cure(name, axes))
            unit = self.units.get(name)
            chosen[name] = value
            if not isinstance(axes[name], str):
                chosen[name] = float(parse_quantity(number_or_text(value), unit or "1", f"--at {name}"))
        return chosen

    def at(self, chosen: Mapping[str, float | str]) -> "MeasuredShots":
        """The points with these values on these axes."""
        kept = [
            number
            for number, place in enumerate(self.places)
            if all(name in place and is_same(place[name], value) for name, value in chosen.items())
        ]
        return replace(
            self,
            places=tuple(self.places[number] for number in kept),
            shots=tuple(self.shots[number] for number in kept),
            values=self.values[kept],
            errors=None if self.errors is None else self.errors[kept],
        )


def number_or_text(text: str) -> float | str:
    """A text as a number where it is one: a quantity without unit is written so."""
    try:
        return float(text)
    except ValueError:
        return text


# ---- from a cube ---------------------------------------------------------------------------------


def source_of(dataset: xr.Dataset) -> str:
    """The name of the sweep of a cube, with the digest of the file where it is known."""
    text = f"cube of sweep {json.loads(dataset.attrs['sweep'])['name']}"
    digest = dataset.attrs.get("digest")
    return f"{text}, SHA-256 {digest[:SHORT_DIGEST]}" if digest else text


def quantities_of(dataset: xr.Dataset, forms: Sequence[str]) -> list[str]:
    """The quantities of a cube that are among some names."""
    return [name for name in reading.quantities_of(dataset) if name in forms]


def of_cube(dataset: xr.Dataset, quantity: str) -> MeasuredShots:
    """The points of a cube at which a quantity has a value and no flag, with converged values where there are some.

    Raises InvalidInput where the scenario describes no shot.
    """
    points = points_of(dataset)
    sweep = Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED)
    shots, places = _shots(sweep, axes_of(points)), places_of(points)
    values = comparable(points, quantity).values.ravel()
    errors = simulated(points, quantity, cubes.UNCERTAINTY).values.ravel()
    reasons = [
        ", ".join(flags).replace("_", " ") if value > 0.0 else "no value to compare"
        for value, flags in zip(values, reading.doubts_at(points, quantity), strict=True)
    ]
    kept = np.array([number for number, reason in enumerate(reasons) if not reason], int)
    return MeasuredShots(
        sweep.name,
        source_of(dataset),
        quantity,
        tuple(places[number] for number in kept),
        tuple(shots[tuple(places[number].values())] for number in kept),
        values[kept],
        _all_known(errors[kept]),
        dict(Counter(filter(None, reasons)).most_common()),
        {axis: points[axis].attrs.get("units") for axis in axes_of(points)},
    )


def _shots(sweep: Sweep, axes: Sequence[str]) -> dict[tuple[Value, ...], Shot]:
    """The shot of each point of a sweep by its place."""
    coordinates = [{variable_name(name): value for name, value in at.items()} for at in sweep.coordinates()]
    shots = list(sweep.shots())
    if len(shots) != len(coordinates):
        raise refusal("CUBE", sweep.scenario, "a scenario of impacts", "laws here are about impacts on plates")
    return {tuple(at[axis] for axis in axes): shot for at, shot in zip(coordinates, shots, strict=True)}


def _all_known(errors: np.ndarray) -> np.ndarray | None:
    return errors if errors.size and bool((np.isfinite(errors) & (errors > 0.0)).all()) else None


# ---- from a table of shots -----------------------------------------------------------------------


def of_table(source: str, forms: Sequence[str]) -> Iterator[MeasuredShots]:
    """The shots of a published table, by name, or of a CSV file: one record for each measured quantity.

    The scenario is the first that measures what the table has; what a shot does not state is the scenario's default.
    Raises InvalidInput.
    """
    text = observations.text(source) if source in observations.names() else text_of(Path(source), "CUBE", TABLE)
    digest = hashlib.sha256(text.encode()).hexdigest()[:SHORT_DIGEST]
    scenario, shots = _read_table(text)
    units = {name: parameter.unit for name, parameter in declared(scenario.parameters).items()}
    valued = [shot for shot in shots if shot.value]  # a range has none
    for quantity in dict.fromkeys(shot.quantity for shot in valued if shot.quantity in forms):
        mine = [shot for shot in valued if shot.quantity == quantity]
        errors = np.array([np.nan if shot.uncertainty is None else shot.uncertainty for shot in mine])
        yield MeasuredShots(
            Path(source).stem,
            f"table {Path(source).stem}, SHA-256 {digest}: " + "; ".join(dict.fromkeys(shot.source for shot in mine)),
            quantity,
            tuple(
                {name: value for name, value in shot.parameters.items() if isinstance(value, str | float)}
                for shot in mine
            ),
            tuple(_shot_of(shot, scenario) for shot in mine),
            np.array([shot.value for shot in mine]),
            _all_known(errors),
            units=units,
        )


def _read_table(text: str) -> tuple[scenarios.Scenario, Sequence[observations.Observation]]:
    """Scenario and shots of a table; raises InvalidInput as the last scenario reads it."""
    every = map(scenarios.load, scenarios.names())
    of_shots = [scenario for scenario in every if {"projectile", "target"} <= {*scenario.materials}]
    for scenario in of_shots:
        roles = dict.fromkeys(scenario.materials, ())
        try:
            return scenario, observations.read_observations(text, vocabulary(scenario.name, roles, {}))
        except InvalidInput:
            if scenario is of_shots[-1]:
                raise
    raise AssertionError("some scenario is of shots")


def _shot_of(observation: observations.Observation, scenario: scenarios.Scenario) -> Shot:
    defaults = {name: parameter.default for name, parameter in declared(scenario.parameters).items()}
    try:
        return laws.shot_from({**defaults, **observation.parameters})
    except KeyError as error:
        absent = error.args[0]
        raise refusal(f"CUBE: {absent}", None, f"the {absent} of each shot", f"add a column {absent}") from None
