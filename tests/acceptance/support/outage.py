"""A PostgreSQL server that can be stopped as a crash would, and started again."""

import os
import shlex
import signal
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from service.records.jobs import StoreUnavailable
from service.store import Store
from tests.acceptance.support.process_tree import MARK
from tests.service.support.databases import postgresql_server
from tests.service.support.fakes import is_gone, wait_until


@dataclass
class Outage:
    """The server of a database."""

    url: str
    folder: Path  # of its data

    def stop(self) -> None:
        """Stop at once, as in a crash."""
        pid = int((self.folder / "postmaster.pid").read_text().split()[0])
        os.kill(pid, signal.SIGQUIT)
        wait_until(lambda: is_gone(pid))

    def start(self) -> None:
        """Start with the options of the last time."""
        owner = self.folder.stat()
        command = shlex.split((self.folder / "postmaster.opts").read_text())
        environment = {name: value for name, value in os.environ.items() if name != MARK}
        is_other = owner.st_uid != os.getuid()
        subprocess.Popen(
            command,
            cwd="/",
            env=environment,  # outside the process tree of a crash test
            user=owner.st_uid if is_other else None,
            group=owner.st_gid if is_other else None,
            extra_groups=[] if is_other else None,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        wait_until(self._answers)

    def _answers(self) -> bool:
        try:
            with closing(Store.open(self.url, migrate=False)) as store:
                store.ping()
        except StoreUnavailable:
            return False
        return True


@contextmanager
def postgresql() -> Iterator[Outage]:
    """A server with a database, and the right to stop it."""
    with postgresql_server() as server, server.database() as url:
        engine = sa.create_engine(url, poolclass=sa.NullPool)
        with engine.connect() as connection:
            folder = connection.exec_driver_sql("SHOW data_directory").scalar_one()
        outage = Outage(url, Path(folder))
        try:
            yield outage
        finally:
            if not (outage.folder / "postmaster.pid").exists():
                outage.start()  # so that it can be ended in order
