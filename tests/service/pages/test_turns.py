"""Pages that wait for a child process leave the turns to others."""

import httpx
import pytest

from service.pages.pages.catalogue import DRAWN
from tests.service.api.test_turns import check_that_waiting_leaves_turns, strict
from tests.service.support.api import Api

__all__ = ["strict"]


@pytest.mark.parametrize("path", ["/new/thin_plate", "/materials/al-6061-t6"])
def test_pages__that_wait_for_a_child_leave_the_others_their_turns(
    strict: tuple[Api, str, httpx.Client], path: str
) -> None:
    DRAWN.clear()  # by other tests
    check_that_waiting_leaves_turns(*strict, path)
