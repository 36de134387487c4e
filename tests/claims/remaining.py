"""What a tree without a feature is tried with, in a process of its own: ``python -m tests.claims.remaining STEP``."""

import json
import math
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Mapping
from pathlib import Path

import whipple
from solver.steppers import methods
from studies import laws, measurements, scenarios
from studies.quantities.parameters import Plain

SWEEP: Mapping[str, Plain] = {
    "name": "small",
    "scenario": "thin_plate",
    "axes": {"speed": ["5 km/s", "6 km/s"]},
    "resolution": 8,
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
        "plate_radius": "20 mm",
        "end_time": "20 us",
    },
}
SECONDS = 300  # in which a service answers


def listed() -> str:
    """What there is of the kinds that features offer most of."""
    counts = (("methods", methods()), ("laws", laws.names()), ("measurements", measurements.names()))
    return f"{', '.join(f'{len(there)} {kind}' for kind, there in counts)}; scenarios {', '.join(scenarios.names())}"


def computed() -> str:
    """A sweep of two runs, with its cube and report."""
    folder = whipple.run_sweep(SWEEP, "small")
    cube = whipple.open_cube(Path(folder) / "cube.nc").to_dataset()
    assert cube["run_state"].values.tolist() == [0, 0]
    sections = json.loads((Path(folder) / "report.json").read_text(encoding="utf-8"))
    diameters = cube["hole_diameter"].values.tolist()
    assert all(map(math.isfinite, diameters))
    return f"{cube.sizes['speed']} runs, hole_diameter {diameters}, report with {len(sections)} keys"


def served() -> str:
    """The answer of a service that is started, and ended again."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "service", "serve", "--data", "served", "--port", str(port)]
    with subprocess.Popen(command) as service:
        try:
            for _ in range(SECONDS):
                assert service.poll() is None, "the service ended"
                try:
                    with urllib.request.urlopen(f"http://127.0.0.1:{port}/v1/sweeps", timeout=5.0) as answer:
                        assert b"next_cursor" in answer.read()
                        return f"status {answer.status}"
                except OSError:
                    time.sleep(1.0)
            raise AssertionError(f"no answer in {SECONDS} s")
        finally:
            service.send_signal(signal.SIGTERM)


STEPS = {step.__name__: step for step in (listed, computed, served)}

if __name__ == "__main__":
    print(STEPS[sys.argv[1]](), flush=True)
