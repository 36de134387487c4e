"""A material drawn from its models: its Hugoniot, and its flow stress against plastic strain, rate and temperature."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from studies.reports.drawing.canvas import as_svg, canvas, drawn_in_style, number
from studies.reports.drawing.styles import COLOURS
from studies.scenarios.parts.matter import eos_of, matter

if TYPE_CHECKING:
    from studies.materials import Material

# points
WIDTH, HEIGHT = 320.0, 235.0

FASTEST = 5e3  # particle speed of the Hugoniots, m/s: copper on copper at 10 km/s
DENSEST = 4.0  # of the densities that are looked at, over that at rest
STEPS = 4000
ROUNDS = 30  # of the energy behind a shock, where the pressure is not linear in it
STRAINS = np.linspace(0.0, 1.0, 101)
RATES = {1.0: "1 /s", 1e3: "10³ /s", 1e6: "10⁶ /s"}  # 1/s: a slow test, a split bar, an impact
WARM = (0.25, 0.5, 0.75)  # of the way from room temperature to the melting point
MIDDLE = 1e3  # 1/s


@dataclass(frozen=True)
class Hugoniot:
    """States behind plane shocks into matter at rest, in the order of their particle speeds."""

    particle_speed: np.ndarray  # m/s
    shock_speed: np.ndarray  # m/s
    pressure: np.ndarray  # Pa


def hugoniot(material: "Material") -> Hugoniot:
    """The Hugoniot of a material's equation of state, up to ``FASTEST``: e = p (V0 - V) / 2, and the jumps of
    Rankine and Hugoniot, up^2 = p (V0 - V), Us^2 = V0^2 p / (V0 - V) (Zel'dovich and Raizer 1966, chapter I).

    Copper at a particle speed of 3 km/s: 225.22 GPa:

    >>> from studies import materials
    >>> curve = hugoniot(materials.load("copper-ofhc"))
    >>> round(float(np.interp(3000.0, curve.particle_speed, curve.pressure)) / 1e9, 1)
    225.2
    """
    from solver.matter.eos import solve_pressure

    eos = eos_of(material)
    density = material.density * np.linspace(1.0, DENSEST, STEPS)[1:]
    lost = 1.0 / material.density - 1.0 / density  # of the volume, m3/kg
    pressure = np.zeros_like(density)
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            pressure = solve_pressure(eos, density, 0.0, -lost, 0.5 * pressure * lost, -math.inf)
        speed, shock = np.sqrt(pressure * lost), np.sqrt(pressure / lost) / material.density
    beyond = ~(np.diff(speed, prepend=0.0) > 0.0) | (speed > FASTEST)
    end = int(np.argmax(beyond)) if beyond.any() else len(speed)
    return Hugoniot(speed[:end], shock[:end], pressure[:end])


def flow_stress(material: "Material", rate: float, warmth: float) -> np.ndarray:
    """Yield stress (Pa) at ``STRAINS``, at a strain rate (1/s) and so far on the way to the melting point (0 to 1)."""
    from solver.matter.strength import stiffness, yield_stress

    given = matter(material)
    kelvin = given.room_temperature + (warmth * (given.melt_temperature - given.room_temperature) if warmth else 0.0)
    stiff = stiffness(given.strength, 1.0, 0.0, kelvin)
    stress = yield_stress(given.strength, STRAINS, rate, warmth, stiff)
    return np.broadcast_to(np.asarray(stress, dtype=float), STRAINS.shape)


def drawings(material: "Material") -> Iterator[tuple[str, Markup]]:
    """The pictures of a material, each with its title."""
    with drawn_in_style():
        curve = hugoniot(material)
        speed = curve.particle_speed / 1e3
        yield _drawn("Shock pressure", "GPa", "particle speed (km/s)", [("", speed, curve.pressure / 1e9)], material)
        yield _drawn("Shock speed", "km/s", "particle speed (km/s)", [("", speed, curve.shock_speed / 1e3)], material)
        for title, lines in _flow_lines(material):
            if all(np.isfinite(stress).all() for _, _, stress in lines):
                yield _drawn(title, "MPa", "plastic strain", lines, material)


def _flow_lines(material: "Material") -> Iterator[tuple[str, list[tuple[str, np.ndarray, np.ndarray]]]]:
    room, melt = material.thermal.room_temperature, material.thermal.melt_temperature
    by_rate = [(label, STRAINS, flow_stress(material, rate, 0.0) / 1e6) for rate, label in RATES.items()]
    yield f"Flow stress at {room:.0f} K, by strain rate", by_rate
    if melt is not None:
        by_heat = [
            (f"{room + share * (melt - room):.0f} K", STRAINS, flow_stress(material, MIDDLE, share) / 1e6)
            for share in (0.0, *WARM)
        ]
        yield f"Flow stress at {RATES[MIDDLE]}, by temperature", by_heat


def _drawn(
    title: str, unit: str, across: str, lines: Sequence[tuple[str, np.ndarray, np.ndarray]], material: "Material"
) -> tuple[str, Markup]:
    """Lines with their labels, as a picture with its title; lines that are one are drawn once."""
    drawing = canvas(WIDTH, HEIGHT)
    drawing.set_layout_engine("constrained")
    axes = drawing.add_subplot()
    groups: list[tuple[list[str], np.ndarray, np.ndarray]] = []
    for label, x, y in lines:
        same = next((names for names, _, other in groups if np.array_equal(other, y)), None)
        same.append(label) if same else groups.append(([label], x, y))
    for (names, x, y), colour in zip(groups, COLOURS, strict=False):
        axes.plot(x, y, color=colour, linewidth=1.5, label=", ".join(names))
    axes.set(xlabel=across, ylabel=unit, ylim=(0.0, None), xlim=(0.0, None))
    axes.xaxis.set_major_formatter(number)
    axes.yaxis.set_major_formatter(number)
    if len(lines) > 1:
        axes.legend()
    return title, as_svg(drawing, "full", f"{title} of {material.title}, {unit}, against {across}", title)
