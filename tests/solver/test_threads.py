"""Work cut for threads covers everything once, and the cut does not show in the result."""

import pytest

from solver.steps.threads import ThreadPool
from tests.solver.bodies import after, assert_same_bits, each_kind, two_blocks

STEPS = 60  # more than half of the way to the first reordering of the arrays
SHARES = 4  # work for three threads


@pytest.mark.parametrize("threads", [1, 3])
def test_pool__runs_every_share_and_passes_on_what_one_raises(threads: int) -> None:
    done: list[int] = []
    ThreadPool(threads).run(done.append, [3, 1, 2])
    assert sorted(done) == [1, 2, 3]

    def fail(share: int) -> None:
        raise ZeroDivisionError(share)

    with pytest.raises(ZeroDivisionError):
        ThreadPool(threads).run(fail, [1, 2])


@pytest.mark.claim("speed", "same-bits")
@each_kind
def test_step__gives_the_same_bits_with_any_number_of_threads(kind: str) -> None:
    """Two and three threads change no bit."""
    serial, double, triple = (
        after(two_blocks(kind), STEPS, threads=threads, shares=SHARES).particles for threads in (1, 2, 3)
    )
    assert_same_bits(serial, double)
    assert_same_bits(serial, triple)
