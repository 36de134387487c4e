"""compose.yaml and Dockerfile: held against their schema and a linter, and the parts started as they are written.

Nothing here needs Docker: names of parts become the loopback, places inside a container become folders.
"""

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml

from service.client.client import Client
from service.settings import Settings
from tests.service.support.api import SWEEP
from tests.service.support.databases import Postgresql
from tests.service.support.processes import ROOT, ShellProcess, environment, free_port, patiently

FILE = ROOT / "compose.yaml"
DOCUMENT: Mapping[str, Any] = yaml.safe_load(FILE.read_text(encoding="utf-8"))
PARTS: Mapping[str, Mapping[str, Any]] = DOCUMENT["services"]
# A variable, with its default or why it must be set.
GIVEN = re.compile(r"\$\{(\w+):([-?])([^}]*)\}")


def test_schema__is_that_of_compose() -> None:
    command = ["-m", "check_jsonschema", "--builtin-schema", "vendor.compose-spec", str(FILE)]
    output = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)
    assert output.returncode == 0, output.stdout + output.stderr


def test_image__the_linter_finds_nothing() -> None:
    command = ["hadolint", "--no-color", str(ROOT / "Dockerfile")]
    output = subprocess.run(command, capture_output=True, text=True, check=False, env=environment())
    assert (output.returncode, output.stdout) == (0, "")


@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
def test_part__has_known_settings_waits_for_parts_writes_into_volumes_and_opens_the_loopback(part: Any) -> None:
    named = {name for name in part.get("environment", {}) if name.startswith("WHIPPLE_")}
    assert {name.removeprefix("WHIPPLE_").lower() for name in named} <= set(Settings.model_fields)
    assert set(part.get("depends_on", [])) <= set(PARTS)
    assert {volume.partition(":")[0] for volume in part["volumes"]} <= set(DOCUMENT["volumes"])
    published = ["127.0.0.1"] if part is PARTS["service"] else []
    assert [port.partition(":")[0] for port in part.get("ports", [])] == published


@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
def test_part__is_read_only_gains_no_privilege_and_has_no_secret_in_its_environment(part: Any) -> None:
    assert part["read_only"] is True
    assert part["cap_drop"] == ["ALL"]
    assert part["security_opt"] == ["no-new-privileges:true"]
    assert set(part.get("cap_add", [])) <= {"CHOWN", "DAC_OVERRIDE", "FOWNER", "SETGID", "SETUID"}
    given = {name: str(value) for name, value in part.get("environment", {}).items() if "PASSWORD" in name}
    assert all(name.endswith("_FILE") for name in given)
    assert {f"/run/secrets/{name}" for name in part.get("secrets", [])} == set(given.values())
    assert set(part.get("secrets", [])) <= set(DOCUMENT["secrets"])
    assert "/tmp" in part["tmpfs"]


def test_image__has_its_base_as_an_argument() -> None:
    """The base image of both stages is the build argument, and nothing else is taken from elsewhere."""
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines()
    bases = [line for line in lines if line.startswith(("ARG ", "FROM "))]
    default = bases[0].removeprefix("ARG BASE=")
    assert bases[1:] == ["FROM ${BASE} AS build", "FROM ${BASE}"]
    images = {part["build"]["args"]["BASE"] for part in PARTS.values() if "build" in part}
    assert [GIVEN.sub(r"\3", image) for image in images] == [default]


@dataclass
class Parts:
    """The parts of the file as processes, below a folder."""

    folder: Path
    database: str
    scheduler: int  # ports
    port: int

    def start(self, name: str) -> ShellProcess:
        part = PARTS[name]
        command = part.get("command", ["whipple", "serve"])
        return ShellProcess(self._words(command), self.folder, name, self._environment(part))

    def run(self, name: str, *command: str) -> str:
        """What a part says that runs another command, or its own, to its end."""
        part = PARTS[name]
        return subprocess.run(
            ["sh", "-euc", self._words(command or part["command"])],
            env={**environment(), **self._environment(part)},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=120,
        ).stdout

    def _environment(self, part: Mapping[str, Any]) -> dict[str, str]:
        value = {name: self._there(text) for name, text in part.get("environment", {}).items()}
        if "WHIPPLE_DATABASE_URL" in value:
            assert value["WHIPPLE_DATABASE_URL"].endswith("://whipple@database/whipple")
            value["WHIPPLE_DATABASE_URL"] = re.sub(r"://(\w+):[^@]*@", r"://\1@", self.database)
        more = {"WHIPPLE_PORT": str(self.port), "WHIPPLE_DATA": str(self.folder / "data")}
        return {**value, **more, "WHIPPLE_TARGETS_MODULE": "tests.service.support.targets"}

    def _words(self, command: Any) -> str:
        return shlex.join(self._there(word) for word in command)

    def _there(self, text: str) -> str:
        """A word of the file as a container would get it, with places and names of this machine."""
        text = GIVEN.sub(lambda match: match[3] if match[2] == "-" else "secret", text)
        text = text.replace("$$", "$").replace("scheduler:8786", f"127.0.0.1:{self.scheduler}")
        text = text.replace("--port=8786", f"--port={self.scheduler}")
        text = text.replace("chown ", "true ")  # there is no such user here
        return re.sub(r"(?<![\w.])/(run/secrets|tls|tmp)\b", rf"{self.folder}/\1", text)


@pytest.fixture
def parts(tmp_path: Path, postgresql: Postgresql) -> Iterator[Parts]:
    for name in ("tls", "tmp", "data", "run/secrets"):
        (tmp_path / name).mkdir(parents=True)
    for name in DOCUMENT["secrets"]:
        (tmp_path / "run" / "secrets" / name).write_text("se:cret@/\n")
    with postgresql.database() as url:
        yield Parts(tmp_path, url, free_port(), free_port())


@pytest.mark.claim("queue", "compose", minutes=0.2)
def test_parts__started_as_they_are_written_compute_a_sweep_for_who_has_a_key(parts: Parts) -> None:
    """The parts of compose.yaml, started as it is written, compute a sweep for who has a key."""
    parts.run("certificates")
    before = (parts.folder / "tls" / "cert.pem").read_bytes()
    parts.run("certificates")  # at every start
    assert (parts.folder / "tls" / "cert.pem").read_bytes() == before
    key = parts.run("service", "whipple", "keys", "create", "anna").strip()
    url = f"http://127.0.0.1:{parts.port}"
    with ExitStack() as ends:
        for name in ("scheduler", "worker", "service"):
            ends.callback(parts.start(name).kill)
        patiently(lambda: _status(f"{url}/readyz") == 200)
        assert _status(f"{url}/v1/sweeps") == 401
        with Client(url, key=key) as client:
            sweep = client.submit(json.loads(json.dumps(SWEEP)))
            assert sweep.wait().state == "succeeded"


def _status(url: str) -> int | None:
    try:
        return httpx.get(url, timeout=30).status_code
    except httpx.TransportError:
        return None
