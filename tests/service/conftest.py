"""Stores for tests: each test of the store runs on SQLite and on PostgreSQL."""

import logging
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from service.store import Store
from studies.sweeps import examples
from tests.service.support.api import Api, open_api, served
from tests.service.support.databases import Postgresql, postgresql_server
from tests.service.support.fakes import put_empty_store
from tests.service.support.harness import Harness, open_harness


@pytest.fixture(autouse=True)
def _loggers_as_before() -> Iterator[None]:
    """A service that a test starts in this process tells every logger where to write; the next one hears no more."""
    loggers = logging.getLogger(), logging.getLogger("service")
    before = [(one, one.handlers[:], one.level) for one in loggers]
    yield
    logging.captureWarnings(False)
    for one, handlers, level in before:
        one.handlers[:] = handlers
        one.setLevel(level)


@pytest.fixture(scope="session")
def postgresql() -> Iterator[Postgresql]:
    """A server of this session; started by the first test that asks for it."""
    with postgresql_server() as server:
        yield server


@pytest.fixture
def postgresql_url(postgresql: Postgresql) -> Iterator[str]:
    """A database of PostgreSQL with the tables of a store."""
    with postgresql.emptied() as url:
        yield url


@pytest.fixture
def sqlite_url(tmp_path: Path) -> str:
    """A file that will be a store."""
    return f"sqlite:///{tmp_path / 'whipple.db'}"


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """A database for one test, once of each kind."""
    if request.param == "sqlite":
        put_empty_store(tmp_path)
    return request.getfixturevalue(f"{request.param}_url")


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def module_url(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A database for all tests of a file, once of each kind."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path_factory.mktemp('store') / 'whipple.db'}"
        return
    with request.getfixturevalue("postgresql").database() as url:
        yield url


@pytest.fixture
def store(database_url: str) -> Iterator[Store]:
    """A store, once on each kind of database."""
    with closing(Store.open(database_url)) as opened:
        yield opened


@pytest.fixture
def smoke(tmp_path: Path) -> Path:
    """A file that asks for the smallest sweep."""
    file = tmp_path / "smoke.yaml"
    file.write_text(examples.text("smoke"))
    return file


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    """A dispatcher on SQLite whose ticks the test takes."""
    with open_harness(tmp_path) as opened:
        yield opened


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """The interface of a service without engine."""
    with open_api(tmp_path) as opened:
        yield opened


@pytest.fixture(scope="module")
def shared_api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    """The same for all tests of a file."""
    with open_api(tmp_path_factory.mktemp("shared")) as opened:
        yield opened


@pytest.fixture(scope="module")
def url(shared_api: Api) -> Iterator[str]:
    """The address at which it is served."""
    with served(shared_api) as address:
        yield address
