"""A cube in a notebook: parts of it by values with units, its main table, and the figures of its report.

Importing the module adds ``cube.whipple`` to every tree of xarray; Matplotlib is loaded when something is drawn.
"""

import base64
import io
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from studies.cubes.groups import joined
from studies.cubes.points import axes_of, is_same, plain
from studies.cubes.reading import flag_words, quantities_of
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.units import parse_quantity, readable
from studies.reports.figure import Figure
from studies.reports.report import report_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Asked = float | str
OF_LAWS = "_laws"  # in the name of a figure that shows laws


@dataclass(frozen=True)
class Figures:
    """Figures of a report; a notebook shows them, each with its caption."""

    figures: tuple[Figure, ...]

    def _repr_html_(self) -> str:
        return "".join(
            f'<figure><img src="data:image/svg+xml;base64,{_svg(figure)}" alt="{escape(figure.title)}" '
            f'style="background: white; max-width: 100%"><figcaption>{escape(figure.caption)}</figcaption></figure>'
            for figure in self.figures
        )

    @property
    def names(self) -> list[str]:
        """Names of the figures."""
        return [figure.name for figure in self.figures]


@xr.register_datatree_accessor("whipple")
class CubeAccessor:
    """What is asked of a cube: a part of it, a table, and the figures of its report."""

    def __init__(self, cube: xr.DataTree):
        self._cube = cube

    def sel(self, **at: Asked | list[Asked] | slice) -> xr.DataTree:
        """The cube at values of its axes, with their units: ``sel(speed="6 km/s")``; a number is in SI.

        A list, a slice, or an axis along ``run`` keeps the dimension. Raises InvalidInput for another
        axis, and for a value that the axis does not have.
        """
        whole = joined(self._cube)
        places: dict[Hashable, int | list[int]] = {}
        for name, asked in at.items():
            axis = whole[_known(name, axes_of(whole), "axis")]
            values = [plain(value) for value in axis.values]
            if isinstance(asked, slice):
                low = min(values) if asked.start is None else _in_si(axis, asked.start)
                high = max(values) if asked.stop is None else _in_si(axis, asked.stop)
                found = [place for place, value in enumerate(values) if low <= value <= high]  # type: ignore[operator]
            else:
                every = asked if isinstance(asked, list) else [asked]
                found = [place for one in every for place in _places(axis, values, one)]
            is_one = axis.dims == (name,) and not isinstance(asked, list | slice)
            places[axis.dims[0]] = found[0] if is_one else found
        return self._cube.isel(places)

    def to_dataframe(self) -> "pd.DataFrame":
        """Axes and main quantities of each point, in SI, flags and state in words.

        Constant columns are left out, but for the values of quantities.
        """
        root = self._cube.to_dataset()
        points = root[[name for name, array in root.data_vars.items() if {*array.dims} <= {*root.run_state.dims}]]
        for name, array in points.data_vars.items():
            if "flag_masks" in array.attrs:
                words = np.array([" ".join(each) for each in flag_words(array)], object)
                points[name] = array.dims, words.reshape(array.shape)
            elif "flag_values" in array.attrs:
                points[name] = array.dims, np.array(array.attrs["flag_meanings"].split(), object)[array.values]
        table = (points if points.dims else points.expand_dims("run")).reset_coords().to_dataframe()
        kept = quantities_of(root)
        return table[[name for name in table if name in kept or table[name].nunique(dropna=False) > 1]]

    def plot(self) -> Figures:
        """Every figure of the report, over the axes that are left; raises InvalidInput where a single point is."""
        whole = joined(self._cube)
        varied = [name for name in str(whole.attrs["axes"]).split() if whole[name].dims]
        if not varied:
            raise refusal("cube", "a single point", "a cube with an axis", "select fewer values")
        return Figures(report_of(whole.assign_attrs(axes=" ".join(varied))).head.figures)

    def plot_laws(self, quantity: str = "", ax: "Axes | None" = None) -> "Axes":
        """Simulation, laws and observations of a quantity, by default the first, on Matplotlib's axes or its current.

        Where other axes vary, at their first values: ``cube.whipple.sel(...)`` first. Raises InvalidInput.
        """
        from matplotlib import pyplot

        from studies.reports.drawing.canvas import drawn_in_style
        from studies.reports.drawing.charts import draw_panel

        every: dict[str, Figure] = {}
        for figure in self.plot().figures:
            if OF_LAWS in figure.name:
                every.setdefault(figure.name.partition(OF_LAWS)[0], figure)
        figure = every[_known(quantity or next(iter(every), ""), every)]
        axes = pyplot.gca() if ax is None else ax
        with drawn_in_style():
            draw_panel(axes, figure, figure.panels[0])
        return axes


def _in_si(axis: xr.DataArray, asked: Asked) -> float | str:
    """A value of an axis as it stands in the cube; raises InvalidInput."""
    if axis.dtype.kind in "OUT" or not isinstance(asked, str):
        return plain(asked)
    return float(parse_quantity(asked, axis.attrs["units"], str(axis.name)))


def _places(axis: xr.DataArray, values: Sequence[float | str], asked: Asked) -> list[int]:
    """The places of a value on an axis; raises InvalidInput where there is none."""
    wanted = _in_si(axis, asked)
    found = [place for place, value in enumerate(values) if is_same(value, wanted)]
    if not found:
        unit = axis.attrs.get("units")
        have = [str(value) if unit is None else readable(float(value), unit) for value in dict.fromkeys(values)]
        raise refusal(str(axis.name), asked, "a value of the axis: " + ", ".join(have), f"write {have[0]}")
    return found


def _svg(figure: Figure) -> str:
    from studies.reports.drawing.canvas import as_file, drawn_in_style
    from studies.reports.drawing.charts import chart

    file = io.BytesIO()
    with drawn_in_style():
        as_file(chart(figure), file, "svg")
    return base64.b64encode(file.getvalue()).decode()


def _known(name: str, names: Iterable[str], what: str = "figure") -> str:
    """The name, if it is one of these; raises InvalidInput with the nearest one."""
    known = list(dict.fromkeys(names))
    if name not in known:
        limit = ", ".join(known) or f"none: this cube has no such {what}"
        raise refusal(what, name, limit, nearest_cure(name, known))
    return name
