"""Ctrl-C and SIGTERM are never lost, and a process that hangs ends all the same."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from service.cli.signals import ASKS, KILLED_BY, handling_end_signals

ROOT = Path(__file__).parents[3]
WAKE_SECONDS = 30.0  # far more than a busy machine needs, far less than the test waits


def interrupt() -> None:
    """Ctrl-C, to this process, here and now."""
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0)  # an opportunity to run the handler


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    before = {one: signal.getsignal(one) for one in ASKS}
    yield
    assert {one: signal.getsignal(one) for one in ASKS} == before


def test_raise_if_requested__raises_what_ends_a_program() -> None:
    with handling_end_signals() as leaving:
        leaving.raise_if_requested()
        interrupt()
        with pytest.raises(KeyboardInterrupt):
            leaving.raise_if_requested(wait=WAKE_SECONDS)
    with handling_end_signals() as leaving:
        os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(SystemExit) as ended:
            leaving.raise_if_requested(wait=WAKE_SECONDS)
    assert ended.value.code == KILLED_BY + signal.SIGTERM


HANGS = (
    "import sys, time, threading; from service.cli.signals import handling_end_signals\n"
    "with handling_end_signals(end_within={seconds}) as leaving:\n"
    "    print('ready', flush=True)\n"
    "    leaving.asked(wait=600)\n"
    "    {then}\n"
    "print('left')\n"
)


@pytest.mark.parametrize(("seconds", "then", "said"), [(0.2, "threading.Event().wait()", ""), (600, "pass", "left\n")])
def test_end_within__ends_a_process_that_hangs_and_no_other(seconds: float, then: str, said: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", HANGS.format(seconds=seconds, then=then)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.terminate()
    assert process.communicate()[0] == said
    assert process.returncode == 0


def test_ignored__stays_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with handling_end_signals() as leaving:
            interrupt()
            assert leaving.asked() is None
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
