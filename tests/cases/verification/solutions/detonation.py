"""Exact detonation of an explosive whose products follow Jones, Wilkins and Lee: Chapman's and Jouguet's state.

The front runs with D into matter at rest and without pressure. With V = rho0 / rho behind it, Rayleigh's line is p =
rho0 D^2 (1 - V), the Hugoniot E = E0 + p (1 - V) / 2, and at the slowest steady front the two touch: there D = u + c.
Behind it the plane wave that starts at a closed end is Taylor's: simple, self-similar in x / t, and at rest from the
end to x = c t with the sound of the matter there. Lee, Hornig and Kury (1968), UCRL-50422; Fickett and Davis (1979),
Detonation, chapter 2. No code is shared with the solver.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq


@dataclass(frozen=True)
class Explosive:
    """Constants of the explosive and its products."""

    density: float  # kg/m3
    A: float  # Pa
    B: float  # Pa
    R1: float
    R2: float
    omega: float
    E0: float  # J/m3
    velocity: float  # of the detonation, as stated with the constants, m/s


# TNT as in the decks of MPM3D-F90 (Deto1k.mpm, read in its repository): mm, g, ms, MPa there.
TNT = Explosive(1630.0, 3.712e11, 3.21e9, 4.15, 0.95, 0.3, 6.993e9, 6930.0)


@dataclass(frozen=True)
class Jouguet:
    """State behind the front."""

    volume: float  # V
    pressure: float  # Pa
    density: float  # kg/m3
    velocity: float  # of the matter, m/s
    front: float  # D, m/s
    sound_speed: float  # m/s


def cold(explosive: Explosive, volume: float) -> float:
    """p of the exponential terms on an isentrope, Pa."""
    return explosive.A * math.exp(-explosive.R1 * volume) + explosive.B * math.exp(-explosive.R2 * volume)


def stored(explosive: Explosive, volume: float) -> float:
    """E of the exponential terms, J/m3: dE = -p dV on an isentrope."""
    return explosive.A / explosive.R1 * math.exp(-explosive.R1 * volume) + explosive.B / explosive.R2 * math.exp(
        -explosive.R2 * volume
    )


def on_hugoniot(explosive: Explosive, volume: float) -> float:
    """Pressure at which p = p_s(V, E0 + p (1 - V) / 2), Pa; p_s = cold + omega / V (E - stored)."""
    share = explosive.omega / volume
    known = cold(explosive, volume) + share * (explosive.E0 - stored(explosive, volume))
    return known / (1.0 - 0.5 * share * (1.0 - volume))


def chapman_jouguet(explosive: Explosive) -> Jouguet:
    """The state at which Rayleigh's line touches the Hugoniot.

    Its velocity is that stated with the constants of TNT, 6930 m/s, to 0.1 %; and the flow behind is sonic:

    >>> state = chapman_jouguet(TNT)
    >>> [round(x, 2) for x in (state.pressure / 1e9, state.density, state.velocity, state.front)]
    [20.98, 2227.47, 1858.23, 6927.81]
    >>> round((state.velocity + state.sound_speed) / state.front, 9)
    1.0
    """

    def slope(volume: float) -> float:
        """Of the square of the front's speed with the volume, by its own difference quotient."""
        gap = 1e-6
        speeds = [on_hugoniot(explosive, v) / (1.0 - v) for v in (volume - gap, volume + gap)]
        return (speeds[1] - speeds[0]) / (2.0 * gap)

    volume = float(brentq(slope, 0.6, 0.9, xtol=1e-14))
    pressure = on_hugoniot(explosive, volume)
    front = math.sqrt(pressure / (explosive.density * (1.0 - volume)))
    energy = explosive.E0 + 0.5 * pressure * (1.0 - volume)
    isentrope = Isentrope(explosive, volume, energy)
    return Jouguet(
        volume=volume,
        pressure=pressure,
        density=explosive.density / volume,
        velocity=front * (1.0 - volume),
        front=front,
        sound_speed=isentrope.sound_speed(volume),
    )


@dataclass(frozen=True)
class Isentrope:
    """The isentrope of the products through a volume and an energy per initial volume (J/m3)."""

    explosive: Explosive
    volume: float
    energy: float

    @property
    def constant(self) -> float:
        """C of p = cold(V) + C V^-(omega + 1), Pa."""
        omega = self.explosive.omega
        thermal = self.energy - stored(self.explosive, self.volume)
        return omega * thermal * self.volume**omega

    def pressure(self, volume: float) -> float:
        """Pa."""
        return cold(self.explosive, volume) + self.constant * volume ** -(self.explosive.omega + 1.0)

    def energy_at(self, volume: float) -> float:
        """J/m3."""
        omega = self.explosive.omega
        return stored(self.explosive, volume) + self.constant / omega * volume**-omega

    def sound_speed(self, volume: float) -> float:
        """m/s: c^2 = -V^2 / rho0 dp / dV."""
        e = self.explosive
        slope = -e.R1 * e.A * math.exp(-e.R1 * volume) - e.R2 * e.B * math.exp(-e.R2 * volume)
        slope -= (e.omega + 1.0) * self.constant * volume ** -(e.omega + 2.0)
        return volume * math.sqrt(-slope / e.density)


STEPS = 4000  # number of volumes behind the front at which the Taylor wave is computed


@dataclass(frozen=True)
class TaylorWave:
    """The wave behind the front, from it to the matter at rest."""

    speed: np.ndarray  # (n,) x / t, m/s, falling
    velocity: np.ndarray  # (n,) m/s
    pressure: np.ndarray  # (n,) Pa
    density: np.ndarray  # (n,) kg/m3


def taylor_wave(explosive: Explosive) -> TaylorWave:
    """u(V) = u_CJ - integral of c / V dV from V_CJ, and x / t = u + c, until the matter rests; by the midpoint rule."""
    state = chapman_jouguet(explosive)
    energy = explosive.E0 + 0.5 * state.pressure * (1.0 - state.volume)
    isentrope = Isentrope(explosive, state.volume, energy)
    volumes = np.linspace(state.volume, 2.0, STEPS)
    middles = 0.5 * (volumes[1:] + volumes[:-1])
    drops = np.array([isentrope.sound_speed(float(v)) / v for v in middles]) * np.diff(volumes)
    velocity = state.velocity - np.concatenate([[0.0], np.cumsum(drops)])
    flowing = velocity > 0.0
    volumes, velocity = volumes[flowing], velocity[flowing]
    sound = np.array([isentrope.sound_speed(float(v)) for v in volumes])
    pressure = np.array([isentrope.pressure(float(v)) for v in volumes])
    return TaylorWave(velocity + sound, velocity, pressure, explosive.density / volumes)
