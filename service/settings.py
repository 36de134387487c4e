"""Settings, in one frozen record that is read once and passed down."""

import json
import os
from collections.abc import Iterable
from ipaddress import IPv4Network, IPv6Network, ip_network
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import quote

from pydantic import ByteSize, Field, PositiveFloat, PositiveInt, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from solver.registry import points
from solver.steps.threads import AUTO, available_cores

GIBIBYTE = 1 << 30
LEAVE_SECONDS, LONGEST_LEAVE = 6.0, 8.0  # closing takes a while too; a stop is over within ten
CONTROL_GROUP = Path("/sys/fs/cgroup/memory.max")  # what a container may use
DATABASES = ("sqlite", "postgresql")

Network = IPv4Network | IPv6Network


def _available_memory() -> int:
    """Bytes of memory that this process may use."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    try:
        return min(machine, int(CONTROL_GROUP.read_text()))
    except (OSError, ValueError):  # no such group, or "max"
        return machine


def _refused(limit: str) -> PydanticCustomError:
    """The error of a refused setting, with the allowed values."""
    return PydanticCustomError("setting", "{limit}", {"limit": limit})


def _check_scheme(group: str, kind: str, address: str) -> None:
    """Refuse an address whose scheme no entry point of a group serves."""
    scheme = address.partition("://")[0]
    schemes = sorted({point.name for point in points(group)})
    if scheme not in schemes:
        known = ", ".join(f"{name}://" for name in schemes) or "none"
        raise _refused(f"an address of an installed {kind}: no {kind} serves {scheme}://; there are: {known}")


class Settings(BaseSettings):
    """Settings of the service; each can be given as ``WHIPPLE_<NAME>`` in the environment."""

    model_config = SettingsConfigDict(env_prefix="WHIPPLE_", frozen=True, extra="forbid", validate_default=True)

    data: Path = Field(default=Path("whipple-data"), description="database and results")
    host: str = Field(default="127.0.0.1", description="address to listen on")
    port: int = Field(default=8000, ge=0, le=65535, description="port to listen on; 0 selects a free port")
    trusted_proxy: Annotated[tuple[Network, ...], NoDecode] = Field(
        default=(), description="addresses or networks of proxies that authenticate requests, as a JSON list"
    )
    allowed_hosts: tuple[str, ...] = Field(
        default=(), description="names under which such a proxy is reached, as a JSON list"
    )
    trust_loopback: bool = Field(
        default=True, description="whether every user of this machine may give orders without a key"
    )
    database_url: str | None = Field(
        default=None, description="default: SQLite inside data; postgresql+psycopg://... allows several services"
    )
    database_password_file: Path | None = Field(
        default=None, description="file with the password of a database_url that names a user alone"
    )
    artifacts: str | None = Field(
        default=None,
        description="bucket for the files, s3://bucket/prefix or another URL of fsspec; default: data alone",
    )
    artifacts_cache: ByteSize = Field(
        default=ByteSize(1 << 40), ge=0, description="size of the files in data that are in the bucket too"
    )
    artifacts_links: int = Field(
        default=0, ge=0, le=7 * 24 * 3600, description="seconds for which a link to the bucket is valid; 0: no links"
    )
    engine: str | None = Field(default=None, description="tls://host:port of a Dask scheduler; default: this machine")
    tls_ca: Path | None = Field(default=None, description="PEM file of the certificate authority of the scheduler")
    tls_cert: Path | None = Field(default=None, description="PEM file of the certificate of this service")
    tls_key: Path | None = Field(default=None, description="PEM file of the key of this certificate")
    workers: PositiveInt = Field(
        default_factory=available_cores, description="number of runs that this service computes at once"
    )
    threads: PositiveInt | None = Field(
        default=None, description="threads of a run: a number, or auto, which shares out the cores of idle workers"
    )
    max_runs: PositiveInt = Field(default=10_000, description="most points that a sweep may have")
    # Of each owner; keys with the scope ``admin``, and users of this machine, have none.
    quota_sweeps: PositiveInt = Field(default=200, description="sweeps that one owner may have under way")
    quota_runs: PositiveInt = Field(default=200_000, description="runs that one owner may have under way")
    quota_bytes: ByteSize = Field(default=ByteSize(2 << 40), gt=0, description="size of the files of one owner")
    quota_requests: PositiveInt = Field(default=6_000, description="requests a minute of one owner")
    most_kept: Literal["numbers", "final", "film"] = Field(
        default="film", description="most files of a run that a key without admin may keep"
    )
    run_seconds_limit: PositiveFloat = Field(
        default=7 * 24 * 3600.0, description="largest wall time of a run or a publication, in seconds"
    )
    stall_seconds: PositiveFloat = Field(
        default=60.0,
        description="seconds without progress, and ten times the longest interval of the run until then, "
        "after which it is ended and begun again from its checkpoint",
    )
    memory_limit: ByteSize | None = Field(
        default=None,
        gt=0,
        description="memory of a run, such as 4GiB; default: this machine's, divided by workers; "
        "required with an engine",
    )
    disk_reserve: ByteSize = Field(
        default=ByteSize(GIBIBYTE), ge=0, description="free disk space below which no run starts"
    )
    leave_seconds: float = Field(
        default=LEAVE_SECONDS,
        ge=0,
        le=LONGEST_LEAVE,
        description="seconds for runs to write a checkpoint when the service stops",
    )
    retire_seconds: PositiveFloat = Field(
        default=24 * 3600.0, description="age at which files of lost attempts are removed"
    )
    forget_seconds: PositiveFloat = Field(
        default=30 * 24 * 3600.0, description="seconds after which runs that belong only to deleted sweeps are removed"
    )
    retention_days: float = Field(
        default=0.0, ge=0, description="days after their end at which sweeps that are not pinned are deleted; 0: never"
    )
    scrub_rate: ByteSize = Field(
        default=ByteSize(2_000_000),
        ge=0,
        description="bytes a second of stored files that are read and compared with their digests; 0: never",
    )
    poll_seconds: PositiveFloat = Field(default=0.5, description="seconds between two regular checks of the queue")
    reconcile_seconds: PositiveFloat = Field(
        default=5.0, description="seconds between two comparisons of the running jobs with the engine"
    )
    targets_module: str | None = Field(
        default=None, description="module that replaces studies.runs.execution and studies.reports.publish in tests"
    )

    @field_validator("trusted_proxy", mode="before")
    @classmethod
    def _is_list_of_addresses(cls, value: "str | Iterable[Network | str]") -> tuple[Network, ...]:
        """Proxies are trusted by their addresses."""
        try:
            places = json.loads(value) if isinstance(value, str) else value
            return tuple(ip_network(str(place)) for place in places)
        except (TypeError, ValueError):
            raise _refused(
                'a JSON list of the addresses or networks of the proxy, such as ["127.0.0.1", "10.0.3.0/24"]'
            ) from None

    @field_validator("threads", mode="before")
    @classmethod
    def _is_number_or_auto(cls, value: str | int | None) -> str | int | None:
        if value == AUTO:
            return None
        if isinstance(value, str) and not (value.isascii() and value.isdigit() and int(value)):
            raise _refused("a number of 1 or more, or auto")
        return value

    @field_validator("database_url")
    @classmethod
    def _is_known_database(cls, url: str | None) -> str | None:
        if url is not None and url.partition(":")[0].partition("+")[0] not in DATABASES:
            raise _refused(f"a URL of one of these: {', '.join(DATABASES)}")
        return url

    @field_validator("database_password_file")
    @classmethod
    def _is_readable(cls, file: Path | None, context: ValidationInfo) -> Path | None:
        url = context.data.get("database_url")
        if file is None or url is None:
            return file
        user, at, _ = url.partition("://")[2].partition("@")
        if not at or ":" in user:
            raise _refused(
                "unset, unless database_url names a user without a password: postgresql+psycopg://user@host/name"
            )
        if not os.access(file, os.R_OK) or not file.is_file():
            raise _refused("a file that this user may read")
        return file

    @field_validator("engine")
    @classmethod
    def _is_served(cls, address: str | None) -> str | None:
        if address is None:
            return None
        _check_scheme("service.execution.engines", "engine", address)
        host, _, port = address.partition("://")[2].rpartition(":")
        if not host or not port.isdigit():
            raise _refused("an address such as tls://scheduler.example.org:8786")
        return address

    @field_validator("artifacts")
    @classmethod
    def _is_known_store(cls, url: str | None) -> str | None:
        if url is not None:
            _check_scheme("service.files.stores", "store of files", url)
        return url

    @field_validator("tls_ca", "tls_cert", "tls_key", "memory_limit")
    @classmethod
    def _is_there_for_the_engine(cls, value: Path | ByteSize | None, context: ValidationInfo) -> Path | ByteSize | None:
        """Require certificates with an engine, and a limit, as the service cannot measure other machines' memory."""
        engine = context.data.get("engine")
        if engine is not None and value is None:
            of_file = f"a PEM file, which the engine at {engine} requires"
            of_memory = "the memory that one run may use on a worker of the engine, such as 4GiB"
            raise _refused(of_memory if context.field_name == "memory_limit" else of_file)
        if isinstance(value, Path) and not value.is_file():
            raise _refused("a file that exists")
        return value

    @property
    def url(self) -> str:
        if self.database_url is None:
            return f"sqlite:///{self.data.absolute() / 'whipple.db'}"
        if self.database_password_file is None:
            return self.database_url
        password = quote(self.database_password_file.read_text(encoding="utf-8").strip(), safe="")
        return self.database_url.replace("@", f":{password}@", 1)

    @property
    def has_replicas(self) -> bool:
        """Whether several services may share database and data directory."""
        return not self.url.startswith("sqlite")

    def threads_of_a_run(self, *, workers: int, runs: int) -> int:
        """Number of threads of a run that starts as the last of several: it also uses the cores of idle workers.

        A later run does not find them free; it then takes longer, as they all do, by the price of the threads
        (``solver.steps.threads``). Workers of an engine run on machines with an unknown number of cores.
        """
        if self.threads is not None:
            return self.threads
        return 1 if self.engine is not None else max(1, workers // runs)

    @property
    def memory_of_a_run(self) -> int:
        """Bytes that a run may use."""
        return self.memory_limit or _available_memory() // self.workers
