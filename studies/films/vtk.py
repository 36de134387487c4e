"""Films and final states as files of VTK: particles (VTU), and for a film ``film.pvd``, which lists its frames.

The arrays of a VTU follow its XML, compressed by zlib: "appended raw" of VTK's own description (docs.vtk.org, VTK File
Formats). Four numbers precede each array: blocks (1), their size, the size of a shorter last block (0: there is none),
and the compressed size. The unit of an array is its ``UNITS_LABEL`` (vtkDataArray), the time of a file its
``TimeValue``.
"""

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solver.state import Snapshot
from studies.quantities.files import FILM, RESULT, STATE, write_atomically, write_text
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from xarray import Dataset

VERTEX = 1  # the cell of VTK that is a point
KINDS = {"float32": "Float32", "float64": "Float64", "int32": "Int32", "int64": "Int64", "uint8": "UInt8"}
HEAD = 'byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor"'
PVD, STATE_VTU, DEPARTED_VTU = "film.pvd", "state.vtu", "departed.vtu"
UNITS = {  # of a state, solver.state.Particles and Departed; a number without one has none
    **{"position": "m", "velocity": "m s-1", "mass": "kg", "density": "kg m-3", "energy": "J kg-1", "time": "s"},
    **dict.fromkeys(("pressure", "viscosity", "deviator"), "Pa"),
    **{"temperature": "K", "plastic_strain": "1", "damage": "1"},
}
TENSOR = ("11", "22", "33", "12", "23", "31")  # components of the stress deviator
COMPONENTS = {len(TENSOR): TENSOR}  # by their number


@dataclass(frozen=True)
class Points:
    """Particles at one time, each a point and a cell of its own."""

    time: float  # s
    position: np.ndarray  # (n, 3) m
    fields: Mapping[str, tuple[np.ndarray, str | None]]  # (n,) or (n, components), and the unit
    bodies: Sequence[str]  # names, in the order of the numbers in the field "body"


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


def export_film(film: "Dataset", folder: Path) -> Path:
    """Write every frame into a folder, and return the file that ParaView opens.

    Points are the particles on the grid at the time of the frame, with ``particle``, ``body`` (a place in
    ``bodies(film)``), and every number of the film over time and particle.
    """
    film = film.load()
    number = film.particle.values.astype(np.int32)
    body = np.unique(film.body, return_inverse=True)[1].astype(np.int32)
    lines = []
    for index, time in enumerate(film.time.values):
        frame = film.isel(time=index)
        here = np.isfinite(frame.speed.values)
        scalars = [name for name in frame if frame[name].dims == ("particle",)]
        fields = {str(name): (frame[name].values[here], frame[name].attrs["units"]) for name in scalars}
        fields |= {"particle": (number[here], None), "body": (body[here], None)}
        file = folder / f"film-{index:03}.vtu"
        _write(Points(float(time), frame.position.values[here], fields, bodies(film)), file)
        lines.append(f'<DataSet timestep="{float(time)!r}" file="{file.name}"/>\n')
    listed = "".join(lines)
    text = f'<VTKFile type="Collection" version="1.0"><Collection>\n{listed}</Collection></VTKFile>\n'
    return write_text(folder / PVD, text)


def bodies(film: "Dataset") -> list[str]:
    """Names of the bodies, in the order of the numbers that the files give them."""
    names: list[str] = np.unique(film.body).tolist()
    return names


def export_state(state: Snapshot, names: Sequence[str], folder: Path) -> list[Path]:
    """Write a final state into a folder: the particles on the grid, and those that departed, each as it was then.

    Both have every number of a particle; ``names`` are those of the bodies. Of a body of revolution position is r, z
    and an angle, and mass is per radian.
    """
    on_grid = {name: getattr(state.particles, name) for name in state.particles._fields if name != "alive"}
    departed = {name: value for name, value in state.departed._asdict().items() if name != "remembered"}
    files = {STATE_VTU: on_grid | {"body": state.body}, DEPARTED_VTU: departed}
    for name, arrays in files.items():
        fields = {
            {"number": "particle", "time": "departure_time"}.get(field, field): (values, UNITS.get(field))
            for field, values in arrays.items()
            if field != "position"
        }
        _write(Points(state.time, arrays["position"], fields, names), folder / name)
    return [folder / name for name in files]


def _write(points: Points, file: Path) -> None:
    """Write a VTU."""
    count = len(points.position)
    appended: list[bytes] = []

    def array(name: str, values: np.ndarray, unit: str | None = None) -> str:
        offset = sum(map(len, appended))
        packed = zlib.compress(values.astype(values.dtype.newbyteorder("<")).tobytes())
        appended.extend([np.array([1, values.nbytes, 0, len(packed)], "<u8").tobytes(), packed])
        width = values.shape[1] if values.ndim > 1 else 1
        labels = "".join(f' ComponentName{k}="{label}"' for k, label in enumerate(COMPONENTS.get(width, ())))
        head = f'<DataArray type="{KINDS[values.dtype.name]}" Name="{name}" NumberOfComponents="{width}"{labels}'
        key = f'<InformationKey name="UNITS_LABEL" location="vtkDataArray">{unit}</InformationKey>' if unit else ""
        return f'{head} format="appended" offset="{offset}">{key}</DataArray>'

    position = array("Points", points.position, UNITS["position"])
    cells = (
        array("connectivity", np.arange(count, dtype=np.int64))
        + array("offsets", np.arange(1, count + 1, dtype=np.int64))
        + array("types", np.full(count, VERTEX, np.uint8))
    )
    listed = "".join(array(name, *field) for name, field in points.fields.items())
    letters = " ".join(str(byte) for name in points.bodies for byte in (*name.encode(), 0))  # a zero ends each name
    text = (
        f'<VTKFile type="UnstructuredGrid" version="1.0" {HEAD}>\n<UnstructuredGrid>\n<FieldData>'
        f'<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{points.time!r}</DataArray>'
        f'<DataArray type="String" Name="bodies" NumberOfTuples="{len(points.bodies)}" format="ascii">{letters}'
        "</DataArray></FieldData>\n"
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{count}">\n<Points>{position}</Points>\n'
        f"<Cells>{cells}</Cells>\n<PointData>{listed}</PointData>\n</Piece>\n</UnstructuredGrid>\n"
        '<AppendedData encoding="raw">\n_'
    )
    content = b"".join([text.encode(), *appended, b"\n</AppendedData>\n</VTKFile>\n"])
    write_atomically(file, lambda part: part.write_bytes(content))
