"""The sections of a run: its particles in the plane through the axis at a few times, in few bytes, for pictures.

``sections.npz`` holds ``spacing`` (bodies, 2) of the particles across and along the line of flight (m), ``bodies``,
their names, ``mirrored``: whether the other side of the axis is the mirror image, ``moments``, the times (s) for which
states before the end were asked, and for each state, by its number::

    time_0 (s)   moment_0 (index in moments, -1: the end)   position_0 (2, n)   box_0 (2, 2)   body_0 (n,)   FIELDS (n,)

``radiograph`` (rows, columns), ``radiograph_origin`` (m) and ``radiograph_pixel`` (m) are those of the end
(``radiograph.Radiograph``), where a scenario asks for them.

Positions fill their box (lowest and highest, m) with 16 bits, and are differences between neighbours of the initial
lattice, which compress well; fields are half precision in the units of FIELDS. A finer lattice than a picture shows is
thinned, evenly. Elements are shown by points inside their faces in the plane, as far apart as particles of their body.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import ArrayLike

from solver.grid.debris import flown_on_grid
from solver.problem import Body, Face, Problem
from solver.problem.geometry import impact_axis
from solver.state import Snapshot, X, Z
from studies.quantities.files import write_atomically
from studies.sections.radiograph import AREAL_DENSITY, Radiograph, radiograph

# Particles of a section at most: as many as a picture has pixels.
MOST = 200_000
END = -1  # in place of a moment
STEPS = 65535  # of a position in its box
HALF = 65504.0  # the largest number of half precision
# Of the last section of a running run: s after the begin, s between two, and the largest share of the time of the run.
FIRST, AGAIN, SHARE = 5.0, 15.0, 0.01

# Unit of each stored field in SI: half precision ends at 65504, and has a part in two thousand.
FIELDS: Mapping[str, float] = {
    "plastic_strain": 1.0,
    "temperature": 1.0,  # K
    "pressure": 1e9,  # GPa
    "density": 1.0,  # kg/m3
    "speed": 1.0,  # m/s
}
# SI units of what pictures and views show.
UNITS: Mapping[str, str] = {
    **{"plastic_strain": "1", "temperature": "K", "pressure": "Pa", "density": "kg m-3", "speed": "m s-1"},
    **{"damage": "1", AREAL_DENSITY: "kg m-2"},
}


@dataclass(frozen=True)
class SectionOptions:
    """Times and part of a run of which sections are kept; the end is always one of them."""

    moments: tuple[float, ...] = ()  # s
    reach: float = math.inf  # from the origin, of the initial places of the particles, m
    pixel: float | None = None  # of a radiograph at the end, m; None: there is none
    whole: float = 1.0  # whole bodies over the model of a sector


@dataclass(frozen=True)
class Section:
    """The particles in the plane through the axis at one time; SI, single precision."""

    time: float  # s
    moment: int  # index in the moments that were asked for, END at the end
    position: np.ndarray  # (n, 2) across and along the line of flight, m
    body: np.ndarray  # (n,) index
    fields: Mapping[str, np.ndarray]  # (n,) by the names of FIELDS


@dataclass(frozen=True)
class Sections:
    """The stored sections of a run."""

    bodies: tuple[str, ...]
    spacing: np.ndarray  # (bodies, 2) of the particles across and along, initially, m
    mirrored: bool  # whether the other side of the axis is the mirror image
    moments: tuple[float, ...]  # s
    states: tuple[Section, ...]
    radiograph: Radiograph | None = None  # at the end

    def at(self, moment: int) -> Section | None:
        """The section of a moment, or of END; None where it was not kept."""
        return next((state for state in self.states if state.moment == moment), None)


class SectionRecorder:
    """Takes the sections of a run on the way."""

    def __init__(self, problem: Problem, options: SectionOptions, interval: float, most: int = MOST):
        self.problem = problem
        self.options = options
        self.interval = interval  # between two observations, s
        axis = impact_axis(problem.geometry)
        self.axes = [0, axis]
        self.is_flat = axis == 1
        self.states: list[Section] = []
        self.radiograph: Radiograph | None = None
        self.is_saved = True
        self._widths = np.array([body.spacing[1] for body in problem.bodies])
        # By the permanent numbers of the particles.
        self._kept, self._stride = self._chosen(most)
        self._fillings = [
            (index, _filling(body, self.axes, options.reach)) for index, body in enumerate(problem.bodies) if body.mesh
        ]

    def add(self, snapshot: Snapshot) -> None:
        """Take the section of each moment to which no other observation will be nearer."""
        taken = {state.moment for state in self.states}
        for index, moment in enumerate(self.options.moments):
            if index not in taken and 0.0 <= snapshot.time - moment + 0.5 * self.interval < self.interval:
                self.states.append(self._section(snapshot, index))
                self.is_saved = False

    def end(self, snapshot: Snapshot) -> None:
        """Take the last section."""
        self.states = [state for state in self.states if state.moment != END]
        self.states.append(self._section(snapshot, END))
        if self.options.pixel:
            self.radiograph = radiograph(self.problem, snapshot, pixel=self.options.pixel, whole=self.options.whole)

    @property
    def spacing(self) -> np.ndarray:
        """Spacing (bodies, 2) of the shown particles across and along, initially, m."""
        bodies = self.problem.bodies
        widths = np.array([[body.spacing[axis] for axis in self.axes] for body in bodies])
        return widths * self._stride

    def save(self, path: Path) -> None:
        """Write the sections so far: whole, or not at all."""
        self.is_saved = True
        self._write(path, self.states)

    def save_now(self, snapshot: Snapshot, path: Path) -> None:
        """Write the section of a state alone, as if it were the end."""
        self._write(path, [self._section(snapshot, END)])

    def _write(self, path: Path, states: Sequence[Section]) -> None:
        bodies = self.problem.bodies
        arrays: dict[str, ArrayLike] = {
            "bodies": [body.name for body in bodies],
            "spacing": self.spacing,
            "mirrored": self.problem.faces[0][0] == Face.SYMMETRIC,
            "moments": np.array(self.options.moments),
        }
        if self.radiograph:
            arrays |= {
                "radiograph": self.radiograph.density.astype(np.float32),
                "radiograph_origin": self.radiograph.origin,
                "radiograph_pixel": self.radiograph.pixel,
            }
        for number, state in enumerate(states):
            arrays |= {f"{name}_{number}": value for name, value in _packed(state).items()}

        def fill(part: Path) -> None:
            with open(part, "wb") as file:
                np.savez_compressed(file, **arrays)  # type: ignore[arg-type]

        write_atomically(path, fill)

    def resume(self, path: Path) -> None:
        """Continue after the sections of a saved file; those that are lost stay away."""
        try:
            self.states = list(read_sections(path).states)
        except (OSError, EOFError, KeyError, ValueError, BadZipFile):
            self.states = []

    def _chosen(self, most: int) -> tuple[np.ndarray, int]:
        """Which particles (all of them,) may be shown, by their initial places; every how many of a row are."""
        near, in_plane, place = [], [], []
        for body in self.problem.bodies:
            section = body.position[:, self.axes]
            mine = (section**2).sum(axis=1) < self.options.reach**2
            near.append(mine if body.mesh is None else np.zeros_like(mine))
            in_plane.append(self._in_plane(body.position, body.spacing[1]))
            width = np.array([body.spacing[axis] for axis in self.axes])
            place.append(np.floor(section / width + 1e-6).astype(np.int64))
        arrivals = self.problem.arrivals
        if arrivals is not None:  # of no lattice any more: as many of them
            order = np.arange(arrivals.time.size)
            near.append(np.ones(order.size, bool))
            in_plane.append(self._in_plane(arrivals.table[X : Z + 1].T, self._widths[arrivals.body]))
            place.append(np.stack([order, np.zeros_like(order)], axis=-1))
        count = sum(int((a & b).sum()) for a, b in zip(near, in_plane, strict=True))
        stride = max(1, math.ceil(math.sqrt(count / most)))
        return np.concatenate(near) & (np.concatenate(place) % stride == 0).all(axis=1), stride

    def _in_plane(self, position: np.ndarray, width: float | np.ndarray) -> np.ndarray:
        """Which particles are in the layer of the lattice beside the plane; all in axisymmetry."""
        if self.is_flat:
            return np.ones(len(position), bool)
        layer: np.ndarray = position[:, 1] < width
        return layer

    def _section(self, snapshot: Snapshot, moment: int) -> Section:
        particles, departed = snapshot.particles, snapshot.departed
        shown = (particles.alive == 1) & self._kept[particles.number]
        shown &= self._in_plane(particles.position, self._widths[snapshot.body])
        out = flown_on_grid(self.problem, departed, snapshot.time)
        late = np.isfinite(out[:, 0]) & self._kept[departed.number]
        late &= self._in_plane(out, self._widths[departed.body])
        nothing = np.full(int(late.sum()), np.nan)
        fields = {
            "plastic_strain": (particles.plastic_strain, departed.plastic_strain[late]),
            "temperature": (particles.temperature, departed.temperature[late]),
            "pressure": (particles.pressure, nothing),
            "density": (particles.density, nothing),
            "speed": (np.linalg.norm(particles.velocity, axis=1), np.linalg.norm(departed.velocity[late], axis=1)),
        }
        order = np.argsort(np.concatenate([particles.number[shown], departed.number[late]]))
        inside = [
            (index, np.searchsorted(snapshot.body, index) + nodes, weights)
            for index, (nodes, weights) in self._fillings
        ]

        def joined(on_grid: np.ndarray, away: np.ndarray, filling: Callable[..., np.ndarray]) -> np.ndarray:
            """What particles on the grid and away from it have, in the order of their numbers, and points inside."""
            own = np.concatenate([on_grid[shown], away])[order]
            return np.concatenate([own, *(filling(*each) for each in inside)])

        return Section(
            time=snapshot.time,
            moment=moment,
            position=joined(
                particles.position[:, self.axes],
                out[late][:, self.axes],
                lambda _, nodes, weights: np.einsum("pn,pnx->px", weights, particles.position[nodes][..., self.axes]),
            ),
            body=joined(snapshot.body, departed.body[late], lambda index, nodes, _: np.full(len(nodes), index)),
            fields={
                name: joined(values, more, lambda _, nodes, weights, of=values: (weights * of[nodes]).sum(axis=1))
                for name, (values, more) in fields.items()
            },
        )


class Watched:
    """Keeps the last section of a running run for its page; what that took decides when the next one is due."""

    def __init__(self, file: Path, clock: Callable[[], float] = time.perf_counter):
        self._file, self._clock = file, clock
        self._due = clock() + FIRST
        self.spent = 0.0  # s

    def see(self, sections: SectionRecorder, snapshot: Snapshot) -> None:
        """Keep the section of a state if it is due; without effect where there is no space."""
        begin = self._clock()
        if begin < self._due:
            return
        with suppress(OSError):
            sections.save_now(snapshot, self._file)
        took = self._clock() - begin
        self.spent += took
        self._due = begin + took + max(AGAIN, took / SHARE)


def read_sections(path: Path) -> Sections:
    """The sections in a file; raises numpy's errors (OSError, ValueError, KeyError, BadZipFile) for anything else."""
    with np.load(path, allow_pickle=False) as saved:
        count, taken = sum(name.startswith("time_") for name in saved.files), None
        if "radiograph" in saved:
            origin, pixel = float(saved["radiograph_origin"]), float(saved["radiograph_pixel"])
            taken = Radiograph(saved["radiograph"], origin, pixel)
        return Sections(
            bodies=tuple(saved["bodies"].tolist()),
            spacing=saved["spacing"],
            mirrored=bool(saved["mirrored"]),
            moments=tuple(saved["moments"].tolist()),
            states=tuple(_unpacked(saved, number) for number in range(count)),
            radiograph=taken,
        )


def _filling(body: Body, axes: list[int], reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (p,) inside the faces of a body's elements in the plane: nodes (p, 4) and their weights (p, 4).

    The nodes of a mesh keep their order. A face of a body of revolution is the element itself.
    """
    assert body.mesh is not None
    faces = body.mesh.nodes
    if axes[1] == 2:
        in_plane = body.position[:, 1] < 0.5 * body.spacing[1]
        faces = faces[in_plane[faces].sum(axis=1) == 4]
        faces = faces[in_plane[faces]].reshape(-1, 4)
    place = body.position[:, axes]
    nodes, weights = [np.zeros((0, 4), np.int64)], [np.zeros((0, 4))]
    for face in faces:
        corners = place[face]
        if (corners**2).sum(axis=1).min() >= reach**2:
            continue
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        at_upper = (corners > low + 0.5 * size).astype(float)  # (4, 2)
        counts = [max(1, round(length / body.spacing[axis])) for length, axis in zip(size, axes, strict=True)]
        local = np.stack(
            np.meshgrid(*((np.arange(count) + 0.5) / count for count in counts), indexing="ij"), axis=-1
        ).reshape(-1, 1, 2)
        weights.append(np.prod(at_upper * local + (1.0 - at_upper) * (1.0 - local), axis=-1))
        nodes.append(np.repeat(face[None], len(local), axis=0))
    return np.concatenate(nodes), np.concatenate(weights)


def _packed(state: Section) -> dict[str, ArrayLike]:
    """The arrays of a section in a file."""
    low = high = np.zeros(2)
    if len(state.position):
        low, high = state.position.min(axis=0), state.position.max(axis=0)
    steps = np.rint((state.position - low) / np.maximum(high - low, 1e-300) * STEPS)
    # A difference below zero wraps around, and so does its sum.
    differences = np.diff(steps.astype(np.uint16), axis=0, prepend=np.zeros((1, 2), np.uint16))
    fields = {name: np.clip(state.fields[name] / unit, -HALF, HALF).astype(np.float16) for name, unit in FIELDS.items()}
    return {
        "time": state.time,
        "moment": state.moment,
        "box": np.stack([low, high]),
        "position": np.ascontiguousarray(differences.T),
        "body": state.body.astype(np.uint8),
        **fields,
    }


def _unpacked(saved: "np.lib.npyio.NpzFile", number: int) -> Section:
    low, high = saved[f"box_{number}"]
    steps = np.cumsum(saved[f"position_{number}"].T, axis=0, dtype=np.uint16)
    return Section(
        time=float(saved[f"time_{number}"]),
        moment=int(saved[f"moment_{number}"]),
        position=(low + steps * ((high - low) / STEPS)).astype(np.float32),
        body=saved[f"body_{number}"],
        fields={name: saved[f"{name}_{number}"].astype(np.float32) * np.float32(unit) for name, unit in FIELDS.items()},
    )
