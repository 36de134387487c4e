"""A Dask worker as a slot of whipple."""

import threading
from pathlib import Path
from types import SimpleNamespace

from service.execution import dask_worker
from service.records.attempt import Ending
from solver import PHYSICS_VERSION
from tests.service.support.cluster import attempt_in, checkpoint_step, pid_of
from tests.service.support.fakes import is_gone


def test_differences__name_the_versions_of_both_sides() -> None:
    own = dask_worker.software()
    assert {"whipple", "physics", "python", "numba", "numpy"} == own.keys()
    assert f"physics={PHYSICS_VERSION} " in dask_worker.OFFER
    assert dask_worker.differences(own) == ""
    other = {**own, "physics": "0", "numba": "0.1"}
    expected = f"physics 0, on the service {PHYSICS_VERSION}; numba 0.1, on the service {own['numba']}"
    assert dask_worker.differences(other) == expected
    assert "--preload" in dask_worker.differences(None)


def test_worker__offers_one_slot_and_lets_its_attempt_leave_when_it_ends(tmp_path: Path) -> None:
    attempt, endings = attempt_in(tmp_path, seconds=20.0), list[Ending]()
    has_progress = threading.Event()
    state = SimpleNamespace(total_resources={}, available_resources={})
    worker = SimpleNamespace(startup_information={}, state=state, log_event=lambda _topic, _event: has_progress.set())
    dask_worker.dask_setup(worker)
    assert state.total_resources == state.available_resources == {dask_worker.OFFER: 1.0}
    assert list(worker.startup_information) == [dask_worker.SOFTWARE]
    thread = threading.Thread(target=lambda: endings.append(dask_worker.compute(attempt)))
    thread.start()
    try:
        assert has_progress.wait(60)
        dask_worker.dask_teardown(worker)
        thread.join(60)
        assert endings[0].failure == "Left"
        assert endings[0].checkpoint == checkpoint_step(attempt)
    finally:
        dask_worker.stop([attempt.key])
        thread.join(60)
        dask_worker.dask_teardown(worker)
    assert is_gone(pid_of(attempt))
