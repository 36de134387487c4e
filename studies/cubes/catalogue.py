"""Catalogue of a sweep's cube: parameters, quantities, laws, shots and sources from the rest of the studies."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from studies import laws, measurements
from studies.cubes.variable import Quantity, is_reading
from studies.laws import Law, LawValue, Shot
from studies.observations import Observation
from studies.observations.compared import ComparedShots
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Parameter, Plain, declared
from studies.runs.run import Run
from studies.sweeps.reading import vocabulary
from studies.sweeps.sweep import Sweep

MOST_FIRST = 6  # quantities at the root of a cube, where the scenario names none


@dataclass(frozen=True)
class Observed(Observation):
    """A measured shot, with what the laws are to be asked about it."""

    shot: Shot | None = None


@dataclass(frozen=True)
class LawChoice:
    """A law with one of its stated variants: one label of the law dimension."""

    law: Law
    variant: str

    @property
    def label(self) -> str:
        return f"{self.law.name}/{self.variant}" if self.variant else self.law.name

    def answer(self, shot: Shot | None) -> LawValue:
        """The law's answer for a shot; NaN with the reason where it cannot be asked."""
        if shot is None:
            return LawValue(math.nan, False, (laws.Reason(laws.Code.NO_SHOT),))
        if self.variant not in self.law.variants(shot):
            return LawValue(math.nan, False, (laws.Reason(laws.Code.NO_VARIANT, names=(self.variant,)),))
        return self.law.evaluate(shot, self.variant)


@dataclass(frozen=True)
class Catalogue:
    """The names behind a cube: nothing in it depends on what the runs gave."""

    title: str  # of the scenario
    parameters: Mapping[str, Parameter]  # of the scenario, and the axes
    quantities: Mapping[str, Quantity]  # what the scenario measures
    laws: Sequence[Law]
    shot_of: Callable[[Run], Shot | None]
    observations: Sequence[Observed] = ()
    materials: Mapping[str, Plain] = field(default_factory=dict)  # each with its numbers and sources
    compared_shots: Sequence[ComparedShots] = ()  # what whipple gives for published shots
    critical: Sequence[Quantity] = ()  # diameters that laws predict for an outcome that the scenario measures

    def choices(self, quantity: str, shots: Iterable[Shot | None]) -> list[LawChoice]:
        """Each law of a quantity with each variant that it states for one of the shots, in that order."""
        asked = [shot for shot in shots if shot is not None]
        return [
            LawChoice(law, variant)
            for law in self.laws
            if law.quantity == quantity
            for variant in dict.fromkeys(name for shot in asked for name in law.variants(shot))
        ]


def answers(choices: Sequence[LawChoice], shots: np.ndarray) -> np.ndarray:
    """The answer of each law for each shot: (shots..., laws)."""
    asked = np.empty((*shots.shape, len(choices)), object)
    for place, shot in np.ndenumerate(shots):
        for number, choice in enumerate(choices):
            asked[(*place, number)] = choice.answer(shot)
    return asked


def catalogue_of(sweep: Sweep) -> Catalogue:
    """The catalogue of a sweep, from the scenario, laws and materials that are installed."""
    scenario = sweep.definition
    allowed = vocabulary(sweep.scenario, sweep.roles(), sweep.materials)
    own = declared(scenario.parameters)
    axes = [axis.name for axis in sweep.axes]
    stated = [name for shot in sweep.observations for name in shot.parameters]
    # The constants of materials are named by their paths, their roles in the meaning.
    constants = {
        name: replace(
            allowed.parameters[name], name=name, meaning=f"{name.partition('.')[0]}: {allowed.parameters[name].meaning}"
        )
        for name in (*axes, *sweep.fixed, *stated)
        if name not in own
    }
    asked = [name for name in allowed.quantities if scenario.is_asked(name, {*axes, *sweep.fixed})]
    measured = map(measurements.load, asked)
    first = scenario.first or [name for name in asked if not is_reading(name, asked)][:MOST_FIRST]
    critical = [diameter for outcome, diameter in laws.critical().items() if outcome in allowed.quantities]
    used = [sweep.material(name) for name in dict.fromkeys(name for names in sweep.roles().values() for name in names)]
    return Catalogue(
        title=scenario.title,
        parameters={**own, **constants},
        quantities={m.name: Quantity(m.name, m.unit, m.meaning, m.outcomes, m.name in first) for m in measured},
        laws=[
            *(law for name in (*allowed.quantities, *critical) for law in laws.answering(name)),
            *(fitted.as_law() for fitted in sweep.laws),
        ],
        shot_of=_shot_of,
        observations=[_observed(shot, sweep) for shot in sweep.observations],
        materials={
            material.name: {
                "title": material.title,
                "numbers": {path: asdict(number) for path, number in material.sources.items()},
            }
            for material in used
        },
        compared_shots=sweep.compared_shots(),
        critical=[Quantity(name, "m", laws.unmeasured()[name]) for name in critical],
    )


def _shot_of(run: Run) -> Shot | None:
    """The shot of a run; None where the scenario describes none."""
    with suppress(KeyError):
        return laws.shot_from(run.parameters, run.materials)
    return None


def _observed(observation: Observation, sweep: Sweep) -> Observed:
    """A shot with the sweep's fixed parameters for all that it does not state itself."""
    shot = None
    with suppress(InvalidInput):
        shot = sweep.shot_at(observation.parameters)
    return Observed(**vars(observation), shot=shot)
