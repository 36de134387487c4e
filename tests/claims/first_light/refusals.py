"""Bad input gets a clear answer and loses nothing, over HTTP and on the command line."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tests.claims import Row, claim
from tests.service.support.api import SWEEP, open_api

FIXED = SWEEP["fixed"]
BAD: Mapping[str, tuple[Mapping[str, Any], str, str]] = {  # document, field, a word of the cure or limit
    "unknown scenario": ({**SWEEP, "scenario": "thin_plat"}, "scenario", "thin_plate"),
    "unknown material": ({**SWEEP, "fixed": {**FIXED, "target": "coper-ofhc"}}, "fixed.target", "copper-ofhc"),
    "unknown parameter": (
        {**SWEEP, "fixed": {**FIXED, "plate_thicknes": "2 mm"}},
        "fixed.plate_thicknes",
        "plate_thickness",
    ),
    "wrong unit": ({**SWEEP, "fixed": {**FIXED, "plate_thickness": "2 kg"}}, "fixed.plate_thickness", "mm"),
    "no unit": ({**SWEEP, "axes": {"speed": [3, 6]}}, "axes.speed[0]", "km/s"),
    "negative": ({**SWEEP, "axes": {"speed": ["-3 km/s"]}}, "axes.speed[0]", "km/s"),
    "NaN": ({**SWEEP, "axes": {"speed": ["nan km/s"]}}, "axes.speed[0]", "km/s"),
    "empty axis": ({**SWEEP, "axes": {"speed": []}}, "axes.speed", "value"),
    "over the cap": (
        {**SWEEP, "axes": {"speed": {"start": "2 km/s", "stop": "7 km/s", "step": "0.01 m/s"}}},
        "axes.speed",
        "000",
    ),
}
MALFORMED = {"application/json": '{"name": "x", ', "application/yaml": "name: [x\naxes: }"}


@claim("bad-input-http", says="bad input over HTTP is a 422 that names field, value, limit and cure", quick=True)
def over_http() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder, open_api(Path(folder)) as api:
        for what, (document, field, word) in BAD.items():
            answer = api.http.post("/v1/sweeps", json=document)
            yield Row(f"{what}: {_said(answer.json())}", f"422 at {field}", *_judged(answer, field, word))
        for kind, text in MALFORMED.items():
            answer = api.http.post("/v1/sweeps", content=text, headers={"Content-Type": kind})
            yield Row(
                f"malformed {kind}: {answer.json()['detail']}", 422, answer.status_code, answer.status_code == 422
            )
        kept = len(api.store.sweeps().items)
        yield Row("sweeps stored by what was refused", 0, kept, kept == 0)


@claim("bad-input-command", says="bad input on the command line is exit 2 with field, value, limit and cure")
def on_the_command_line() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        for what, (document, field, word) in BAD.items():
            status, output = _command(Path(folder), json.dumps(document))
            passed = status == 2 and field in output and word in output and "Traceback" not in output
            yield Row(f"{what}: {' '.join(output.split())[:160]}", f"2 at {field}", status, passed)
        status, output = _command(Path(folder), MALFORMED["application/yaml"])
        yield Row(f"malformed YAML: {' '.join(output.split())[:160]}", 2, status, status == 2)


def _judged(answer: Any, field: str, word: str) -> tuple[str, bool]:
    body = answer.json()
    errors = [error for error in body.get("errors", []) if error["field"] == field]
    complete = all(error[part] for error in errors for part in ("value", "limit", "cure"))
    named = any(word in error["limit"] + error["cure"] for error in errors)
    return f"{answer.status_code} at {[error['field'] for error in body.get('errors', [])]}", bool(
        answer.status_code == 422 and errors and complete and named
    )


def _said(body: Mapping[str, Any]) -> str:
    return "; ".join(f"{error['value']} | {error['limit']} | {error['cure']}" for error in body.get("errors", []))[:200]


def _command(folder: Path, text: str) -> tuple[int, str]:
    file = folder / "sweep.yaml"
    file.write_text(text)
    ran = subprocess.run(
        [sys.executable, "-m", "service", "sweep", str(file), "--out", str(folder / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    return ran.returncode, ran.stderr
