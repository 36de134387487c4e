"""From a sweep's runs to the files of its result: cube, tables of runs, report with appendix, figures for print.

The service calls it in a child process. The report is made from the cube as it was read
back from the disk, so that no answer can be in the report that is not in the file; date and wall times are added.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from studies.cubes import cube
from studies.cubes.catalogue import Catalogue
from studies.cubes.cells import Results, results_of
from studies.cubes.exports import runs_csv
from studies.cubes.older import PointsOfRuns, by_present_ids
from studies.cubes.opening import whole_cube
from studies.quantities.files import (
    ALL_RUNS_CSV,
    APPENDIX_HTML,
    COVER,
    CUBE,
    REPORT_HTML,
    REPORT_JSON,
    RUNS_CSV,
    SWEEP_FILES,
    write_text,
)
from studies.quantities.parameters import Plain
from studies.reports import report
from studies.sweeps.reading import ACCEPTED
from studies.sweeps.sweep import Sweep

Outcomes = Mapping[str, Mapping[str, Plain]]  # of runs by their ids: the JSON of a ``RunResult``, or state and reason


def publish(
    sweep_document: Mapping[str, Plain],
    outcomes: Outcomes,
    directory: Path | str,
    sections: Mapping[str, Path] | None = None,
    places: PointsOfRuns | None = None,
) -> dict[str, str]:
    """Write the files of a sweep ``runs-all.csv`` and ``cover.zip`` into a folder; paths by name.

    A run without an outcome is "missing". ``sections`` has, by run id, the file of its sections, for the pictures.
    ``places`` finds the runs of a sweep that another version expanded: they have other ids here.
    """
    sweep, results = Sweep.parse(sweep_document, ACCEPTED), results_of(outcomes)
    if places is not None:
        results = by_present_ids(sweep, results, places)
    return publish_sweep(sweep, results, Path(directory), sections=sections)


def publish_sweep(
    sweep: Sweep,
    results: Results,
    directory: Path,
    catalogue: Catalogue | None = None,
    sections: Mapping[str, Path] | None = None,
) -> dict[str, str]:
    """Publish a parsed sweep from results that are records."""
    from studies.reports.cover import write_cover  # with Matplotlib, which a partial cube need not load
    from studies.reports.page import appendix, page

    directory.mkdir(parents=True, exist_ok=True)
    files = {name: directory / name for name in (*SWEEP_FILES, ALL_RUNS_CSV, COVER)}
    cube.write(cube.build(sweep, results, catalogue), files[CUBE])
    dataset = cube.with_computation(whole_cube(files[CUBE]), results)
    write_text(files[RUNS_CSV], runs_csv(dataset))
    write_text(files[ALL_RUNS_CSV], runs_csv(dataset, every_column=True))
    document = report.report_of(dataset, sections).as_json()
    write_text(files[REPORT_JSON], report.as_json(document))
    write_text(files[REPORT_HTML], page(document, sections))
    write_text(files[APPENDIX_HTML], appendix(document, sections))
    write_cover(document, sections or {}, files[COVER])
    return {name: str(file) for name, file in files.items()}


def write_partial(
    sweep_document: Mapping[str, Plain], outcomes: Outcomes, file: Path, *, state: str, run_ids: Sequence[str] = ()
) -> Path:
    """Write the cube of a sweep that has not ended; its attributes say so, with ``state``.

    The numbers of a run that is ``pending`` or ``running`` are NaN; with the ids of all runs, in the order of the
    sweep, it is not looked at.
    """
    dataset = cube.build(Sweep.parse(sweep_document, ACCEPTED), results_of(outcomes), run_ids=run_ids)
    comment = f"Not complete: the sweep was {state}. {dataset.attrs['comment']}"
    return cube.write(dataset.assign_attrs(sweep_state=state, comment=comment), file)


def write_partial_report(
    sweep_document: Mapping[str, Plain], outcomes: Outcomes, file: Path, *, state: str, run_ids: Sequence[str] = ()
) -> Path:
    """Write the report of a sweep that has not ended, without pictures; its title says so, with ``state``."""
    from studies.reports.page import page

    titled = {**sweep_document, "title": f"{sweep_document['title']} (not complete: {state})"}
    with TemporaryDirectory() as folder:
        written = write_partial(titled, outcomes, Path(folder, CUBE), state=state, run_ids=run_ids)
        document = report.report_of(whole_cube(written)).as_json()
    return write_text(file, page(document))


FORMATS = ("png", "svg", "pdf")  # of figures as files


def draw_figures(cube_or_folder: Path, folder: Path, format: str) -> list[Path]:
    """Draw every figure of a cube into a folder, each in a file named after it; the files.

    The cube is a cube.nc or the folder of one. Raises InvalidInput where it is none.
    """
    from studies.reports.drawing.charts import draw

    figures = report.report_of(whole_cube(cube_or_folder)).head.figures
    return [draw(figure, folder / f"{figure.name}.{format}") for figure in figures]
