"""``cube.whipple``: what is drawn of a cube, as in its report. Importing the module adds it to every dataset of xarray."""

from typing import TYPE_CHECKING

import xarray as xr

if TYPE_CHECKING:
    from studies.reports.drawing.notebook import Figures


@xr.register_dataset_accessor("whipple")
class CubeAccessor:
    """The figures of a cube."""

    def __init__(self, cube: xr.Dataset):
        self._cube = cube

    def plot(self) -> "Figures":
        """Every figure of the report."""
        from studies.reports.drawing.notebook import figures_of

        return figures_of(self._cube)

    def plot_laws(self, quantity: str = "") -> "Figures":
        """Simulation, laws and observations: of every main quantity, or of one. Raises InvalidInput."""
        from studies.reports.drawing.notebook import figures_of_laws

        return figures_of_laws(self._cube, quantity)
