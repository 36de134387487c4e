"""Named places where a process can be made to die, so that a test can check what is left behind.

A process whose environment names one of POINTS in VARIABLE kills itself there as ``kill -9`` would, once it has called
``arm``. ``python -m tests.service.support.fault_points serve ...`` is ``whipple serve``, armed.
"""

import os
import signal
from collections.abc import Callable
from functools import wraps
from typing import Any

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
    # With a bucket:
    "object-before-upload",  # the files of an attempt are complete, the bucket has none of them
    "object-after-upload",  # it has the first of them, and no row names it
)


def arm() -> None:
    """Let this process die at the point that its environment names, if it names one."""
    point = os.environ.get(VARIABLE)
    if point is None:
        return
    from service.files.artifacts import Artifacts
    from service.queue.leader import Leader
    from service.store import leases, sweeps

    def always(*_: Any) -> bool:
        return True

    places: dict[str, tuple[Any, str, Callable[..., bool]]] = {
        "submission-before-commit": (sweeps, "accept", always),
        "submission-after-commit": (sweeps.Sweeps, "create", always),
        "claim-after-commit": (leases.Leases, "take", lambda answer, *_: bool(answer)),
        "claim-after-submit": (Leader, "_begin", always),
        "result-before-registration": (leases.Leases, "finish", always),
        "result-before-commit": (leases, "log_attempts", _logs("succeeded")),
        "result-after-commit": (leases.Leases, "finish", always),
        "publication-before-registration": (leases.Leases, "publish", always),
        "publication-before-commit": (leases, "log_attempts", _logs("published")),
        "publication-after-commit": (leases.Leases, "publish", always),
        "copy-halfway": (Artifacts, "copy_out", always),
    }
    if point.startswith("object"):
        from service.bucket.bucket import ObjectBucket

        places[point] = (ObjectBucket, "put", always)
    owner, name, dies = places[point]
    call = getattr(owner, name)

    @wraps(call)
    def armed(*arguments: Any, **options: Any) -> Any:
        answer = None if point.endswith(("before-registration", "before-upload")) else call(*arguments, **options)
        if dies(answer, *arguments):
            os.kill(os.getpid(), signal.SIGKILL)
        return answer

    setattr(owner, name, armed)


def _logs(kind: str) -> Callable[..., bool]:
    """Whether an event of this kind was logged."""
    return lambda _answer, _connection, _moment, logged, *_: bool(logged == kind)


def main() -> None:
    """Arm the process, then start the command."""
    arm()
    from service.cli import main as cli

    cli.main()


if __name__ == "__main__":
    main()
