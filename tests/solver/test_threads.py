"""Work cut for threads covers everything once, and the cut does not show in the result."""

import itertools
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.grid.step import shares_of
from solver.simulation import simulate
from solver.state import Snapshot
from solver.steps.threads import ThreadPool
from tests.solver.bodies import after, assert_same_bits, each_kind, two_blocks

STEPS = 60  # more than half of the way to the first reordering of the arrays
SHARES = 4  # work for three threads


@given(st.integers(0, 10_000), st.integers(1, 4), st.sampled_from([1, 7, 1024]))
def test_ranges__cover_everything_once_from_multiples_of_the_grain(count: int, threads: int, grain: int) -> None:
    ranges = ThreadPool(threads).ranges(count, grain)
    assert len(ranges) <= threads
    assert all(begin % grain == 0 for begin, _ in ranges)
    assert [place for begin, end in ranges for place in range(begin, end)] == list(range(count))


@pytest.mark.parametrize("threads", [1, 3])
def test_pool__runs_every_share_and_passes_on_what_one_raises(threads: int) -> None:
    done: list[int] = []
    ThreadPool(threads).run(done.append, [3, 1, 2])
    assert sorted(done) == [1, 2, 3]

    def fail(share: int) -> None:
        raise ZeroDivisionError(share)

    with pytest.raises(ZeroDivisionError):
        ThreadPool(threads).run(fail, [1, 2])


def test_simulate__ends_its_threads_when_an_error_still_holds_its_frame() -> None:
    before = set(threading.enumerate())
    threads: list[int] = []

    def observe(snapshot: Snapshot) -> None:
        threads.append(len(set(threading.enumerate()) - before))
        if snapshot.step:
            raise ZeroDivisionError

    problem = two_blocks("axisymmetric", end_time=1e-8)
    with pytest.raises(ZeroDivisionError) as held:
        simulate(problem, observe, threads=3, shares=SHARES)
    assert held.tb is not None
    assert threads == [0, 3]
    assert set(threading.enumerate()) <= before


@given(st.lists(st.integers(0, 3000), min_size=1, max_size=4), st.integers(1, 9))
def test_shares__cover_the_particles_of_every_body_once(sizes: list[int], shares: int) -> None:
    """In their order, and by less than two particles more in one share than in another."""
    edges = np.cumsum([0, *sizes]).tolist()
    ranges = list(itertools.pairwise(edges))
    cut = shares_of(ranges, shares)
    assert cut.shape == (shares, len(sizes), 2)
    for body, (begin, end) in enumerate(ranges):
        covered = [place for low, high in cut[:, body] for place in range(low, high)]
        assert covered == list(range(begin, end))
        assert np.ptp(cut[:, body, 1] - cut[:, body, 0]) <= 1


@pytest.mark.claim("speed", "same-bits")
@each_kind
def test_step__gives_the_same_bits_with_any_number_of_threads(kind: str) -> None:
    """Two and three threads change no bit."""
    serial, double, triple = (
        after(two_blocks(kind), STEPS, threads=threads, shares=SHARES).particles for threads in (1, 2, 3)
    )
    assert_same_bits(serial, double)
    assert_same_bits(serial, triple)
