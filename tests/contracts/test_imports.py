"""What may be loaded where: the import rules that only a running interpreter can show."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ELSEWHERE = ("xarray", "netCDF4", "pandas", "matplotlib", "dask", "distributed", "pint")
HEAVY = ("numba", "llvmlite", "scipy", *ELSEWHERE)
NEVER_IN_THE_API_PROCESS = ("numba", "llvmlite", "xarray", "netCDF4", "distributed")
SOLVER_MAY_IMPORT = {"numpy", "scipy", "solver"}
COMPILING = {ROOT / "solver" / "jit.py", *(ROOT / "solver" / "vectors").glob("*.py")}
COMPILING_MAY_IMPORT = {*SOLVER_MAY_IMPORT, "numba", "llvmlite"}


def test_import__of_a_package_is_cheap() -> None:
    assert not _loaded_by("import solver", "import studies", "import service", "import whipple", suspects=HEAVY)


def test_import__of_what_the_api_process_uses_loads_no_solver_and_no_datasets() -> None:
    modules = (
        "service.api.app",
        "service.cli.local",
        "service.execution.local",
        "service.queue.dispatcher",
        "service.cli.serve",
        "studies.laws",
        "studies.materials",
        "studies.runs.run",
        "studies.scenarios",
        "studies.sweeps.sweep",
    )
    catalogues = (f"import {name} as kind; assert kind.names()" for name in ("studies.scenarios", "studies.materials"))
    code = (*(f"import {module}" for module in modules), *catalogues)
    assert not _loaded_by(*code, suspects=NEVER_IN_THE_API_PROCESS)


def test_import__of_the_worker_loads_neither_web_nor_store_and_to_compute_no_datasets_and_no_units() -> None:
    web = ("fastapi", "starlette", "sqlalchemy")
    code = ("import service.workers.warm_process", "import studies.runs.execution")
    assert not _loaded_by(*code, suspects=(*web, *ELSEWHERE))


@pytest.mark.parametrize("file", sorted((ROOT / "solver").rglob("*.py")), ids=lambda file: str(file.relative_to(ROOT)))
def test_solver__imports_arrays_and_the_standard_library_only(file: Path) -> None:
    allowed = COMPILING_MAY_IMPORT if file in COMPILING else SOLVER_MAY_IMPORT
    assert _imported_by(file) - set(sys.stdlib_module_names) <= allowed


def test_whipple__offers_the_public_names_and_no_more() -> None:
    import whipple

    assert dir(whipple) == ["Client", "flag_words", "open_cube", "open_film", "run_sweep"]
    with pytest.raises(AttributeError, match="open_cube"):
        whipple.open_qube  # noqa: B018


def _loaded_by(*code: str, suspects: tuple[str, ...]) -> dict[str, str]:
    """Which of the suspects a fresh interpreter has loaded, each with the first piece of code after which it had."""
    report = f"print('loaded', *set({suspects!r}) & set(sys.modules))"
    program = "\n".join(["import sys", *(line for piece in code for line in (piece, report))])
    answer = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    reports = [line.split()[1:] for line in answer.stdout.splitlines() if line.startswith("loaded")]
    assert len(reports) == len(code)
    return {name: piece for piece, loaded in reversed([*zip(code, reports, strict=True)]) for name in loaded}


def _imported_by(file: Path) -> set[str]:
    """The top-level names that a file imports, at any depth of its text."""
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module.partition(".")[0])
    return names
