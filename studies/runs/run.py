"""A run: one point of a sweep, its identity, and its cost.

The identity of a run is its content: all of its filled parameters, at 12 significant digits, the constants of its
materials in place of their names, and ``PHYSICS_VERSION``. A parameter that does not act beside the others is None, as
is one that another distribution added since: it is no part of it. ``studies.runs.execution`` computes a run; this
module loads no solver.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypedDict, final

from solver import PHYSICS_VERSION
from solver.registry import entries
from studies import scenarios
from studies.convergence.experience import MeshError, MeshGrid, mesh_error
from studies.materials import Material, load
from studies.materials.schema import NOT_SIMULATED, OF_OPENING
from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.parameters import Plain, Value, flat, parse_parameters

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


@final
class RunSpec(TypedDict):
    """A run as plain objects, in the rows of the service and on the way to a process."""

    scenario: str
    parameters: Mapping[str, Value]
    materials: Mapping[str, Mapping[str, Plain]]


@dataclass(frozen=True)
class Run:
    """A resolved point of a sweep; everything in SI."""

    scenario: str
    parameters: Mapping[str, Value]  # filled; None where one does not act
    materials: scenarios.Materials  # by the parameter that names them

    @cached_property
    def id(self) -> str:
        """Content hash, 32 hexadecimal digits."""
        acting = {
            name: value for name, value in self.parameters.items() if value is not None and name not in self.materials
        }
        rule = entries("solver.matter.tension", "TENSION").get(str(acting.get("tension")))
        idle = () if rule is not None and rule.opens else OF_OPENING
        constants = {role: _acting(material, idle) for role, material in self.materials.items()}
        content = {"physics": PHYSICS_VERSION, "scenario": self.scenario, "parameters": acting, "materials": constants}
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    @cached_property
    def set_up(self) -> scenarios.SetUp:
        """Its parameters as the record of its scenario."""
        return scenarios.load(self.scenario).record(self.parameters)

    @property
    def mesh_grids(self) -> dict[str, MeshGrid]:
        """The grid as the mesh error of each measurement depends on it, of those of which experience may tell it."""
        return self.set_up.mesh_grids(self.materials)

    @cached_property
    def mesh_errors(self) -> Mapping[str, MeshError]:
        """What the mesh does to each measurement, where experience tells it."""
        errors = {name: mesh_error(grid) for name, grid in self.mesh_grids.items()}
        return {name: error for name, error in errors.items() if error is not None}

    def as_json(self) -> RunSpec:
        """As plain objects."""
        materials = {role: material.resolved() for role, material in self.materials.items()}
        return {"scenario": self.scenario, "parameters": dict(self.parameters), "materials": materials}

    @staticmethod
    def from_json(plain: RunSpec) -> "Run":
        """The run that ``as_json`` wrote."""
        materials = {role: Material.from_resolved(material) for role, material in plain["materials"].items()}
        return Run(plain["scenario"], plain["parameters"], materials)


def resolve(scenario: str, parameters: Mapping[str, Plain], materials: Mapping[str, Material] | None = None) -> Run:
    """The run of a scenario with checked parameters (SI), by default of materials that ship; raises InvalidInput."""
    chosen = scenarios.load(scenario)
    values = parse_parameters(chosen.parameters, parameters, "parameters", si=True)
    roles = chosen.roles(values)
    own = materials or {}
    absent = [name for name in roles if name not in own and not values[name]]
    if absent:
        raise InvalidInput(Finding(name, "nothing", "a material", f"give a material for {name}") for name in absent)
    given = {name: own[name] if name in own else load(str(values[name])) for name in roles}
    filled = chosen.record(values).filled(given)
    findings = filled.check(given)
    if findings:
        raise InvalidInput(findings)
    return Run(scenario, flat(filled), given)


def _acting(material: Material, idle: Sequence[str]) -> dict[str, Plain]:
    """The constants of a material that a run takes; some of those of heat may be idle."""
    plain = {name: value for name, value in material.resolved().items() if name not in NOT_SIMULATED}
    thermal = plain["thermal"]
    assert isinstance(thermal, Mapping)
    return {**plain, "thermal": {name: value for name, value in thermal.items() if name not in idle}}


# s per particle-step of smoothed particles in three dimensions, 12 000 of them, 2026-11-23 (``make bench``).
SMOOTHED_COST = 2.2e-6


def estimate(run: Run) -> Estimate:
    """The expected cost of a run on one core."""
    size = run.set_up.size(run.materials)
    is_flat = run.parameters.get("geometry") == "axisymmetric"
    cost = SMOOTHED_COST
    if run.parameters.get("method", "mpm") == "mpm":
        shape = entries("solver.grid.shapes", "SHAPE")[str(run.parameters["shape"])]
        cost = shape.flat_cost if is_flat else shape.box_cost
    return Estimate(
        particles=size.particles,
        steps=size.steps,
        core_seconds=SECONDS_OF_RUN + size.particles * size.steps * cost,
        bytes=BYTES_OF_RUN + size.particles * BYTES_PER_PARTICLE,
        memory=MEMORY_OF_PROCESS + size.particles * MEMORY_OF_PARTICLE,
    )
