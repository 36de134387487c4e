"""The files of a run and of a sweep: their names, and writing that leaves a whole file or none."""

import os
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

RESULT = "result.json"  # measurements of a run, or the reason of its failure
STATE = "state.npz"  # its final state
FILM = "film.npz"  # its frames
MOST_FRAMES = 1000  # of them
SECTIONS = "sections.npz"  # its section at a few times, for the pictures of reports
SECTION_NOW = "section-now.npz"  # the last section of a running run
CUBE, RUNS_CSV, REPORT_HTML, REPORT_JSON = "cube.nc", "runs.csv", "report.html", "report.json"
APPENDIX_HTML = "appendix.html"  # what report.html links
SWEEP_FILES = (CUBE, RUNS_CSV, REPORT_HTML, APPENDIX_HTML, REPORT_JSON)
ARCHIVE, DIGESTS = "archive.zip", "SHA256SUMS"  # all files of a sweep, and in it the digests of the others
ZARR = "cube.zarr.zip"
VTK = "vtk.zip"  # film and final state of a run for other programs
COVER = "cover.zip"  # what lists and pages of the service show of a report
ALL_RUNS_CSV = "runs-all.csv"  # every column of the runs, offered in place of RUNS_CSV

READABLE_BY_ALL = 0o644  # mkstemp makes private files; results are for others too


def write_atomically(path: Path, fill: Callable[[Path], object]) -> Path:
    """Let ``fill`` write a temporary file beside ``path``, sync it, and give it its name."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    os.close(handle)
    temporary = Path(name)
    try:
        fill(temporary)
        temporary.chmod(READABLE_BY_ALL)
        to_disk(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    to_disk(path.parent)
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text file atomically, as UTF-8."""
    return write_atomically(path, lambda file: file.write_text(text, encoding="utf-8"))


def zipped(fill: Callable[[Path], object], file: Path) -> Path:
    """One ZIP file of the folder that ``fill`` writes, whose files are compressed already."""

    def write(part: Path) -> None:
        with tempfile.TemporaryDirectory(dir=file.parent, prefix=f".{file.name}.", suffix=".part") as name:
            folder = Path(name)
            fill(folder)
            with zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as archive:
                for inside in sorted(filter(Path.is_file, folder.rglob("*"))):
                    archive.write(inside, inside.relative_to(folder))

    return write_atomically(file, write)


def to_disk(path: Path) -> None:
    """fsync a file, or a folder (its list of names)."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
