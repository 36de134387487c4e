"""A deck of MPM3D: the input file of the thesis' program or of MPM3D-F90 as a scenario.

The parameter ``deck`` is the text of the file, so that a run's identity is its content and no path; the problem is
built from it alone. Its materials, numerics and end are the deck's unless a parameter says otherwise, and what is
measured is what every problem has: energies, momentum, largest pressure, each with its history, and the film.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, Self

from solver.units import Described, Dimensionless, Second
from studies.decks.deck import Deck
from studies.decks.problem import bulk_modulus, fixed_step, matter_of, particles_per_cell, problem_of, signal_speed
from studies.decks.reader import MOST_BYTES, read_deck
from studies.quantities.findings import Doubt, Finding
from studies.quantities.numerical_defaults import RECIPES, RecipeName
from studies.quantities.parameters import Choice, LongText, Value
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, Setting, SetUp, Size
from studies.scenarios.parts.doubts import doubts_of_matter
from studies.scenarios.parts.numerics import BY_RECIPE, Numerics, filled_from, tensions

if TYPE_CHECKING:
    from solver.state import Snapshot
    from studies.decks.whole import WholeView

OBSERVATIONS = 20
MOST_OBSERVATIONS = 1000


@dataclass(frozen=True, kw_only=True)
class DeckNumerics(Numerics):
    """Numerics of a deck, where no parameter says otherwise."""

    recipe: Annotated[RecipeName, Described("preset for what neither the deck nor a parameter says")] = "thesis"
    contact: Annotated[
        Literal["deck", "none", "bardenhagen", "thesis", "gap"],
        Described("contact between components as the deck says, none, or on the nodes"),
    ] = "deck"  # type: ignore[assignment]
    friction: Annotated[
        Dimensionless | None, Described("Coulomb friction of components in contact; by default the deck's", 0.0, 10.0)
    ] = None
    particles_per_cell: Annotated[
        int | None,
        Described(
            "particles per cell along each direction, for the size of those of gimp; by default the deck's", 1, 6
        ),
    ] = None
    tension: Annotated[
        str | None, Choice(tensions), Described(f"rule for the lowest pressure that soil sustains; {BY_RECIPE}")
    ] = None

    def filled_for(self, deck: Deck, step: float | None) -> Self:
        """With the numerics of a deck, and a constant step (s)."""
        quadratic, linear = deck.viscosity
        preset = replace(
            RECIPES[self.recipe],
            shape=deck.shape,
            scheme=deck.scheme,
            particles_per_cell=particles_per_cell(deck),
            viscosity_quadratic=quadratic,
            viscosity_linear=linear,
        )
        contact = self.contact
        if contact == "deck":
            contact = "bardenhagen" if deck.contact else "none"
        friction = self.friction
        if friction is None:
            friction = deck.friction if contact != "none" else 0.0
        filled = replace(
            filled_from(self, preset),
            contact=contact,
            jaumann=self.jaumann and deck.jaumann,
            friction=friction,
            fixed_dt=self.fixed_dt if step is None else step,
        )
        has_soil = any(material.kind == "dpm" for material in deck.materials.values())
        unused = {"particles_per_cell": filled.shape != "gimp", "tension": not has_soil}
        return filled.acting(*(name for name, is_unused in unused.items() if is_unused))


@dataclass(frozen=True, kw_only=True)
class DeckRun(SetUp[Setting, "WholeView"]):
    """Parameters of a deck."""

    deck: Annotated[str, LongText(MOST_BYTES), Described("text of the input file, at most 2 MB of UTF-8")]
    units: Annotated[
        Literal["deck", "mm-g-ms", "SI"],
        Described("units of the deck: those that its comment names, by default mm, g and ms"),
    ] = "deck"
    end_time: Annotated[Second | None, Described("end of the run; by default the deck's", 1e-15, 1e6)] = None
    refinement: Annotated[
        int, Described("grid cells along the edge of a cell of the deck; particles are parted alike", 1, 32)
    ] = 1
    step: Annotated[
        Literal["deck", "stable"], Described("the deck's constant time step, or the stable one of the solver")
    ] = "deck"
    numerics: DeckNumerics

    @property
    def read(self) -> Deck:
        """What the reader understood; raises InvalidInput."""
        return read_deck(self.deck, self.units)

    @property
    def end(self) -> float:
        """End of the run, s."""
        return self.end_time or self.read.end_time

    def filled(self, materials: Materials) -> Self:
        deck, step = self.read, None
        if self.numerics.fixed_dt is None and self.step == "deck":
            step = round_quantity(fixed_step(deck) / self.refinement)
        numerics = self.numerics.filled_for(deck, step)
        return replace(self, units=deck.units, end_time=round_quantity(self.end), numerics=numerics)

    def check(self, materials: Materials) -> list[Finding]:
        numerics, findings = self.numerics, self.numerics.check(self.end_time)
        if self.step == "stable" and numerics.fixed_dt is not None:
            limit = "no fixed_dt with the stable step"
            cure = "leave fixed_dt out, or step"
            findings.append(Finding("fixed_dt", f"{numerics.fixed_dt:g} s", limit, cure))
        of: dict[int, set[int]] = {}
        for body in self.read.bodies:
            of.setdefault(body.component, set()).add(body.material)
        mixed = [component for component in sorted(of) if len(of[component]) > 1]
        if numerics.contact != "none" and mixed:
            limit = f"one material in each component, where bodies have contact: not in component {mixed[0]}"
            findings.append(Finding("contact", numerics.contact, limit, "set contact to none"))
        return findings

    @staticmethod
    def doubts(values: Mapping[str, Value]) -> Iterator[Doubt]:
        """What is doubtful about the metals of a deck; soils, fluids and explosives have other ranges."""
        deck = read_deck(str(values["deck"]), str(values.get("units") or "deck"))
        for number, material in deck.materials.items():
            if "young" not in material.values or material.kind == "dpm":
                continue
            for doubt in doubts_of_matter(matter_of(material, "unlimited"), bulk_modulus(material)):
                yield replace(doubt, name=f"material {number} of the deck: {doubt.name}")

    def build(self, materials: Materials) -> Setting:
        problem = problem_of(
            self.read,
            tension=self.numerics.choices.tension,
            contact=self.numerics.contact != "none",
            end_time=self.end,
            refinement=self.refinement,
        )
        return Setting(problem=self.numerics.applied_to(problem), sector=2.0 * math.pi)

    def size(self, materials: Materials) -> Size:
        deck, fine = self.read, self.refinement
        sound = max(signal_speed(material) for material in deck.materials.values()) or 1.0
        speeds = [math.hypot(*stated.velocity) for stated in deck.velocities]
        speed = max([*speeds, 1e-9 * sound]) + math.hypot(*deck.gravity) * self.end
        dt = self.numerics.mean_step(deck.cell / fine, sound=sound, speed=speed)
        return Size(particles=deck.particles * fine**3, steps=math.ceil(self.end / dt))

    def cells(self) -> dict[str, float]:
        return {"refinement": float(self.refinement)}

    @staticmethod
    def view(setting: Setting, snapshot: "Snapshot") -> "WholeView":
        from studies.decks.whole import view

        return view(snapshot)

    def rate(self, setting: Setting) -> ObservationRate:
        end = setting.problem.end_time
        asked = self.read.output_interval or end / OBSERVATIONS
        return ObservationRate(interval=min(max(asked, end / MOST_OBSERVATIONS), 0.5 * end))


SCENARIO = Scenario(
    name="deck",
    title="Deck of MPM3D",
    description="An input file of the thesis' MPM3D or of MPM3D-F90; energies, momentum and pressure are measured.",
    question="What does an input file of MPM3D give?",
    place=90,
    parameters=DeckRun,
    materials=(),
    measurements=("kinetic_energy", "internal_energy", "momentum_x", "momentum_y", "momentum_z", "largest_pressure"),
)
