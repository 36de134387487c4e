"""Several services that share a database and a folder."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from service.store import Store
from tests.acceptance.support.crash_test import Work
from tests.acceptance.support.process_tree import ProcessTree, process_tree
from tests.acceptance.support.serving import Service
from tests.service.support.fakes import wait_until

END_SECONDS = 240.0


@dataclass
class Services:
    """The services, their processes and their store."""

    services: list[Service]
    tree: ProcessTree
    store: Store

    def wait_for_the_end(self, ids: list[str]) -> None:
        """Wait until these sweeps have ended."""
        wait_until(lambda: all(self.store.sweep(id).is_terminal for id in ids), seconds=END_SECONDS)

    def leads(self, service: Service) -> bool:
        """Whether the store names a service as the leader."""
        assert service.process is not None
        return (self.store.queue().leader or "").endswith(f":{service.process.pid}")

    def leave(self) -> set[int]:
        """Ask all services to leave; the processes that are left."""
        for service in self.services:
            if service.is_alive():
                assert service.leave() == 0, service.log_tail()
        return self.tree.left()


@contextmanager
def sharing(place: Path, database_url: str, work: Work, count: int, **environment: str) -> Iterator[Services]:
    """So many services, until the end of the block."""
    with ExitStack() as ends:
        tree = ends.enter_context(process_tree())
        variables = {**work.environment(), "WHIPPLE_DATABASE_URL": database_url, **environment}
        services = [Service(place / "data", variables, name=f"{n}") for n in range(count)]
        for service in services:
            ends.callback(service.kill)
            service.start()
            service.wait_until_ready()
        store = ends.enter_context(closing(Store.open(database_url, migrate=False)))
        yield Services(services, tree, store)
