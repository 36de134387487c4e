"""The film and the final state of a run as files of VTK; called by the command line, and by the service in a child
process.
"""

import json
from collections.abc import Mapping
from pathlib import Path

from studies.quantities.files import FILM, RESULT, STATE
from studies.quantities.findings import refusal


def files_of(run: Path) -> dict[str, Path]:
    """Film, final state and result of a run by their names: the file at a path, or those in a folder."""
    if not run.is_dir():
        name = STATE if run.name.endswith(STATE) else FILM
        return {name: run}
    return {name: run / name for name in (FILM, STATE, RESULT) if (run / name).is_file()}


def export_vtk(files: Mapping[str, Path], folder: Path) -> list[Path]:
    """Write the film and the final state of a run into a folder; the files to open.

    ``files`` are those of the run by their names; the bodies of a state have the names that its result says. Raises
    InvalidInput where there is neither film nor state.
    """
    from studies.films.film_dataset import open_film
    from studies.films.vtk import export_film, export_state
    from studies.runs.remeasure import load_state

    if not {FILM, STATE} & set(files):
        raise refusal("run", ", ".join(files) or "no file", f"a {FILM} or a {STATE}", "submit with keep: final or film")
    written = []
    if FILM in files:
        with open_film(files[FILM]) as film:
            written.append(export_film(film, folder))
    if STATE in files:
        histories = json.loads(files[RESULT].read_bytes()).get("histories", {}) if RESULT in files else {}
        written += export_state(load_state(files[STATE]), histories.get("bodies", []), folder)
    return written
