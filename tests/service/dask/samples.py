"""What clusters of Dask offer to the tests of all engines."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from service.records.jobs import Cause
from service.workers.timings import Timings
from tests.service.dask.cluster import running, serving
from tests.service.support.attempts import Place
from tests.service.support.processes import parent_of


@contextmanager
def place(folder: Path, workers: int, timings: Timings) -> Iterator[Place]:
    """A cluster in a folder, whose workers have parents that live on when an attempt dies."""
    with running(folder, workers) as cluster:

        def foreign() -> set[int]:
            return {pid for process in cluster.processes for pid in process.look()}

        yield Place(partial(serving, cluster.remote(), timings), parent_of, Cause.LOST, foreign)


ENGINES = {"dask": place}
CLUSTERS = {"dask": running}
