"""What may be loaded where: the import rules that only a running interpreter can show."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ELSEWHERE = ("xarray", "netCDF4", "pandas", "matplotlib", "dask", "distributed", "pint")
HEAVY = ("numba", "llvmlite", "scipy", *ELSEWHERE)


def test_import__of_a_package_is_cheap() -> None:
    assert not loaded_by("import solver", "import studies", "import service", "import whipple", suspects=HEAVY)


def test_import__of_the_worker_loads_neither_web_nor_store_and_to_compute_no_datasets_and_no_units() -> None:
    web = ("fastapi", "starlette", "sqlalchemy")
    code = ("import service.workers.warm_process", "import studies.runs.execution")
    assert not loaded_by(*code, suspects=(*web, *ELSEWHERE))


def test_whipple__offers_the_public_names_and_no_more() -> None:
    import whipple

    offered = "Client InvalidInput estimate flag_words laws materials open_cube open_film run_sweep shots"
    assert dir(whipple) == offered.split()
    assert whipple.__version__.count(".") == 2
    assert issubclass(whipple.InvalidInput, Exception)
    with pytest.raises(AttributeError, match="open_cube"):
        whipple.open_qube  # noqa: B018


def loaded_by(*code: str, suspects: tuple[str, ...]) -> dict[str, str]:
    """Which of the suspects a fresh interpreter has loaded, each with the first piece of code after which it had."""
    report = f"print('loaded', *set({suspects!r}) & set(sys.modules))"
    program = "\n".join(["import sys", *(line for piece in code for line in (piece, report))])
    answer = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    reports = [line.split()[1:] for line in answer.stdout.splitlines() if line.startswith("loaded")]
    assert len(reports) == len(code)
    return {name: piece for piece, loaded in reversed([*zip(code, reports, strict=True)]) for name in loaded}


def test_import__beside_a_clone_finds_the_package_and_not_the_folder(tmp_path: Path) -> None:
    """A folder named like the project, or like one of its packages, is no package where a script lies beside it."""
    for name in ("whipple", "service", "studies", "solver"):
        (tmp_path / name / ".git").mkdir(parents=True)
    script = tmp_path / "script.py"
    script.write_text("import service, solver, studies, whipple; print(whipple.run_sweep.__name__, studies.__file__)")
    for command in ([script.name], ["-c", script.read_text()]):
        ran = subprocess.run([sys.executable, *command], cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert ran.returncode == 0, ran.stderr
        assert ran.stdout.startswith("run_sweep ")
