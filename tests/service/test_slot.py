"""What makes a Dask worker a slot."""

import threading
from pathlib import Path
from types import SimpleNamespace

from service import slot, supervisor, warm
from service.attempt import Ending
from service.supervisor import supervise
from solver import PHYSICS_VERSION
from tests.service.cluster import pid_of, ticket
from tests.service.doubles import is_gone


def test_offer__names_what_decides_the_numbers() -> None:
    assert f"physics={PHYSICS_VERSION} " in slot.OFFER
    assert {"whipple", "physics", "python", "numba", "numpy"} == slot.software().keys()


def test_differences__of_the_same_software_there_are_none() -> None:
    assert slot.differences(slot.software()) == ""


def test_differences__name_both_sides() -> None:
    found = {**slot.software(), "physics": "0", "numba": "0.1"}
    ours = slot.software()
    assert (
        slot.differences(found)
        == f"physics 0, here {PHYSICS_VERSION}; numba 0.1, here " + (ours["numba"])
    )
    assert "--preload" in slot.differences(None)


def test_setup__offers_one_attempt_at_a_time() -> None:
    state = SimpleNamespace(total_resources={}, available_resources={})
    worker = SimpleNamespace(startup_information={}, state=state)
    slot.dask_setup(worker)
    assert state.total_resources == state.available_resources == {slot.OFFER: 1.0}
    assert list(worker.startup_information) == [slot.SOFTWARE]


def test_teardown__lets_the_attempt_leave_with_a_checkpoint(tmp_path: Path) -> None:
    order, endings = ticket(tmp_path, seconds=20.0), list[Ending]()
    told = threading.Event()
    thread = threading.Thread(target=lambda: endings.append(supervise(order, lambda _: told.set())))
    thread.start()
    try:
        assert told.wait(60)
        slot.dask_teardown(None)
        thread.join(60)
        assert endings[0].failure == "Left"
        assert endings[0].checkpoint == int(Path(str(order.checkpoint)).read_text())
    finally:
        supervisor.stop()
        thread.join(60)
        warm.dismiss()
    assert is_gone(pid_of(order))
