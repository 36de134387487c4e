"""Everything that can be set, in one frozen record: read once, passed down."""

import os
from pathlib import Path

from pydantic import Field, PositiveFloat, PositiveInt
from pydantic_settings import BaseSettings, SettingsConfigDict


def _available_cores() -> int:
    """Cores that this process may use (a container often allows fewer than the machine has)."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Settings(BaseSettings):
    """Settings of the service; each can be given as ``WHIPPLE_<NAME>`` in the environment."""

    model_config = SettingsConfigDict(env_prefix="WHIPPLE_", frozen=True, extra="forbid")

    data: Path = Field(Path("whipple-data"), description="directory of database and results")
    host: str = Field("127.0.0.1", description="address to listen on")
    port: int = Field(8000, ge=0, le=65535, description="port to listen on; 0 takes a free one")
    database_url: str | None = Field(None, description="SQLAlchemy URL; default: SQLite in data")
    scheduler: str | None = Field(
        None,
        pattern="^tls://",
        description="Dask scheduler; default: workers of our own",
    )
    workers: PositiveInt = Field(
        default_factory=_available_cores, description="runs computed at once by our own workers"
    )
    max_runs: PositiveInt = Field(10_000, description="most points that a sweep may have")
    run_seconds_limit: PositiveFloat = Field(
        7 * 24 * 3600.0,
        description="seconds after which a run or a publication is stopped",
    )
    poll_seconds: PositiveFloat = Field(
        0.5, description="how often the queue is looked at without a reason"
    )
    reconcile_seconds: PositiveFloat = Field(
        5.0, description="how often each running row is compared with the engine"
    )
    grace_seconds: PositiveFloat = Field(
        30.0, description="how long a running row may be unknown to a foreign engine"
    )
    targets_module: str | None = Field(
        None, description="module that stands in for studies.run and studies.publish (tests)"
    )

    @property
    def url(self) -> str:
        """The database's URL."""
        return self.database_url or f"sqlite:///{self.data.absolute() / 'whipple.db'}"
