"""What makes a Dask worker a slot of whipple."""

import threading
from pathlib import Path
from types import SimpleNamespace

from service.execution import dask_worker
from service.records.attempt import Ending
from solver import PHYSICS_VERSION
from tests.service.support.cluster import pid_of, ticket
from tests.service.support.fakes import is_gone


def test_offer__names_what_decides_the_numbers() -> None:
    assert f"physics={PHYSICS_VERSION} " in dask_worker.OFFER
    assert {"whipple", "physics", "python", "numba", "numpy"} == dask_worker.software().keys()


def test_differences__of_the_same_software_there_are_none() -> None:
    assert dask_worker.differences(dask_worker.software()) == ""


def test_differences__name_both_sides() -> None:
    found = {**dask_worker.software(), "physics": "0", "numba": "0.1"}
    ours = dask_worker.software()
    assert (
        dask_worker.differences(found)
        == f"physics 0, here {PHYSICS_VERSION}; numba 0.1, here " + (ours["numba"])
    )
    assert "--preload" in dask_worker.differences(None)


def test_setup__offers_one_attempt_at_a_time() -> None:
    state = SimpleNamespace(total_resources={}, available_resources={})
    worker = SimpleNamespace(startup_information={}, state=state)
    dask_worker.dask_setup(worker)
    assert state.total_resources == state.available_resources == {dask_worker.OFFER: 1.0}
    assert list(worker.startup_information) == [dask_worker.SOFTWARE]


def test_teardown__lets_the_attempt_leave_with_a_checkpoint(tmp_path: Path) -> None:
    order, endings, told = ticket(tmp_path, seconds=20.0), list[Ending](), threading.Event()
    state = SimpleNamespace(total_resources={}, available_resources={})
    worker = SimpleNamespace(
        startup_information={}, state=state, log_event=lambda _topic, _event: told.set()
    )
    dask_worker.dask_setup(worker)
    thread = threading.Thread(target=lambda: endings.append(dask_worker.compute(order)))
    thread.start()
    try:
        assert told.wait(60)
        dask_worker.dask_teardown(worker)
        thread.join(60)
        assert endings[0].failure == "Left"
        assert endings[0].checkpoint == int(Path(str(order.checkpoint)).read_text())
    finally:
        dask_worker.stop([order.key])
        thread.join(60)
        dask_worker.dask_teardown(worker)
    assert is_gone(pid_of(order))
