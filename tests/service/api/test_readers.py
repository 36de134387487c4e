"""Child processes that read sweeps: what they refuse, what ends them, and who waits for whom."""

import json
import time
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

import anyio
import pytest

from service.api.errors import ReaderLost, TooManyRequests
from service.api.readers import Readers
from service.api.reading import Posted, ReadingLimits
from service.estimates.estimate import EstimatedSweep, estimated
from studies.quantities.findings import InvalidInput
from tests.claims.marked import Compared, claimed
from tests.claims.rows import at_most
from tests.service.support.api import LARGE_SWEEPS, SWEEP
from tests.service.support.parts import burn, die, fill, freeze, pid

Use = Callable[[Readers], Awaitable[Any]]


def posted(document: Any) -> Posted:
    return Posted("application/json", json.dumps(document).encode(), 10_000)


def ask(use: Use, **options: Any) -> Any:
    """What is made of the children, which end with the event loop."""
    return anyio.run(use, Readers(**options))


def test_refusal__keeps_fields_values_limits_cures_and_pointers_between_processes() -> None:
    wrong = posted({**SWEEP, "axes": {"speed": ["3 km/s", "6"]}, "fixd": {}})

    async def use(readers: Readers) -> Any:
        return await readers.run(estimated, wrong)

    with pytest.raises(InvalidInput) as refused:
        ask(use)
    with pytest.raises(InvalidInput) as here:
        estimated(wrong)
    assert (refused.value.findings, str(refused.value)) == (here.value.findings, str(here.value))
    assert refused.value.pointers["axes.speed[1]"] == "/axes/speed/1"


@pytest.mark.parametrize("part", claimed([burn, fill], [fill], "mend-again", "reader-limits"))
def test_limit__ends_one_sweep_with_a_refusal_and_its_child_goes_on(part: Any) -> None:
    """A limit of computing or memory ends the reading of one sweep with a refusal, and its child goes on."""

    async def use(readers: Readers) -> Any:
        body = posted(SWEEP)
        first = await readers.run(pid, body)
        with pytest.raises(InvalidInput) as refused:
            await readers.run(part, body)
        return refused.value, first, await readers.run(pid, body)

    refusal, before, after = ask(use, limits=ReadingLimits(cpu_seconds=1, memory=600 << 20))
    assert {burn: "1 s of computing", fill: "600 MiB"}[part] in refusal.findings[0].limit
    assert before == after


@pytest.mark.parametrize("part", claimed([die, freeze], [die], "mend-again", "frozen-reader"))
def test_child__that_is_killed_or_frozen_is_replaced(part: Any) -> None:
    """A child that reads sweeps and is killed or frozen is replaced."""

    async def use(patient: Readers) -> Any:
        with pytest.raises(ReaderLost):
            await Readers(wall_seconds=2.0 if part is freeze else 120.0).run(part, posted(SWEEP))
        return await patient.run(estimated, posted(SWEEP))

    assert isinstance(ask(use), EstimatedSweep)


def test_request__that_finds_no_child_in_time_is_refused() -> None:
    async def use(readers: Readers) -> None:
        async with readers.slot("ann"):
            with pytest.raises(TooManyRequests):
                async with readers.slot("ann"):
                    pass
            async with readers.slot("bob"):
                pass

    ask(use, wait_seconds=0.05)


@pytest.mark.claim("mend-again", "estimates", minutes=0.1)
@pytest.mark.parametrize("name", LARGE_SWEEPS)
def test_estimate__of_a_large_sweep_is_cheap(name: str, compared: Compared) -> None:
    """The estimate of a sweep of nearly ten thousand runs takes half a second of computing time."""
    estimate = partial(estimated, posted(LARGE_SWEEPS[name]))
    estimate()  # loads what all others use
    begin = time.process_time()
    assert isinstance(estimate(), EstimatedSweep)
    seconds = time.process_time() - begin
    compared(at_most(f"{name}: computing time (s)", limit=0.5, got=seconds))
