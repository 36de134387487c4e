"""A run: one point of a sweep, its identity, and its cost.

The identity of a run is its content: the fully resolved problem (every default filled in, every quantity rounded to 12
significant digits) and ``PHYSICS_VERSION``. Equal content is the same run. ``studies.runs.execution``
computes it; this module loads no solver.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from solver import PHYSICS_VERSION
from solver.registry import entries
from solver.units import Described
from studies import scenarios
from studies.convergence.experience import MeshError, MeshGrid, mesh_error
from studies.materials import Material, load, simulated
from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.parameters import declared, flat, marks, parse_parameters

if TYPE_CHECKING:
    from studies.scenarios import Materials

# Parameters that choose a model, which takes constants of the materials, and the registry of each.
CHOSEN_MODELS = {"tension": ("solver.matter.tension", "TENSION"), "failure": ("solver.matter.failure", "FAILURE")}

BYTES_PER_PARTICLE = 120  # of a stored final state, compressed
# Of any run, 2 000 runs on 4 cells per diameter, 2026-11-24: 330 core seconds, of which 28 were particle-steps. The
# rest is start, observation, writing and registration.
SECONDS_OF_RUN = 0.15
# Of any run beside its particles, 200 such runs, 2026-11-24: result, log and sections 50 kB, rows of the database 10,
# its share of cube, tables and report 26.
BYTES_OF_RUN = 86_000
# Of the process of a run: interpreter, numba and xarray, seen on 2026-11-24; and each particle with its share of the
# grid (docs/speed.md, three dimensions).
MEMORY_OF_PROCESS, MEMORY_OF_PARTICLE = 310_000_000, 1_440


@dataclass(frozen=True)
class Estimate:
    """The expected cost of a run."""

    particles: int
    steps: int
    core_seconds: float
    bytes: int  # that are kept, with its share of the results of a sweep
    memory: int  # of the process that computes it, bytes


@dataclass(frozen=True)
class Run:
    """A resolved point of a sweep; everything in SI."""

    scenario: str
    parameters: Mapping[str, float | str | int | bool | None]
    materials: Mapping[str, Mapping[str, Any]]  # resolved, by the parameter that names them

    @cached_property
    def id(self) -> str:
        """Content hash, 32 hexadecimal digits."""
        content = json.dumps(self._content(), sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(content.encode()).hexdigest()[:32]

    @property
    def idle(self) -> set[str]:
        """The parameters that do not act beside the others or on its materials."""
        record = SimpleNamespace(**{**self._defaults, **self.parameters}, materials=self.materials)
        return {name for name, mark in self._described.items() if mark.acts and not mark.acts(record)}

    @property
    def _described(self) -> Mapping[str, Described]:
        return marks(scenarios.load(self.scenario).parameters, Described)

    @cached_property
    def _defaults(self) -> dict[str, Any]:
        return {name: each.default for name, each in declared(scenarios.load(self.scenario).parameters).items()}

    @property
    def mesh_grids(self) -> dict[str, MeshGrid]:
        """The grid as the mesh error of each measurement depends on it, of those of which experience may tell it."""
        return scenarios.load(self.scenario).record(self.parameters).mesh_grids(materials_of(self))

    @cached_property
    def mesh_errors(self) -> Mapping[str, MeshError]:
        """What the mesh does to each measurement, where experience tells it."""
        errors = {name: mesh_error(grid) for name, grid in self.mesh_grids.items()}
        return {name: error for name, error in errors.items() if error is not None}

    def as_json(self) -> dict[str, Any]:
        """As plain objects."""
        return {
            "scenario": self.scenario,
            "parameters": dict(self.parameters),
            "materials": {role: dict(plain) for role, plain in self.materials.items()},
        }

    @staticmethod
    def from_json(plain: Mapping[str, Any]) -> "Run":
        """The run that ``as_json`` wrote."""
        return Run(plain["scenario"], plain["parameters"], plain["materials"])

    def _content(self) -> dict[str, Any]:
        chosen, defaults = scenarios.load(self.scenario), self._defaults
        names = self.idle.union(
            chosen.materials, chosen.unused
        )  # the values that materials name are content themselves
        for name, mark in self._described.items():
            if mark.label or (mark.neutral and self.parameters.get(name, defaults[name]) == defaults[name]):
                names.add(name)
        eos_form = str(self.parameters.get("eos_form", ""))
        models = [
            entries(*registry)[name].record
            for parameter, registry in CHOSEN_MODELS.items()
            if parameter not in names and (name := str(self.parameters.get(parameter))) in entries(*registry)
        ]
        return {
            "physics": PHYSICS_VERSION,
            "scenario": self.scenario if chosen.revision == 1 else f"{self.scenario}/{chosen.revision}",
            "parameters": {k: v for k, v in self.parameters.items() if k not in names},
            "materials": {
                role: simulated(plain, chosen.measured_with, eos_form, models) for role, plain in self.materials.items()
            },
        }


def resolve(scenario: str, parameters: Mapping[str, Any], materials: Mapping[str, Material] | None = None) -> Run:
    """The run of a scenario with checked parameters (SI); raises InvalidInput with every finding.

    ``materials`` are those of some roles; the others are those that ship, by the names that the parameters give.
    """
    chosen = scenarios.load(scenario)
    values = parse_parameters(chosen.parameters, parameters, "parameters", si=True)
    roles = chosen.roles(values)
    own = materials or {}
    absent = [name for name in roles if name not in own and not values[name]]
    if absent:
        raise InvalidInput(Finding(name, "nothing", "a material", f"give a material for {name}") for name in absent)
    given = {name: own[name] if name in own else load(str(values[name])) for name in roles}
    filled = chosen.record(values).filled(given)
    resolved = {name: material.resolved() for name, material in given.items()}
    findings = filled.check(given)
    if findings:
        raise InvalidInput(findings)
    return Run(scenario, flat(filled), resolved)


def materials_of(run: Run) -> "Materials":
    """The material records of a run."""
    return {role: Material.from_resolved(plain) for role, plain in run.materials.items()}


# s per particle-step of smoothed particles in three dimensions, 12 000 of them, 2026-11-23 (``make bench``).
SMOOTHED_COST = 2.2e-6


def estimate(run: Run) -> Estimate:
    """The expected cost of a run on one core."""
    chosen = scenarios.load(run.scenario)
    size = chosen.record(run.parameters).size(materials_of(run))
    flat = run.parameters.get("geometry") == "axisymmetric"
    shape = entries("solver.grid.shapes", "SHAPE")[str(run.parameters["shape"])]
    cost = shape.flat_cost if flat else shape.box_cost
    if run.parameters.get("method", "mpm") != "mpm":
        cost = SMOOTHED_COST
    return Estimate(
        particles=size.particles,
        steps=size.steps,
        core_seconds=SECONDS_OF_RUN + size.particles * size.steps * cost,
        bytes=BYTES_OF_RUN + size.particles * BYTES_PER_PARTICLE,
        memory=MEMORY_OF_PROCESS + size.particles * MEMORY_OF_PARTICLE,
    )
