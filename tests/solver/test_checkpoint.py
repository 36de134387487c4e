"""A run that goes on from a checkpoint ends with the bits of one that never stopped, or starts anew and says why."""

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import checkpoint as module
from solver import simulation as simulation_module
from solver.checkpoint import (
    Carried,
    Checkpointing,
    Refused,
    content_hash,
    fingerprint,
    read_checkpoint,
    write_checkpoint,
)
from solver.errors import Interrupted
from solver.problem import Contact, Damping, Face, Problem, Retirement, Scheme
from solver.shapes.gimp import Gimp
from solver.shapes.linear import Linear
from solver.shapes.quadratic_bspline import QuadraticBSpline
from solver.simulation import CARRIED, Outcome, Simulation, simulate, start
from solver.state import Snapshot
from tests.solver.bodies import FREE, block, box, real_copper, two_blocks

END = 6e-6  # s: more than two reorderings of the arrays
INTERVAL = END / 7.0  # does not hit END, so that the last observation is an extra one


def blocks(kind: str, **changes: Any) -> Problem:
    """A block that flies into another."""
    return two_blocks(kind, **{"end_time": END, **changes})


def leaving(kind: str, speed: float = 3000.0) -> Problem:
    """A block that leaves through a free face, and one behind it that stands."""
    flat = kind == "axisymmetric"
    geometry = box(6, 10) if flat else box(6, 6, 10)
    low, high = ((1.0,), (4.0,)) if flat else ((1.0, 2.0), (4.0, 4.0))
    bodies = (
        block(geometry, (*low, 1.0), (*high, 2.0), name="stays", matter=real_copper()),
        block(
            geometry,
            (*low, 7.5),
            (*high, 9.75),
            velocity=(0.0, speed, 0.0) if flat else (0.0, 0.0, speed),
            name="goes",
            matter=real_copper(),
        ),
    )
    inner = ((Face.SYMMETRIC if flat else Face.FREE, Face.FREE), FREE, FREE)
    return Problem(geometry, bodies, inner, end_time=END)


def with_debris() -> Problem:
    """A block that flies away from one that stands, and is retired at the first reordering."""
    geometry = box(6, 20)
    bodies = (
        block(geometry, (1.0, 1.0), (4.0, 3.0), name="stays", matter=real_copper()),
        block(geometry, (1.0, 8.0), (4.0, 9.0), velocity=(0.0, 800.0, 0.0), name="goes"),
    )
    inner = ((Face.SYMMETRIC, Face.FREE), FREE, FREE)
    rule = Retirement(body=0, after=0.0)
    return Problem(geometry, bodies, inner, end_time=3.0 * END, retirement=rule)


def at_wall() -> Problem:
    """A block that hits a wall, slides along a plane of symmetry and is let go."""
    geometry = box(6, 8)
    body = block(
        geometry, (0.0, 0.0), (3.0, 4.0), velocity=(0.0, -400.0, 0.0), matter=real_copper()
    )
    faces = ((Face.SYMMETRIC, Face.FREE), (Face.WALL, Face.FREE), FREE)
    return Problem(geometry, (body,), faces, end_time=2.0 * END)


# Each has something of its own to carry: a ledger, an impulse, the energy of contact and damping, a constant step.
PROBLEMS: dict[str, Callable[[], Problem]] = {
    "axisymmetric": lambda: blocks("axisymmetric"),
    "cartesian": lambda: blocks("cartesian"),
    "outflow-axisymmetric": lambda: leaving("axisymmetric"),
    "outflow-cartesian": lambda: leaving("cartesian"),
    "wall": at_wall,
    "bspline": lambda: blocks("axisymmetric", shape=QuadraticBSpline()),
    "bspline-cartesian": lambda: blocks("cartesian", shape=QuadraticBSpline()),
    "gimp": lambda: blocks("axisymmetric", shape=Gimp(0.25)),
    "usf": lambda: blocks("axisymmetric", scheme=Scheme.USF),
    "usl": lambda: blocks("axisymmetric", scheme=Scheme.USL, end_time=0.5 * END),
    "damped": lambda: blocks("axisymmetric", damping=Damping(rate=1e5, order=2)),
    "contact": lambda: blocks("axisymmetric", contact=Contact(friction=0.1)),
    "retired": lambda: with_debris(),
    "fixed-step": lambda: blocks("axisymmetric", fixed_dt=1e-8),
}


@dataclass
class Witness:
    """An observer with a memory, and a caller that leaves at the steps that it was told."""

    path: Path
    leave_at: tuple[int, ...] = ()
    seen: list[tuple[int, float]] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    steps: int = 0  # taken by this process

    def observe(self, snapshot: Snapshot) -> None:
        self.seen.append((snapshot.step, float(snapshot.particles.energy.sum())))

    def leave(self) -> bool:
        self.steps += 1
        return self.steps in self.leave_at

    def recall(self, text: str) -> None:
        self.seen = [(step, energy) for step, energy in json.loads(text)]

    def run(self, problem: Problem, **changes: Any) -> Outcome:
        keep = Checkpointing(
            path=self.path,
            remember=lambda: json.dumps(self.seen),
            recall=self.recall,
            leave=self.leave,
            tell=self.told.append,
            **changes,
        )
        return simulate(problem, self.observe, interval=INTERVAL, threads=1, checkpoint=keep)


def same_bits(one: Outcome, other: Outcome) -> bool:
    """Whether two outcomes agree in every bit; NaN is equal to itself here."""
    mine, others = (
        (*outcome.snapshot.particles, *outcome.snapshot.retired) for outcome in (one, other)
    )
    arrays = zip(mine, others, strict=True)
    return all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in arrays) and (
        _numbers(one) == _numbers(other)
    )


def _numbers(outcome: Outcome) -> str:
    return repr(
        (
            outcome.snapshot.time,
            outcome.snapshot.step,
            outcome.snapshot.body.tobytes(),
            outcome.stop,
            asdict(outcome.audit),
            [asdict(audit) for audit in outcome.history],
            asdict(outcome.counters),
            outcome.smallest_step,
            outcome.particle_steps,
        )
    )


REORDERED = 50  # steps between reorderings here, so that short runs have some


@pytest.fixture(autouse=True)
def reordered_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "SORT_INTERVAL", REORDERED)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.checkpoint"


@pytest.fixture(params=list(PROBLEMS))
def problem(request: pytest.FixtureRequest) -> Problem:
    return PROBLEMS[request.param]()


def stopped(problem: Problem, file: Path, step: int) -> Witness:
    """A run that left after some steps."""
    witness = Witness(file, leave_at=(step,))
    with pytest.raises(Interrupted) as caught:
        witness.run(problem)
    assert caught.value.step == step
    return witness


# The same bits


def test_restart__ends_with_the_bits_of_a_run_that_never_stopped(
    problem: Problem, file: Path
) -> None:
    """It stops before, at and after a reordering; what the observer saw is the same too."""
    whole = Witness(file)
    expected = whole.run(problem)
    assert expected.snapshot.step > 2 * REORDERED
    assert not file.exists()
    for step in (1, REORDERED, REORDERED + 17):
        stopped(problem, file, step)
        later = Witness(file)
        outcome = later.run(problem)
        assert same_bits(outcome, expected)
        assert later.seen == whole.seen
        assert later.steps == expected.snapshot.step - step
        file.unlink()


def test_problems__carry_what_they_are_here_for() -> None:
    ends = {name: simulation_at_end(PROBLEMS[name]()) for name in ("wall", "damped", "contact")}
    assert all(ends[name].removed != 0.0 for name in ("damped", "contact"))
    assert ends["wall"].impulse[1] > 0.0
    assert simulation_at_end(PROBLEMS["retired"]()).retired.mass.size > 0
    for name in ("outflow-axisymmetric", "outflow-cartesian"):
        assert simulation_at_end(PROBLEMS[name]()).ledger.particles > 0


def simulation_at_end(problem: Problem) -> Simulation:
    simulation = start(problem, threads=1)
    while simulation.time < problem.end_time:
        simulation.advance()
    return simulation


@pytest.mark.parametrize("name", CARRIED)
def test_restart__would_differ_without_any_of_the_numbers_carried(
    name: str, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The comparison sees each of them: what is left out starts from its initial value again."""
    damped = Damping(rate=1e5, order=2)
    problem = blocks("axisymmetric", damping=damped, contact=Contact(friction=0.1))
    expected = Witness(file).run(problem)
    stopped(problem, file, REORDERED + 17)
    monkeypatch.setattr(
        simulation_module, "CARRIED", tuple(other for other in CARRIED if other != name)
    )
    assert not same_bits(Witness(file).run(problem), expected)


def test_restart__again_and_again_ends_with_the_same_bits(file: Path) -> None:
    problem = leaving("axisymmetric")
    expected = Witness(file).run(problem)
    for _ in range(expected.snapshot.step):
        witness = Witness(file, leave_at=(13,))
        try:
            outcome = witness.run(problem)
        except Interrupted:
            continue
        assert same_bits(outcome, expected)
        return
    raise AssertionError("the run never came to its end")


def test_restart__with_other_threads_ends_with_the_same_bits(file: Path) -> None:
    problem = blocks("axisymmetric")

    def run(threads: int, leave: Callable[[], bool] = lambda: False) -> Outcome:
        keep = Checkpointing(path=file, leave=leave)
        return simulate(problem, interval=INTERVAL, threads=threads, shares=3, checkpoint=keep)

    expected = run(threads=1)
    with pytest.raises(Interrupted):
        run(threads=1, leave=Witness(file, leave_at=(30,)).leave)
    outcome = run(threads=2)
    assert outcome.snapshot.step == expected.snapshot.step
    assert same_bits(outcome, expected)


def test_checkpoint__written_on_the_way_changes_no_bit(file: Path) -> None:
    problem = blocks("axisymmetric")
    expected = simulate(problem, lambda _: None, interval=INTERVAL, threads=1)
    witness = Witness(file)
    assert same_bits(witness.run(problem, seconds_between=0.0), expected)
    later = Witness(file)
    assert same_bits(later.run(problem), expected)
    assert later.steps == 0


def test_restart__tells_where_it_goes_on(file: Path) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    witness = Witness(file)
    witness.run(problem)
    assert len(witness.told) == 1
    assert witness.told[0].startswith("from the checkpoint at t = ")
    assert witness.told[0].endswith("step 30")


def test_run__without_a_file_begins_at_the_start_and_says_nothing(file: Path) -> None:
    witness = Witness(file)
    witness.run(blocks("axisymmetric"))
    assert witness.seen[0][0] == 0
    assert witness.told == []


# What is refused


def anew(problem: Problem, file: Path, **changes: Any) -> str:
    """Why a run started anew; its result is that of a run without a file."""
    expected = simulate(problem, lambda _: None, interval=INTERVAL, threads=1)
    witness = Witness(file)
    outcome = witness.run(problem, **changes)
    assert same_bits(outcome, expected)
    assert witness.steps == expected.snapshot.step
    assert witness.seen[0][0] == 0
    assert len(witness.told) == 1
    return witness.told[0]


@pytest.mark.parametrize("name", ["numba", "llvmlite", "cpu", "cpu_features", "settings", "solver"])
def test_restart__refuses_another_compiler_and_processor(
    name: str, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    there = module.compiler()
    assert name in there
    monkeypatch.setattr(module, "compiler", lambda: {**there, name: "another"})
    assert anew(problem, file).endswith(f"another {name}")


def test_restart__refuses_another_physics(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    monkeypatch.setattr(module, "PHYSICS_VERSION", module.PHYSICS_VERSION + 1)
    assert anew(problem, file).endswith("another physics")


def test_restart__refuses_another_problem(file: Path) -> None:
    stopped(blocks("axisymmetric"), file, 30)
    other = blocks("axisymmetric", courant=math.nextafter(0.4, 1.0))
    assert anew(other, file).endswith("another problem")


def test_restart__refuses_another_number_of_shares(file: Path) -> None:
    """Sums in another order have other bits."""
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    told: list[str] = []
    keep = Checkpointing(path=file, tell=told.append)
    outcome = simulate(problem, interval=INTERVAL, threads=1, shares=2, checkpoint=keep)
    assert told[0].endswith("another shares")
    assert same_bits(outcome, simulate(problem, interval=INTERVAL, threads=1, shares=2))


def test_restart__refuses_what_another_caller_remembered(file: Path) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    assert anew(problem, file, caller="later").endswith("another caller")


def test_restart__refuses_another_interval_of_observation(file: Path) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    told: list[str] = []
    keep = Checkpointing(path=file, tell=told.append)
    simulate(problem, interval=2.0 * INTERVAL, threads=1, checkpoint=keep)
    assert told[0].endswith("another interval")


@pytest.mark.parametrize("length", [0, 1, 31, 32, 33, 500, -32, -1])
def test_restart__refuses_a_truncated_file(length: int, file: Path) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    whole = file.read_bytes()
    assert len(whole) > 500
    file.write_bytes(whole[:length])
    assert anew(problem, file).endswith("the file is damaged")


@pytest.mark.parametrize("part", [0.0, 0.05, 0.5, 0.95, 1.0])
def test_restart__refuses_a_file_with_one_bit_flipped(part: float, file: Path) -> None:
    problem = blocks("axisymmetric")
    stopped(problem, file, 30)
    whole = bytearray(file.read_bytes())
    whole[round(part * (len(whole) - 1))] ^= 1
    file.write_bytes(whole)
    assert anew(problem, file).endswith("the file is damaged")


def test_restart__refuses_a_file_that_it_may_not_read(file: Path) -> None:
    file.mkdir()
    witness = Witness(file)
    outcome = witness.run(blocks("axisymmetric"))
    assert outcome.stop == "end_time"
    assert witness.told[0].startswith("from the start")


# The file


SAMPLE = Carried(
    {"time": 0.1 + 0.2, "last": math.inf, "none": None, "list": [1, 2.5, "three"]},
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


def test_file__gives_every_bit_back(written: Path) -> None:
    found = read_checkpoint(written, MARK)
    assert found.numbers == SAMPLE.numbers
    assert list(found.arrays) == list(SAMPLE.arrays)
    for name, array in SAMPLE.arrays.items():
        assert found.arrays[name].shape == array.shape
        assert found.arrays[name].dtype == array.dtype
        assert found.arrays[name].tobytes() == array.tobytes()
        assert found.arrays[name].flags.writeable


@given(st.floats())
def test_file__gives_every_number_back(tmp_path_factory: pytest.TempPathFactory, x: float) -> None:
    file = tmp_path_factory.mktemp("file") / "numbers"
    write_checkpoint(file, MARK, Carried({"x": x}, {}))
    assert repr(read_checkpoint(file, MARK).numbers["x"]) == repr(x)


def test_file__stands_alone_in_its_folder(written: Path) -> None:
    write_checkpoint(written, MARK, SAMPLE)
    assert list(written.parent.iterdir()) == [written]


def test_file__stays_as_it_was_when_a_write_fails(
    written: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = written.read_bytes()

    def full(_: int) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(module.os, "fsync", full)
    with pytest.raises(OSError, match="no space"):
        write_checkpoint(written, MARK, replace(SAMPLE, numbers={"other": 1}))
    assert written.read_bytes() == before
    assert list(written.parent.iterdir()) == [written]


def test_file__of_any_damage_is_refused(written: Path) -> None:
    whole = written.read_bytes()
    for place in range(len(whole)):
        for bit in (1, 128):
            damaged = bytearray(whole)
            damaged[place] ^= bit
            written.write_bytes(damaged)
            with pytest.raises(Refused, match="damaged"):
                read_checkpoint(written, MARK)


def test_run__that_cannot_write_says_so_and_goes_on(tmp_path: Path) -> None:
    witness = Witness(tmp_path / "absent" / "run.checkpoint")
    outcome = witness.run(blocks("axisymmetric", end_time=5e-8), seconds_between=0.0)
    assert outcome.stop == "end_time"
    assert witness.told[0].startswith("a checkpoint could not be written")


# The content of a problem


def changed(**changes: Any) -> Problem:
    return blocks("axisymmetric", **changes)


def test_content__of_two_equal_problems_is_one() -> None:
    assert content_hash(changed()) == content_hash(changed())


def test_content__differs_with_every_part_of_a_problem() -> None:
    plain = changed()
    body = plain.bodies[0]
    moved = body.position.copy()
    moved[0, 0] = np.nextafter(moved[0, 0], 1.0)
    others = [
        changed(end_time=2.0 * END),
        changed(speed=2001.0),
        changed(shape=QuadraticBSpline()),
        changed(scheme=Scheme.USF),
        changed(damping=Damping(rate=1.0)),
        changed(contact=Contact()),
        changed(faces=(FREE, FREE, FREE)),
        replace(plain, bodies=(replace(body, position=moved), plain.bodies[1])),
        replace(plain, bodies=(replace(body, energy=1.0), plain.bodies[1])),
        replace(plain, bodies=plain.bodies[::-1]),
        replace(plain, geometry=plain.geometry._replace(spacing=1.0000001e-3)),
    ]
    hashes = {content_hash(one) for one in (plain, *others)}
    assert len(hashes) == 1 + len(others)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, 1.0),
        (0.0, -0.0),
        (True, 1),
        ("1", 1),
        ((1, 2), (1, (2,))),
        (np.zeros(4), np.zeros((2, 2))),
        (np.zeros(2), np.zeros(2, np.int64)),
        (Scheme.USF, 1),
        (Linear(), ()),
    ],
)
def test_content__tells_apart_what_only_looks_alike(one: object, other: object) -> None:
    assert content_hash(one) != content_hash(other)


def test_content__of_something_unknown_is_refused() -> None:
    with pytest.raises(TypeError, match="dict"):
        content_hash({"a": 1})


def test_fingerprint__names_what_decides_the_bits() -> None:
    named = set(fingerprint(changed()))
    assert named >= {"cpu", "cpu_features", "numba", "numpy", "physics", "problem", "solver"}
