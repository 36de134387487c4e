"""What the rest of the studies offers to a sweep's cube: words, laws, shots, sources."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from studies import laws, measurements
from studies.cubes.variables import Quantity
from studies.values.errors import InvalidInput
from studies.values.parameters import Parameter, declared


@dataclass(frozen=True)
class Observed:
    """A measured shot, with what the laws are to be asked about it."""

    parameters: Mapping[str, float | str]  # SI, by parameter name: those that the shot states
    quantity: str  # "hole_diameter"
    value: float  # SI
    uncertainty: float | None
    source: str
    shot: Any | None  # studies.laws.Shot


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


def catalogue_of(sweep: Any) -> Catalogue:
    """The catalogue of a sweep, from the scenario, laws and materials that are installed."""
    from studies import scenarios
    from studies.sweeps.sweep import known_words

    scenario = scenarios.load(sweep.scenario)
    known = known_words(sweep.scenario, sweep.roles(), sweep.materials)
    return Catalogue(
        title=scenario.title,
        parameters=_named(sweep, declared(scenario.parameters), known.parameters),
        quantities={name: _quantity(name, unit) for name, unit in known.quantities.items()},
        laws=[law for name in known.quantities for law in laws.answering(name)],
        shot_of=_shot_of,
        observations=[_observed(one, sweep, scenario) for one in sweep.observations],
        materials=_materials(sweep),
    )


def _named(
    sweep: Any, own: Mapping[str, Parameter], known: Mapping[str, Parameter]
) -> dict[str, Parameter]:
    """The scenario's parameters, and the constants of materials that this sweep names."""
    axes = [axis.name for axis in sweep.axes]
    stated = [name for one in sweep.observations for name in one.parameters]
    extra = {
        name: replace(
            known[name], name=name, meaning=f"{name.partition('.')[0]}: {known[name].meaning}"
        )
        for name in (*axes, *sweep.fixed, *stated)
        if name not in own
    }
    return {**own, **extra}


def _quantity(name: str, unit: str) -> Quantity:
    return Quantity(name, unit, measurements.load(name).meaning)


def _shot_of(run: Any) -> Any | None:
    """The shot of a run; None where the scenario describes none."""
    try:
        return laws.shot_of(run)
    except KeyError:
        return None


def _observed(observation: Any, sweep: Any, scenario: Any) -> Observed:
    """A shot with the sweep's fixed parameters for all that it does not state itself."""
    defaults = {name: one.default for name, one in declared(scenario.parameters).items()}
    given = {**sweep.fixed, **observation.parameters}
    try:
        materials = {role: _material(role, given, defaults, sweep) for role in scenario.materials}
        shot = laws.shot_from({**defaults, **given}, materials)
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
    )


def _material(role: str, given: Mapping[str, Any], defaults: Mapping[str, Any], sweep: Any) -> Any:
    """The material of a role, with the constants that the sweep sets."""
    material = sweep.material(str(given.get(role, defaults[role])))
    for path, value in given.items():
        if path.startswith(f"{role}."):
            material = material.with_value(path.removeprefix(f"{role}."), value)
    return material


def _materials(sweep: Any) -> dict[str, Any]:
    """Every number of every material that the sweep uses, with its source."""
    names = dict.fromkeys(name for names in sweep.roles().values() for name in names)
    found = {name: sweep.material(name) for name in names}
    return {
        name: {
            "title": material.title,
            "numbers": {path: asdict(one) for path, one in material.sources.items()},
        }
        for name, material in found.items()
    }
