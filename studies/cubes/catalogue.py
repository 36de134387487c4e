"""Catalogue of a sweep's cube: parameters, quantities, laws, shots and sources from the rest of the studies."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from studies import laws, measurements
from studies.cubes.variable import Quantity
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Parameter, declared


@dataclass(frozen=True)
class Observed:
    """A measured shot, with what the laws are to be asked about it."""

    parameters: Mapping[str, float | str]  # SI, by parameter name: those that the shot states
    quantity: str  # "hole_diameter"
    value: float | None  # SI; None of a range
    uncertainty: float | None
    source: str
    shot: Any | None  # studies.laws.Shot
    confidence: str = ""  # as stated
    bounds: tuple[float | None, float | None] | None = None  # SI, of a range; None where it is open


@dataclass(frozen=True)
class LawChoice:
    """A law with one of its stated variants: one label of the law dimension."""

    law: Any  # studies.laws.Law
    variant: str

    @property
    def label(self) -> str:
        return f"{self.law.name}/{self.variant}" if self.variant else self.law.name

    def answer(self, shot: Any | None) -> Any:
        """The answer (studies.laws.LawValue) for a shot; NaN with the reason where the law cannot be asked."""
        if shot is None:
            return laws.LawValue(math.nan, False, (laws.Reason(laws.Code.NO_SHOT),))
        if self.variant not in self.law.variants(shot):
            return laws.LawValue(math.nan, False, (laws.Reason(laws.Code.NO_VARIANT, names=(self.variant,)),))
        return self.law.evaluate(shot, self.variant)


@dataclass(frozen=True)
class Catalogue:
    """The names behind a cube: nothing in it depends on what the runs gave."""

    title: str  # of the scenario
    parameters: Mapping[str, Parameter]  # of the scenario, and the axes
    quantities: Mapping[str, Quantity]  # what the scenario measures
    laws: Sequence[Any]  # studies.laws.Law
    shot_of: Callable[[Any], Any | None]  # from a Run
    observations: Sequence[Observed] = ()
    materials: Mapping[str, Any] = field(default_factory=dict)  # each with its numbers and sources
    # What whipple gives for published shots: records (studies.observations.compared.ComparedShots).
    compared_shots: Sequence[Any] = ()
    critical: Sequence[Quantity] = ()  # diameters that laws predict for an outcome that the scenario measures

    def choices(self, quantity: str, shots: Iterable[Any]) -> list[LawChoice]:
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


def _quantity(name: str, unit: str) -> Quantity:
    measurement = measurements.load(name)
    return Quantity(name, unit, measurement.meaning, measurement.outcomes)


def catalogue_of(sweep: Any) -> Catalogue:
    """The catalogue of a sweep, from the scenario, laws and materials that are installed."""
    from studies.sweeps.reading import vocabulary

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
    critical = [diameter for outcome, diameter in laws.critical().items() if outcome in allowed.quantities]
    return Catalogue(
        title=scenario.title,
        parameters={**own, **constants},
        quantities={
            name: _quantity(name, unit)
            for name, unit in allowed.quantities.items()
            if scenario.is_asked(name, {*axes, *sweep.fixed})
        },
        laws=[
            *(law for name in (*allowed.quantities, *critical) for law in laws.answering(name)),
            *(fitted.as_law() for fitted in sweep.laws),
        ],
        shot_of=_shot_of,
        observations=[_observed(shot, sweep, scenario) for shot in sweep.observations],
        materials=_materials(sweep),
        compared_shots=sweep.compared_shots(),
        critical=[Quantity(name, "m", laws.unmeasured()[name]) for name in critical],
    )


def _shot_of(run: Any) -> Any | None:
    """The shot of a run; None where the scenario describes none."""
    try:
        return laws.shot_of(run)
    except KeyError:
        return None


def _observed(observation: Any, sweep: Any, scenario: Any) -> Observed:
    """A shot with the sweep's fixed parameters for all that it does not state itself."""
    defaults = {name: each.default for name, each in declared(scenario.parameters).items()}
    stated = {**sweep.fixed, **observation.parameters}
    try:
        named = [role for role in scenario.materials if stated.get(role, defaults[role]) is not None]
        materials = {role: _material(role, stated, defaults, sweep) for role in named}
        shot = laws.shot_from({**defaults, **stated}, materials)
    except (KeyError, InvalidInput):
        shot = None
    if shot is not None and shot.speed is None:
        shot = None
    return Observed(
        observation.parameters,
        observation.quantity,
        observation.value,
        observation.uncertainty,
        observation.source,
        shot,
        observation.confidence,
        observation.bounds,
    )


def _material(role: str, stated: Mapping[str, Any], defaults: Mapping[str, Any], sweep: Any) -> Any:
    """The material of a role, with the constants that the sweep sets."""
    material = sweep.material(str(stated.get(role, defaults[role])))
    for path, value in stated.items():
        if path.startswith(f"{role}."):
            material = material.with_value(path.removeprefix(f"{role}."), value)
    return material


def _materials(sweep: Any) -> dict[str, Any]:
    """Every number of every material that the sweep uses, with its source."""
    names = dict.fromkeys(name for names in sweep.roles().values() for name in names)
    materials = {name: sweep.material(name) for name in names}
    return {
        name: {"title": material.title, "numbers": {path: asdict(number) for path, number in material.sources.items()}}
        for name, material in materials.items()
    }
