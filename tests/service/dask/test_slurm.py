"""Workers as jobs of Slurm, by the program of docs/cluster.md."""

import os
from pathlib import Path

import pytest

from tests.service.dask.cluster import DaskCluster, documented, serving
from tests.service.support.attempts import attempt_in
from tests.service.support.processes import ShellProcess, environment, patiently

# Stand in for Slurm: a job is a process in the background.
SBATCH = """#!/bin/sh
cp "$1" job.sh
setsid sh job.sh >job.log 2>&1 &
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
kill "$1" 2>/dev/null
"""


@pytest.mark.claim("docs", "slurm", minutes=0.2)
def test_slurm__the_documented_program_starts_workers_that_get_work(tmp_path: Path) -> None:
    """The program of docs/cluster.md starts workers as jobs of Slurm, and they get work."""
    pytest.importorskip("dask_jobqueue", reason="the extra cluster is not installed")
    cluster = DaskCluster(tmp_path)
    cluster.certify()
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    program = documented("cluster = SLURMCluster(", "python")
    program = program.replace("8786", str(cluster.port)).replace("JOBS = 10", "JOBS = 1")
    (tmp_path / "cluster.py").write_text(program.replace("cores=4", "cores=2").replace("processes=4", "processes=2"))
    path = os.pathsep.join([str(tmp_path), environment()["PATH"]])
    process = ShellProcess("python cluster.py", tmp_path, "slurm", {"PATH": path})
    cluster.processes.append(process)
    job = tmp_path / "job.log"
    try:
        with serving(cluster.remote()) as user:
            user.wait_for_slots(2)
            assert user.compute(attempt_in(tmp_path))[0].cause is None
    finally:
        process.kill()
        cluster.end()
    patiently(lambda: "End worker" in job.read_text())
