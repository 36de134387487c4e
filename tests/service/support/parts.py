"""What children that read sweeps do wrong; a child loads this module, which is cheap."""

import os
import signal

from service.api.reading import Posted


def burn(_: Posted) -> int:
    while True:
        pass


def fill(_: Posted) -> int:
    return len([bytes(1 << 20) for _ in range(4096)])


def die(_: Posted) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def freeze(_: Posted) -> int:
    os.kill(os.getpid(), signal.SIGSTOP)
    return 0


def pid(_: Posted) -> int:
    return os.getpid()
