"""The package is found from wherever a program starts."""

import subprocess
import sys
from pathlib import Path


def test_import__beside_a_clone_finds_the_package_and_not_the_folder(tmp_path: Path) -> None:
    """A folder named like the project, or like one of its packages, is no package where a script lies beside it."""
    for name in ("whipple", "service", "studies", "solver"):
        (tmp_path / name / ".git").mkdir(parents=True)
    script = tmp_path / "script.py"
    script.write_text("import service, solver, studies, whipple; print(whipple.Client.__name__, studies.__file__)")
    for command in ([script.name], ["-c", script.read_text()]):
        ran = subprocess.run([sys.executable, *command], cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert ran.returncode == 0, ran.stderr
        assert ran.stdout.startswith("Client ")
