"""A run that goes on from a checkpoint ends with the bits of one that never stopped, or starts anew and says why."""

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver import checkpoints as module
from solver import simulation as simulation_module
from solver.checkpoints import (
    Carried,
    Checkpointing,
    CheckpointRefused,
    content_hash,
    read_checkpoint,
    write_checkpoint,
)
from solver.errors import Interrupted
from solver.grid.shapes.quadratic_bspline import QuadraticBSpline
from solver.problem import Contact, Damping, Face, Problem, Retirement, Scheme
from solver.simulation import Outcome, simulate
from solver.state import Snapshot
from tests import samples
from tests.claims.marked import claimed
from tests.solver.bodies import ABOUT_AXIS, FREE, after, block, box, leaving, two_blocks
from tests.solver.test_flight import arriving
from tests.solver.test_strays import closing

END = 6e-6  # s: more than two reorderings of the arrays
INTERVAL = END / 7.0  # does not hit END, so that the last observation is an extra one
REORDERED = 50  # steps between reorderings here, so that short runs have some
STOPPED = 30


def blocks(**changes: Any) -> Problem:
    return two_blocks("axisymmetric", **{"end_time": END, **changes})


GRAVITY = (0.0, -1e6, 0.0)  # m/s2: as much as the bits show


def rubbing(**changes: Any) -> Problem:
    """The same with damping, and with contact between the blocks."""
    return blocks(damping=Damping(rate=1e5, order=2), contact=Contact(friction=0.1), **changes)


def with_debris() -> Problem:
    """A block that flies away from one that stands, and is retired at the first reordering."""
    geometry = box(6, 20)
    bodies = (
        block(geometry, (1.0, 1.0), (4.0, 3.0), name="stays"),
        block(geometry, (1.0, 8.0), (4.0, 9.0), velocity=(0.0, 800.0, 0.0), name="goes"),
    )
    rule = Retirement(body=0, after=0.0)
    return Problem(geometry, bodies, ABOUT_AXIS, end_time=3.0 * END, retirement=rule)


def at_wall() -> Problem:
    """A block that hits a wall, slides along a plane of symmetry and is let go."""
    geometry = box(6, 8)
    body = block(geometry, (0.0, 0.0), (3.0, 4.0), velocity=(0.0, -400.0, 0.0))
    faces = (ABOUT_AXIS[0], (Face.WALL, Face.FREE), FREE)
    return Problem(geometry, (body,), faces, end_time=2.0 * END)


# Each has something of its own to carry, above zero in the run. Every shape and scheme is the case ``bits``.
PROBLEMS: dict[str, tuple[Callable[[], Problem], Callable[[Any], float]]] = {
    "outflow": (lambda: leaving("axisymmetric", end_time=END), lambda run: run.books.ledger.mass),
    "outflow-3d": (lambda: leaving("cartesian", end_time=END), lambda run: run.books.ledger.mass),
    "wall": (at_wall, lambda run: run.books.impulse[1]),
    "rubbing": (rubbing, lambda run: min(run.books.removed, run.books.removed_by_contact)),
    "spline": (lambda: blocks(shape=QuadraticBSpline()), lambda run: run.counters.tension_floors),
    "usf": (lambda: blocks(scheme=Scheme.USF), lambda run: run.counters.tension_floors),
    "fixed-step": (lambda: blocks(fixed_dt=2e-8), lambda run: run.counters.tension_floors),
    "loaded": (lambda: blocks(gravity=GRAVITY), lambda run: abs(run.books.worked)),
    "retired": (with_debris, lambda run: run.departed.mass.size),
    "arrivals": (arriving, lambda run: run.arrived),
    "discarded": (lambda: closing("axisymmetric", end_time=2e-6), lambda run: run.books.ledger.discarded),
}
OF_OTHER_METHODS = tuple(samples.joined("PROBLEMS", {}, "solver"))
PROBLEMS |= samples.joined("PROBLEMS", {}, "solver")
IN_THE_CLAIM = set[str]().union(*samples.offered("LONG", "solver"))


@dataclass
class Witness:
    """An observer with a memory, and a caller that leaves after given numbers of steps."""

    path: Path
    leave_at: tuple[int, ...] = ()
    observed: list[tuple[int, float]] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    steps: int = 0  # taken by this process

    def observe(self, snapshot: Snapshot) -> None:
        self.observed.append((snapshot.step, float(snapshot.particles.energy.sum())))

    def leave(self) -> bool:
        self.steps += 1
        return self.steps in self.leave_at

    def recall(self, text: str) -> None:
        self.observed = [(step, energy) for step, energy in json.loads(text)]

    def run(
        self, problem: Problem, *, interval: float = INTERVAL, threads: int = 1, shares: int = 0, **changes: Any
    ) -> Outcome:
        checkpoint = Checkpointing(
            path=self.path,
            observer_state=lambda: json.dumps(self.observed),
            restore_observer=self.recall,
            must_stop=self.leave,
            log=self.messages.append,
            **{"seconds_between": math.inf, **changes},  # however long its kernels compile
        )
        return simulate(problem, self.observe, interval=interval, threads=threads, shares=shares, checkpoint=checkpoint)


def same_bits(outcome: Outcome, other: Outcome) -> bool:
    """Whether two outcomes agree in every bit; NaN is equal to itself here."""
    return _bits(outcome) == _bits(other)


def _bits(outcome: Outcome) -> tuple[Any, ...]:
    snapshot = outcome.snapshot
    arrays = (*snapshot.particles, *snapshot.departed, snapshot.body)
    numbers = (
        snapshot.time,
        snapshot.step,
        outcome.stop,
        asdict(outcome.audit),
        [asdict(audit) for audit in outcome.history],
        asdict(outcome.counters),
        outcome.smallest_step,
        outcome.particle_steps,
    )
    return repr(numbers), *((array.dtype, array.tobytes()) for array in arrays)


@pytest.fixture(autouse=True)
def reordered_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "SORT_INTERVAL", REORDERED)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.checkpoint"


def stopped(problem: Problem, file: Path, step: int = STOPPED, **changes: Any) -> None:
    with pytest.raises(Interrupted) as caught:
        Witness(file, leave_at=(step,)).run(problem, **changes)
    assert caught.value.step == step


# The same bits


@pytest.mark.claim("speed", "same-bits")
@pytest.mark.parametrize("name", claimed(PROBLEMS, PROBLEMS.keys() - IN_THE_CLAIM, "numerics", "restart"))
def test_restart__ends_with_the_bits_of_a_run_that_never_stopped(name: str, file: Path) -> None:
    """A run that stopped before, at or after a reordering goes on with the bits and memory of one that did not."""
    problem, carries = PROBLEMS[name][0](), PROBLEMS[name][1]
    whole = Witness(file)
    expected = whole.run(problem)
    assert carries(after(problem, expected.snapshot.step)) > 0.0
    assert expected.snapshot.step > 2 * REORDERED
    assert whole.messages == []
    assert not file.exists()
    for step in (1, REORDERED, REORDERED + 17):
        stopped(problem, file, step)
        later = Witness(file)
        outcome = later.run(problem)
        assert same_bits(outcome, expected)
        assert later.observed == whole.observed
        assert later.steps == expected.snapshot.step - step
        assert len(later.messages) == 1
        assert later.messages[0].startswith("from the checkpoint at t = ")
        assert later.messages[0].endswith(f"step {step}")
        file.unlink()


@pytest.mark.claim("methods", "methods-speed")
@pytest.mark.parametrize(
    "name",
    claimed(
        ("outflow", "retired", "arrivals", *OF_OTHER_METHODS),
        {"outflow", "retired", "arrivals", *OF_OTHER_METHODS} - IN_THE_CLAIM,
        "numerics",
        "restart",
    ),
)
def test_restart__with_other_threads_ends_with_the_same_bits(name: str, file: Path) -> None:
    """Two threads change no bit of any method."""
    problem = PROBLEMS[name][0]()
    expected = Witness(file).run(problem, shares=3)
    stopped(problem, file, shares=3)
    later = Witness(file)
    assert same_bits(later.run(problem, threads=2, shares=3), expected)
    assert later.steps == expected.snapshot.step - STOPPED


# What is refused


def starts_anew(problem: Problem, file: Path, **changes: Any) -> str:
    """Why a run started anew; its result is that of a run without a file."""
    expected = Witness(file.with_name("absent")).run(problem, **changes)
    witness = Witness(file)
    assert same_bits(witness.run(problem, **changes), expected)
    assert witness.steps == expected.snapshot.step
    assert witness.observed[0][0] == 0
    [message] = witness.messages
    assert message.startswith("from the start, without the checkpoint: ")
    return message


@pytest.mark.parametrize(
    ("problem", "changes", "reason"),
    [
        ({}, {"shares": 2}, "shares"),  # sums in another order have other bits
        ({}, {"interval": 2.0 * INTERVAL}, "interval"),
        ({}, {"caller": "later"}, "caller"),
        ({"courant": math.nextafter(0.4, 1.0)}, {}, "problem"),
    ],
)
def test_restart__refuses_what_another_call_left(
    problem: dict[str, Any], changes: dict[str, Any], reason: str, file: Path
) -> None:
    stopped(blocks(), file)
    assert starts_anew(blocks(**problem), file, **changes).endswith(f"different {reason}")


def test_restart__refuses_another_physics_and_compiler(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped(blocks(), file)
    there = module.compiler()
    monkeypatch.setattr(module, "compiler", lambda: {**there, "cpu": "another"})
    monkeypatch.setattr(module, "PHYSICS_VERSION", module.PHYSICS_VERSION + 1)
    assert starts_anew(blocks(), file).endswith("different cpu, physics")


def test_run__that_cannot_write_says_so_and_goes_on(tmp_path: Path) -> None:
    witness = Witness(tmp_path / "absent" / "run.checkpoint")
    assert witness.run(blocks(end_time=5e-8), seconds_between=0.0).stop == "end_time"
    assert witness.messages[0].startswith("a checkpoint could not be written")


# The file


SAMPLE = Carried(
    {"time": 0.1 + 0.2, "last": math.inf, "none": None, "list": [1, 2.5, "three", 5e-324, -0.0]},
    {
        "doubles": np.array([0.0, -0.0, 5e-324, math.inf, math.nan, 1.0 / 3.0]).reshape(2, 3),
        "bytes": np.array([1, 0, 255], np.uint8),
        "integers": np.array([-(2**62)], np.int64),
        "nothing": np.empty((0, 3)),
    },
)
MARK = {"compiler": "one"}


@pytest.fixture
def written(file: Path) -> Path:
    write_checkpoint(file, MARK, SAMPLE)
    return file


def test_file__stays_alone_and_as_it_was_when_a_write_fails(written: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_checkpoint(written, MARK, SAMPLE)
    assert list(written.parent.iterdir()) == [written]
    before = written.read_bytes()

    def full(_: int) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(module.os, "fsync", full)
    with pytest.raises(OSError, match="no space"):
        write_checkpoint(written, MARK, replace(SAMPLE, numbers={"other": 1}))
    assert written.read_bytes() == before
    assert list(written.parent.iterdir()) == [written]


def test_file__of_any_damage_is_refused(written: Path) -> None:
    """A bit of any byte flipped, or the end of the file missing."""
    whole = written.read_bytes()
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        for content in (bytes(damaged), whole[:place]):
            written.write_bytes(content)
            with pytest.raises(CheckpointRefused, match="damaged"):
                read_checkpoint(written, MARK)


# The content of a problem


def test_content__differs_with_every_part_of_a_problem() -> None:
    plain = blocks()
    body, plate = plain.bodies
    moved = body.position.copy()
    moved[0, 0] = np.nextafter(moved[0, 0], 1.0)
    others = [
        blocks(end_time=2.0 * END),
        blocks(speed=2001.0),
        blocks(shape=QuadraticBSpline()),
        blocks(scheme=Scheme.USF),
        blocks(damping=Damping(rate=1.0)),
        blocks(contact=Contact()),
        blocks(faces=(FREE, FREE, FREE)),
        replace(plain, bodies=(replace(body, position=moved), plate)),
        replace(plain, bodies=(replace(body, energy=1.0), plate)),
        replace(plain, bodies=(plate, body)),
        replace(plain, geometry=plain.geometry._replace(spacing=1.0000001e-3)),
    ]
    assert content_hash(blocks()) == content_hash(plain)
    assert len({content_hash(problem) for problem in (plain, *others)}) == 1 + len(others)
