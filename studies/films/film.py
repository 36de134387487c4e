"""The film of a run: places of its particles and what they feel over time, in a bounded file.

``film.npz`` holds, in SI and single precision, particle by particle in the order of ``number`` (permanent)::

    time (f,)   position (f, n, 3)   SCALARS (f, n)   number, body (n,)   bodies, stride, whole

``body`` is the place of a particle's body in ``bodies``, their names. A particle that has left the grid is NaN from
then on; one that was retired flies straight until then, without pressure, at the temperature that it had. A large run
shows every ``stride``-th particle. Frames have an interval of their own, at which a run need not be observed. A run
that went on from a checkpoint shows the frames of before too; ``whole`` is false where they were lost, and the film
begins with the frame at ``time[0]``.
"""

import math
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from solver.grid.debris import flown_on_grid
from solver.problem import Problem
from solver.state import Snapshot
from studies.quantities.files import MOST_FRAMES, write_atomically

FRAMES = 48  # evenly in time, where no interval is stated; the first and the last state come on top
BYTES = 32 << 20  # of all frames; the file is smaller, it is compressed
SCALARS = ("speed", "pressure", "temperature", "plastic_strain", "damage")
VALUES = 3 + len(SCALARS)  # of a particle in a frame; three of position
BYTES_PER_VALUE = np.dtype(np.float32).itemsize


class Film:
    """The frames of a run so far."""

    def __init__(self, problem: Problem, most_bytes: int = BYTES, interval: float | None = None):
        """``interval`` (s) is the time between two frames, at least a thousandth of the run."""
        self.problem = problem
        particles, lasts = problem.particle_count, problem.end_time - problem.start_time
        self.interval = max(interval or lasts / FRAMES, lasts / MOST_FRAMES)
        frames = math.ceil(lasts / self.interval * (1.0 - 1e-12)) + 2
        self.stride = -(-particles // (most_bytes // (VALUES * BYTES_PER_VALUE * frames)))
        self.bodies = [body.name for body in problem.bodies]
        self.count = -(-particles // self.stride)
        self.body = np.full(self.count, -1, np.int16)
        self.times: list[float] = []
        self.frames: list[np.ndarray] = []  # (n, VALUES)
        self.whole = True

    @property
    def due(self) -> float:
        """Time of the next frame, s: the multiple of the interval after the last one."""
        if not self.times:
            return 0.0
        return (math.floor(self.times[-1] / self.interval * (1.0 + 1e-12)) + 1) * self.interval

    def add(self, snapshot: Snapshot) -> None:
        """Add a frame, unless that of this time is there."""
        if not self.times or snapshot.time > self.times[-1]:
            self.times.append(snapshot.time)
            self.frames.append(self._frame(snapshot))

    def save(self, path: Path, *, compressed: bool = False) -> None:
        """Write the film: whole, or not at all."""
        write = np.savez_compressed if compressed else np.savez
        frames = np.stack(self.frames) if self.frames else np.empty((0, self.count, VALUES))
        scalars = dict(zip(SCALARS, np.moveaxis(frames[..., 3:], -1, 0), strict=True))

        def fill(part: Path) -> None:
            with open(part, "wb") as file:
                write(
                    file,
                    time=np.array(self.times),
                    position=frames[..., :3],
                    number=np.arange(self.count) * self.stride,
                    body=self.body,
                    bodies=self.bodies,
                    stride=self.stride,
                    whole=self.whole,
                    **scalars,
                )

        write_atomically(path, fill)

    def resume(self, path: Path, frames: int) -> None:
        """Continue after the first ``frames`` of a saved film, or begin here where they are lost."""
        try:
            with np.load(path) as saved:
                fits = saved["time"].size >= frames and int(saved["stride"]) == self.stride
                if fits and frames:
                    columns = [saved["position"], *(saved[name][..., None] for name in SCALARS)]
                    self.frames = list(np.concatenate(columns, axis=-1)[:frames])
                    self.times, self.body = saved["time"][:frames].tolist(), saved["body"]
                    self.whole = bool(saved["whole"])
                    return
        except (OSError, KeyError, ValueError, BadZipFile):
            pass  # not there, or damaged
        self.whole = False

    def _frame(self, snapshot: Snapshot) -> np.ndarray:
        particles = snapshot.particles
        shown = (particles.number % self.stride == 0) & (particles.alive == 1)
        place = particles.number[shown] // self.stride
        frame = np.full((self.count, VALUES), np.nan, np.float32)
        frame[place, :3] = particles.position[shown]
        frame[place, 3] = np.linalg.norm(particles.velocity[shown], axis=1)
        frame[place, 4:] = np.stack([getattr(particles, name)[shown] for name in SCALARS[1:]], axis=-1)
        self.body[place] = snapshot.body[shown]
        departed = snapshot.departed
        shown = departed.number % self.stride == 0
        place = departed.number[shown] // self.stride
        frame[place, :3] = flown_on_grid(self.problem, departed, snapshot.time)[shown]
        frame[place, 3] = np.linalg.norm(departed.velocity[shown], axis=1)
        frame[place, SCALARS.index("pressure") + 3] = 0.0
        for name in ("temperature", "plastic_strain", "damage"):
            frame[place, SCALARS.index(name) + 3] = getattr(departed, name)[shown]
        frame[np.isnan(frame[:, 0])] = np.nan
        return frame
