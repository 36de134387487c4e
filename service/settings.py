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

    data: Path = Field(default=Path("whipple-data"), description="database and results")
    host: str = Field(default="127.0.0.1", description="address to listen on")
    port: int = Field(default=8000, ge=0, le=65535, description="0 takes a free one")
    trusted_proxy: bool = Field(
        default=False, description="a proxy in front of the service checks who is asking"
    )
    allowed_hosts: tuple[str, ...] = Field(
        default=(), description="names under which that proxy is reached, as a JSON list"
    )
    database_url: str | None = Field(default=None, description="default: SQLite inside data")
    workers: PositiveInt = Field(
        default_factory=_available_cores, description="runs computed at once"
    )
    max_runs: PositiveInt = Field(default=10_000, description="most points that a sweep may have")
    run_seconds_limit: PositiveFloat = Field(
        default=7 * 24 * 3600.0, description="wall clock of a run, or a publication"
    )
    poll_seconds: PositiveFloat = Field(
        default=0.5, description="between two looks at the queue without a reason"
    )
    reconcile_seconds: PositiveFloat = Field(
        default=5.0, description="between two comparisons of the running rows with the engine"
    )
    targets_module: str | None = Field(
        default=None, description="stands in for studies.run and studies.publish (tests)"
    )

    @property
    def url(self) -> str:
        """The database's URL."""
        return self.database_url or f"sqlite:///{self.data.absolute() / 'whipple.db'}"
