"""Samples of bars for the tests that all measurements and scenarios share, and their states."""

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from studies.bars.measured import BarView, rear_face_place, rebound_momentum
from studies.measurements import History
from tests.samples import ANY, CELLS, DIAMETER
from tests.studies.measurements.states import CELL, DENSITY, PARTICLE, ROUND_OFF, TENTH, lattice, line, without

BAR_LENGTH, BAR_DIAMETER, BAR_SPEED = 20e-3, 8e-3, 100.0
Shape = Callable[[np.ndarray], np.ndarray]


def straight(points: np.ndarray) -> np.ndarray:
    return points


def stretched(points: np.ndarray) -> np.ndarray:
    """Shorter by a third, thicker by a fifth, a tenth of a cell above the wall."""
    return points * (1.2, 1.2, 2.0 / 3.0) + (0.0, 0.0, 0.1 * CELL)


def flared(points: np.ndarray) -> np.ndarray:
    """Wider by half at the wall, as it was at the rear, straight in between."""
    widening = 1.0 + 0.5 * (1.0 - points[:, 2:] / BAR_LENGTH)
    return points * np.concatenate([widening, widening, np.ones_like(widening)], axis=1)


def bar(
    shape: Shape = straight,
    *,
    round_model: bool = False,
    velocity: tuple[float, float, float] = (0.0, 0.0, -BAR_SPEED),
    **changes: Any,
) -> BarView:
    """A round bar, deformed; a quarter in three dimensions, or a body of revolution."""
    across, along = line(0.0, 0.5 * BAR_DIAMETER), line(0.0, BAR_LENGTH)
    lines = (across, np.zeros(1) if round_model else across, along)
    places = [np.arange(axis.size) for axis in lines]
    place, points = (np.stack(lattice(*each), axis=-1) for each in (places, lines))
    inside = np.hypot(points[:, 0], points[:, 1]) < 0.5 * BAR_DIAMETER
    points, place = points[inside], place[inside]
    mass = DENSITY * (points[:, 0] * PARTICLE**2 if round_model else np.full(len(points), PARTICLE**3))
    return BarView(
        **{
            "place": place,
            "position": shape(points),
            "velocity": np.tile(velocity, (len(points), 1)),
            "mass": mass,
            "strain_energy": np.zeros(len(points)),
            "stress": np.zeros(len(points)),
            "height": points[:, 2],
            "width": PARTICLE,
            "cell": CELL,
            "length": BAR_LENGTH,
            "speed": BAR_SPEED,
            "is_loaded": False,
            "references": (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER),
            **changes,
        }
    )


def short_bar() -> BarView:
    """What is left of a bar that lost the rows on which its edges are read."""
    whole = bar()
    return without(whole, whole.place[:, 0] == whole.place[:, 0].max())


def pushed(rates: np.ndarray, interval: float = 1e-8) -> History:
    """A bar that is pushed at some rates (shares of its momentum per second), one in each interval."""
    times = interval * np.arange(rates.size + 1)
    momentum = -1.0 + np.concatenate([[0.0], np.cumsum(rates * interval)])
    return History(times, {rebound_momentum.name: momentum})


def rectangle(contact: float, end: float = 2e-6, interval: float = 1e-8) -> np.ndarray:
    """A constant push that turns the momentum round within a contact time, and then none."""
    times = interval * np.arange(round(end / interval) + 1)
    return np.diff(np.clip(times / contact, 0.0, 1.0)) * 2.0 / interval


def smeared(rates: np.ndarray) -> np.ndarray:
    """The same push from the first touch on, its end smeared evenly over 20 intervals."""
    return np.convolve(np.pad(rates, 10, mode="edge"), np.full(21, 1.0 / 21.0), mode="valid")


def rear_faces(*place: float) -> History:
    return History(np.arange(len(place)) * 1e-6, {rear_face_place.name: np.array(place)})


def split_bar() -> Any:
    """A bar whose halves part at the impact speed."""
    state = bar()
    state.velocity[state.place[:, 2] >= state.place[:, 2].max() / 2.0, 2] *= -1.0
    return state


def strained_bar() -> Any:
    """A bar that flies off at half of its speed and holds a fifth of its energy as strain."""
    state = bar(velocity=(0.0, 0.0, 0.5 * BAR_SPEED))
    state.strain_energy[:] = 0.1 * BAR_SPEED**2
    return state


def waving_bar() -> Any:
    """Velocity and stress rise along the initial height, and across."""
    state = bar(stretched)
    heights = state.height + (state.place[:, :2] > 0).any(axis=1)
    velocity = np.stack([0.0 * heights, 0.0 * heights, heights], axis=1)
    return dataclasses.replace(state, velocity=velocity, stress=-2e9 * heights)


def middles(last: float = 3.0) -> History:
    values = np.array([0.0, 2.0, -5.0, last])
    return History(1e-6 * np.arange(values.size), {"middle_velocity": values, "middle_stress": values})


def pulled() -> History:
    rates = rectangle(1.2e-6)
    rates[150:152] = -0.03 * rates.max()
    return pushed(rates)


def noisy() -> History:
    rates = rectangle(1.2e-6)
    return pushed(rates * np.where(np.arange(rates.size) % 2, 1.9, 0.1))


def thesis_bar() -> Any:
    """Ma (2005), Table 2.2, finite elements: 16.3, 13.4 and 10.0 mm against 16.2, 13.5 and 10.1 mm."""
    ratios = (16.2 / 16.3, 13.5 / 13.4, 10.1 / 10.0)
    sizes = (BAR_LENGTH, BAR_DIAMETER, BAR_DIAMETER)
    return bar(references=tuple(s * r for s, r in zip(sizes, ratios, strict=True)))


def bars(shape: Callable[[np.ndarray], np.ndarray]) -> list[Callable[[], Any]]:
    return [partial(bar, shape, round_model=flat) for flat in (False, True)]


def bar_without_corner() -> Any:
    whole = bar()
    last = whole.place[:, 2] == whole.place[:, 2].max()
    return without(whole, (whole.place[:, 1] == 0) & last)


def followed() -> dict[str, np.ndarray]:
    """What measurements of bars follow, of a bar that rebounds."""
    rise = 4e-3 * np.sin(np.linspace(0.0, 0.75 * math.pi, 201))
    own = {rear_face_place.name: BAR_LENGTH - rise, "middle_velocity": -1e5 * rise, "middle_stress": -1e12 * rise}
    return own | dict(pushed(rectangle(1.2e-6)).values)


FOLLOWED = followed

LAST_LAYER = BAR_LENGTH - 0.5 * PARTICLE
OF_THE_WALL_ALONE = ("rigid_energy", "vibration_energy", "strain_energy", "lost_energy", "rebound_momentum")
REFERENCES = (0.9 * BAR_LENGTH, 1.25 * BAR_DIAMETER, 0.8 * BAR_DIAMETER)
STATES: dict[type, dict[str, Callable[[], Any]]] = {
    BarView: {
        "straight": bar,
        "stretched": lambda: bar(stretched),
        "flared": lambda: bar(flared),
        "round": lambda: bar(flared, round_model=True),
        "short of rows": short_bar,
        "without references": lambda: bar(references=(None, None, None)),
        "loaded": lambda: bar(is_loaded=True),
    }
}
KNOWN: list[tuple[str, Callable[[], Any], float, float]] = [
    # A bar has exactly the length and diameter to which it was stretched, a flared one that of the cone. Its lowest
    # layer stands half a particle above its foot.
    *(("final_length", state, BAR_LENGTH, 1e-14) for state in (*bars(straight), *bars(flared))),
    *(("final_length", state, 2.0 / 3.0 * BAR_LENGTH, 1e-14) for state in bars(stretched)),
    *(("mushroom_diameter", state, 1.2 * BAR_DIAMETER, 1e-14) for state in bars(stretched)),
    *(
        ("mushroom_diameter", state, (1.5 - 0.25 * PARTICLE / BAR_LENGTH) * BAR_DIAMETER, 1e-14)
        for state in bars(flared)
    ),
    *(("width_at_fifth", state, 1.4 * BAR_DIAMETER, 1e-14) for state in bars(flared)),
    ("taylor_error", lambda: bar(references=REFERENCES), (0.1 / 0.9 + 0.2 + 0.25) / 3.0, 1e-9),
    ("taylor_error", thesis_bar, 0.008, 0.0005),
    ("rigid_energy", bar, 1.0, ROUND_OFF),
    ("vibration_energy", bar, 0.0, ROUND_OFF),
    ("strain_energy", bar, 0.0, 0.0),
    ("lost_energy", bar, 0.0, ROUND_OFF),
    ("rebound_momentum", bar, -1.0, ROUND_OFF),
    ("rigid_energy", split_bar, 0.0, ROUND_OFF),
    ("vibration_energy", split_bar, 1.0, ROUND_OFF),
    ("rigid_energy", lambda: bar(velocity=(30.0, 40.0, 0.0)), 0.0, 0.0),
    ("vibration_energy", lambda: bar(velocity=(30.0, 40.0, 0.0)), 0.25, ROUND_OFF),
    ("strain_energy", strained_bar, 0.2, ROUND_OFF),
    ("lost_energy", strained_bar, 1.0 - 0.25 - 0.2, 1e-9),
    ("rebound_momentum", strained_bar, 0.5, ROUND_OFF),
    *(("rear_face_place", state, LAST_LAYER, 1e-14) for state in bars(straight)),
    *(("rear_face_place", state, 2.0 / 3.0 * LAST_LAYER + TENTH, 1e-14) for state in bars(stretched)),
    ("rear_face_velocity", lambda: rear_faces(0.02, 0.020, 0.0195), -500.0, 1e-8),
    # Linear along the bar, and other values away from the axis.
    ("middle_velocity", waving_bar, 0.5 * BAR_LENGTH, 1e-14),
    ("middle_stress", waving_bar, -1e9 * BAR_LENGTH, 1e-5),
    *((f"middle_peak_{name}", middles, -5.0, 0.0) for name in ("velocity", "stress")),
    # Half of the time between observations.
    *(("contact_time", lambda t=t: pushed(rectangle(t)), t, 0.5e-8) for t in (0.5e-6, 1.234e-6)),
    ("contact_time", lambda: pushed(smeared(rectangle(1.2e-6))), 1.2e-6, 1e-8),
    ("contact_time", noisy, 1.2e-6, 2e-8),
    ("wall_pull", pulled, 0.03, 1e-7),
    ("wall_pull", lambda: pushed(rectangle(1.2e-6)), 0.0, 1e-9),
]
NO_VALUE: list[tuple[str, Callable[[], Any], str]] = [
    ("width_at_fifth", lambda: bar(lambda points: points * (1.0, 1.0, 0.15)), "too_short"),
    ("final_length", bar_without_corner, "lost_particles"),
    ("mushroom_diameter", bar_without_corner, "lost_particles"),
    ("width_at_fifth", bar_without_corner, "lost_particles"),
    ("taylor_error", lambda: bar(references=(BAR_LENGTH, None, BAR_DIAMETER)), "no_reference"),
    ("rear_face_place", bar_without_corner, "lost_particles"),
    ("rear_face_velocity", lambda: rear_faces(0.02, math.nan), "lost_particles"),
    ("rear_face_velocity", lambda: rear_faces(0.02), "one_observation"),
    *((f"middle_{name}", bar_without_corner, "lost_particles") for name in ("velocity", "stress")),
    *((f"middle_peak_{name}", lambda: middles(math.nan), "lost_particles") for name in ("velocity", "stress")),
    *((name, lambda: bar(is_loaded=True), "loaded") for name in OF_THE_WALL_ALONE),
    *((name, lambda: pushed(np.full(9, math.nan)), "loaded") for name in ("contact_time", "wall_pull")),
    ("wall_pull", lambda: pushed(np.zeros(200)), "not_touched"),
    ("contact_time", lambda: pushed(np.zeros(200)), "in_contact"),
    ("contact_time", lambda: pushed(rectangle(1.2e-6, 0.6e-6)), "in_contact"),
    ("contact_time", lambda: pushed(rectangle(1.2e-6, 1.1e-6)), "in_contact"),
]

SMALL: dict[str, dict[str, Any]] = {
    "taylor_bar": {"bar_length": 10e-3, "bar_diameter": DIAMETER, "cells_per_diameter": CELLS},
    "elastic_bar": {"cells_per_diameter": CELLS},
}
SQUARE: dict[str, Any] = {"section": "square", "geometry": "quarter"}
PULLED: dict[str, Any] = {"speed": 0.0, "bar_length": 20e-3, "pressure": -1e8, "pulse": "0 us 1, 1 us 0", **SQUARE}
QUARTERS: tuple[dict[str, Any], ...] = (  # of a bar
    {"geometry": "quarter"},
    {"wall": "symmetric", "geometry": "quarter"},
    {"cells_per_diameter": 2.0, "particles_per_cell": 1, "geometry": "quarter"},
    SQUARE,
    PULLED,
)

BARS = ("elastic_bar", "taylor_bar")
VARIED = [
    (BARS, ANY),
    (
        BARS,
        (
            {"wall": "symmetric"},
            {"cells_per_diameter": 2.0},
            {"cells_per_diameter": 32.0},
            {"bar_length": 100e-3, "bar_diameter": 2e-3},
            {"speed": 0.0, "gravity": -9.81},
            {"speed": 1.0},
        ),
    ),
    (("elastic_bar",), ({"poisson_ratio": 0.0}, {"poisson_ratio": 0.49}, *QUARTERS)),
    (("taylor_bar",), ({"bar": "al-2024-t3"}, {"thermal_softening": False, "bar": "copper-ofhc"})),
]
COMPILED_ALONE: tuple[tuple[str, dict[str, Any]], ...] = (
    *(("taylor_bar", changes) for changes in QUARTERS),
    ("taylor_bar", {"geometry": "quarter", "recipe": "thesis"}),
)
# Bars are those of meshes.
SMOOTHED = {"elastic_bar": {"section": "square", "wall": "symmetric"}}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "Taylor bar": ("taylor_bar", {"reference_length": 8e-3, "reference_diameter": 10e-3, "reference_width": 9e-3}),
    "Taylor bar, quarter": ("taylor_bar", {"geometry": "quarter"}),
    "elastic bar": ("elastic_bar", {}),
}
LONG = {"Taylor bar, quarter"}
SOLVED = {
    "taylor_bar": {
        "bar_length": 25.4e-3,
        "bar_diameter": 7.6e-3,
        "end_time": 20e-6,
        "reference_length": 16.2e-3,
        "speed": 400.0,
    },
    "elastic_bar": {},
}

PULSE = "0 us 0, 0.5 us 1, 10 us 1, 10.5 us 0"


def refused(name: str, reason: str, **changes: Any) -> tuple[str, dict[str, Any], str, str]:
    return "elastic_bar", changes, name, reason


def pulse(reason: str, text: str) -> tuple[str, dict[str, Any], str, str]:
    return refused("pulse", reason, pressure=1e8, pulse=text)


REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    refused("pulse", "give pressure", pulse=PULSE),
    pulse("at least two rows", "1 us 1"),
    pulse("a time with its unit", "0 us, 1 us 1"),
    pulse("from -1 to 1", "0 us 0, 1 us 2"),
    pulse("from 0 s", "-1 us 0, 1 us 1"),
    pulse("after 1 us", "0 us 0, 1 us 1, 1 us 0"),
    pulse("before the end of the run", "1 s 0, 2 s 1"),
    refused("pressure", "at most", pressure=1e12),
    refused("gravity", "at most", gravity=1e12),
    refused("speed", "without loads", speed=0.0),
    refused("bar_length", "8 cells", pressure=1e8, bar_length=7e-3),
    refused("bar_length", "at least a cell", bar_length=0.5e-3),
    refused("section", "set geometry to quarter", section="square"),
    refused("contact", "set contact to none", method="sph", geometry="quarter", wall="symmetric", contact="gap"),
    ("taylor_bar", {"bar": "copper-ofhc-tillotson", "thermal_softening": False}, "thermal_softening", "would boil"),
    ("taylor_bar", {"friction": 0.1}, "friction", "set contact to bardenhagen"),
    refused("speed", "holds only far below this limit", young_modulus=1e7),
]
