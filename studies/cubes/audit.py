"""Numbers that runs state about themselves, as variables of the cube: the audit at the end, and balances over time.

A feature adds numbers of its runs through the entry-point group ``whipple.studies.cubes.audit``.
"""

from dataclasses import dataclass
from functools import cache, partial

from solver.registry import entries
from studies.cubes.variable import RUNS, Variable
from studies.quantities.measured import ENERGY_DRIFT_LIMIT


@dataclass(frozen=True)
class AuditNumber:
    """A number that a run states about its own quality."""

    name: str  # as in the result of the run
    unit: str
    meaning: str
    share: bool = False  # people read it in per cent
    limit: float | None = None  # beyond it, on either side of zero, a run is marked
    shown: bool = True  # in the report

    @property
    def variable(self) -> Variable:
        """Its variable of the cube; a record is a cell."""
        return Variable(
            f"audit_{self.name}",
            self.meaning,
            lambda cell: cell.result.numbers.get(self.name),
            RUNS,
            self.unit,
            label=self.name.replace("_", " "),
            group="runs",
        )


_share = partial(AuditNumber, unit="1", share=True)
_drift = partial(_share, limit=ENERGY_DRIFT_LIMIT)

AUDIT = (
    AuditNumber("cells_per_diameter", "1", "grid cells across the diameter of the projectile or bar"),
    AuditNumber("cells_per_thickness", "1", "grid cells through the target, or the flyer where plates meet"),
    AuditNumber("particles", "1", "particles of the simulation"),
    AuditNumber("steps", "1", "time steps taken"),
    AuditNumber("particle_steps", "1", "particles times the steps that each was moved"),
    AuditNumber("end_time", "s", "simulated time at the end"),
    AuditNumber("smallest_step", "s", "smallest time step"),
    _drift("energy_drift", meaning="energy unaccounted for at the end, over the initial energy and the loads' work"),
    _drift("largest_energy_drift", meaning="largest energy drift at any time of the run"),
    _share("momentum_error", meaning="momentum unaccounted for, over the initial momentum"),
    _share("mass_error", meaning="mass unaccounted for, over the initial mass"),
    _share("hottest_energy_share", meaning="share of internal energy in the hottest 0.1 % of particles"),
    _share(
        "removed_energy_fraction",
        meaning="energy removed by walls, absorbing surfaces, contact, damping, over the initial and the loads' work",
    ),
    _share(
        "contact_energy_fraction",
        meaning="energy removed by contact of bodies alone, over the initial and the loads' work",
    ),
    _share("outflow_mass_fraction", meaning="mass that left the grid or was retired, over the initial"),
    _share(
        "outflow_energy_fraction",
        meaning="energy that left the grid or was retired, over the initial and the loads' work",
    ),
    _share("expanding_mass_fraction", meaning="mass whose pressure still drove it apart as it left, over the initial"),
    _share(
        "discarded_mass_fraction", meaning="mass of stray particles of debris that were discarded, over the initial"
    ),
    # Zero in every scenario but those of bars.
    AuditNumber("load_work", "J", "work of pressures and gravity up to the end, on whole bodies", shown=False),
    _share("separated_mass_fraction", meaning="target not connected to its rim, or gone, over its mass"),
    _share("fast_mass_fraction", meaning="connected target above 300 m/s, over the target's mass"),
    _share("molten_mass_fraction", meaning="molten mass once all matter has expanded to no pressure, over the initial"),
    _share("vaporised_mass_fraction", meaning="mass hot enough to vaporise at no pressure, over the initial"),
    AuditNumber("largest_speed", "m s-1", "largest speed of a particle"),
    AuditNumber("tension_floors", "1", "uses of the floor that limits tension"),
    AuditNumber("beyond_hugoniot", "1", "states compressed beyond the Hugoniot's limit"),
    AuditNumber("below_zero_kelvin", "1", "states whose energy gave a negative temperature"),
    AuditNumber("below_expansion", "1", "states thinner than the range of the equation of state"),
    # A state is a particle in a step: what people ask for is the molten mass.
    AuditNumber("molten", "1", "states at or above the melting point", shown=False),
    AuditNumber("sound_floors", "1", "uses of the floor of the sound speed in the time step"),
    AuditNumber("unstable", "1", "states whose pressure falls with density"),
    AuditNumber("failed", "1", "particles that failed for good"),
    AuditNumber("reflected", "1", "particles turned back at a wall"),
    AuditNumber("discarded", "1", "stray particles of debris whose state was unphysical, and that were discarded"),
)


@cache
def audit_numbers() -> tuple[AuditNumber, ...]:
    """Every number of the audit, those of features at the end."""
    offered: list[AuditNumber] = [*entries(__name__, "AUDIT").values()]
    return tuple(sorted(offered, key=lambda number: AUDIT.index(number) if number in AUDIT else len(AUDIT)))


@dataclass(frozen=True)
class RunHistory:
    """A number of a run over time: of each body, or of all."""

    name: str  # as in the histories of a result
    unit: str
    meaning: str
    by_body: bool = True

    @property
    def variable(self) -> Variable:
        """Its variable of the cube; a record is the values of a run, or those of a body in it."""
        return Variable(
            # Quantities have histories too: those of bodies are told apart.
            f"{'body_' if self.by_body else ''}{self.name}_history",
            f"{self.meaning}, over history_time",
            lambda values: values,
            (*RUNS, BODY, "sample") if self.by_body else (*RUNS, "sample"),
            self.unit,
            label=f"{self.name.replace('_', ' ')}, history",
        )


BODY = "body"
BODY_NAME = Variable(BODY, "body of the problem", str, (BODY,), kind="text")

# The sum of the energies over kinds and bodies, less the work of loads, is the initial energy and what the audit calls
# drift; that of the momenta, less the impulse, is the initial momentum. Models of a sector count for the whole.
HISTORIES = (
    RunHistory("kinetic_energy", "J", "kinetic energy of the particles of a body on the grid"),
    RunHistory("internal_energy", "J", "internal energy of the particles of a body on the grid"),
    RunHistory("departed_energy", "J", "energy of the particles that left the grid or were retired"),
    RunHistory("axial_momentum", "N s", "momentum along the line of flight, on the grid"),
    RunHistory(
        "departed_axial_momentum",
        "N s",
        "momentum along the line of flight of the particles that left the grid or were retired",
    ),
    RunHistory("contact_energy", "J", "energy that contact of the bodies removed", by_body=False),
    RunHistory(
        "otherwise_removed_energy", "J", "energy that damping, walls and absorbing surfaces removed", by_body=False
    ),
    RunHistory("load_work", "J", "work of pressures and gravity", by_body=False),
    RunHistory(
        "axial_impulse",
        "N s",
        "impulse that faces, absorbing surfaces and loads gave along the line of flight",
        by_body=False,
    ),
)
