"""What a service says that has no library for its engine."""

import sys
from pathlib import Path

import pytest

from service.execution import engine_of, probe
from service.settings import Settings
from studies.quantities.findings import MissingExtra


def test_engine__of_a_cluster_without_its_libraries_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pem = tmp_path / "any.pem"
    pem.touch()
    files = dict.fromkeys(("tls_ca", "tls_cert", "tls_key"), pem)
    settings = Settings(engine="tls://127.0.0.1:8786", memory_limit=1 << 30, **files)  # type: ignore[arg-type]
    monkeypatch.delitem(sys.modules, "service.dask.engine", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    for ask in (engine_of, probe):
        with pytest.raises(MissingExtra, match=r"tls://.*distributed.*'whipple\[cluster\]'"):
            ask(settings)
