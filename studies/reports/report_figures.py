"""All figures of a report, in the order in which they are read."""

import xarray as xr

from studies.reports.compare import Comparison
from studies.reports.convergence_figure import convergence_figures
from studies.reports.figures import Figure, against_laws, companions, growth, overlay
from studies.reports.points import points_of
from studies.reports.residual_figure import residuals
from studies.reports.view import main_quantities, view_of


def figures(cube: xr.Dataset, comparison: Comparison) -> tuple[Figure, ...]:
    """Figures of the points of a cube, the main ones first, and of their convergence."""
    points = points_of(cube)
    view, names = view_of(points), main_quantities(points)
    drawn = [
        *(against_laws(view, name, comparison) for name in names),
        *(residuals(view, name) for name in names if f"{name}_law" in points),
        *(overlay(view, name) for name in names if len(view.slices) > 1),
        *(companions(view, name) for name in names),
        *(growth(view, name) for name in names if f"{name}_history" in points),
        *convergence_figures(cube),
    ]
    return tuple(figure for figure in drawn if any(panel.series for panel in figure.panels))
