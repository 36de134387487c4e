"""Named places where a process can be made to die, so that a test can check what is left behind.

``fault_point("...")`` does nothing, unless the environment variable ``WHIPPLE_FAULT`` has that name: then
the process kills itself as ``kill -9`` would, before the next line is reached.
"""

import os
import signal

VARIABLE = "WHIPPLE_FAULT"

# In the order in which a sweep meets them.
POINTS = (
    "submission-before-commit",  # every row of a sweep is written, none is there
    "submission-after-commit",  # it is accepted, and the response is not sent
    "claim-after-commit",  # rows say running, the engine has not heard of it
    "claim-after-submit",  # the engine computes, and the dispatcher dies
    "result-before-registration",  # files are complete, no row names them
    "result-before-commit",  # the row names them, in a transaction that is not over
    "result-after-commit",  # registered; its checkpoint is still there
    "publication-before-registration",  # cube and report are complete, no row names them
    "publication-before-commit",
    "publication-after-commit",
    "copy-halfway",  # a sweep without a service: the first of its files is copied out
)


def fault_point(name: str) -> None:
    """Die here, if the environment names this point."""
    assert name in POINTS, name
    if os.environ.get(VARIABLE) == name:
        os.kill(os.getpid(), signal.SIGKILL)
