"""A film as files of VTK: one of particles (VTU) for each frame, and ``film.pvd``, which lists them with their times.

The arrays of a VTU follow its XML, compressed by zlib: "appended raw" of VTK's own description (docs.vtk.org, VTK File
Formats). Four numbers precede each array: blocks (1), their size, the size of a shorter last block (0: there is none),
and the compressed size.
"""

import zlib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from studies.quantities.files import write_atomically, write_text

if TYPE_CHECKING:
    from xarray import Dataset

VERTEX = 1  # the cell of VTK that is a point
KINDS = {"float32": "Float32", "int32": "Int32", "uint8": "UInt8"}
HEAD = 'byte_order="LittleEndian" header_type="UInt32" compressor="vtkZLibDataCompressor"'
PVD = "film.pvd"


def export_vtk(film: "Dataset", folder: Path) -> Path:
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
        fields = {str(name): frame[name].values[here] for name in scalars}
        fields |= {"particle": number[here], "body": body[here]}
        file = folder / f"film-{index:03}.vtu"
        content = _vtu(frame.position.values[here], fields)
        write_atomically(file, partial(Path.write_bytes, data=content))
        lines.append(f'<DataSet timestep="{float(time)!r}" file="{file.name}"/>\n')
    listed = "".join(lines)
    text = f'<VTKFile type="Collection" version="1.0"><Collection>\n{listed}</Collection></VTKFile>\n'
    return write_text(folder / PVD, text)


def bodies(film: "Dataset") -> list[str]:
    """Names of the bodies, in the order of the numbers that the files give them."""
    names: list[str] = np.unique(film.body).tolist()
    return names


def _vtu(position: np.ndarray, fields: Mapping[str, np.ndarray]) -> bytes:
    """Points, each a cell of its own, with their fields."""
    count = len(position)
    appended = bytearray()

    def array(name: str, values: np.ndarray) -> str:
        offset = len(appended)
        packed = zlib.compress(values.astype(values.dtype.newbyteorder("<")).tobytes())
        appended.extend(np.array([1, values.nbytes, 0, len(packed)], "<u4").tobytes() + packed)
        width = values.shape[1] if values.ndim > 1 else 1
        return (
            f'<DataArray type="{KINDS[values.dtype.name]}" Name="{name}" NumberOfComponents="{width}" '
            f'format="appended" offset="{offset}"/>'
        )

    points = array("Points", position)
    cells = (
        array("connectivity", np.arange(count, dtype=np.int32))
        + array("offsets", np.arange(1, count + 1, dtype=np.int32))
        + array("types", np.full(count, VERTEX, np.uint8))
    )
    listed = "".join(array(name, values) for name, values in fields.items())
    text = (
        f'<VTKFile type="UnstructuredGrid" version="1.0" {HEAD}>\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{count}" NumberOfCells="{count}">\n<Points>{points}</Points>\n'
        f"<Cells>{cells}</Cells>\n<PointData>{listed}</PointData>\n</Piece>\n</UnstructuredGrid>\n"
        '<AppendedData encoding="raw">\n_'
    )
    return text.encode() + bytes(appended) + b"\n</AppendedData>\n</VTKFile>\n"
