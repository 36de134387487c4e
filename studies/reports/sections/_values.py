"""Computes the section of values from the points of a cube."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from studies.cubes.points import axes_of, error_bars, main_quantities, places_of
from studies.cubes.reading import finite
from studies.reports.figures import figures
from studies.reports.opening import headline, is_made_by_mesh, opening_of
from studies.reports.section import Part, Source
from studies.reports.sections.values import Range, Values, Withheld


def values_of(source: Source) -> Part | None:
    """The section; None where nothing has a value."""
    points, comparison = source.points, source.comparison
    opening = opening_of(points, comparison.judgements, comparison.shots)
    units = {name: points[name].attrs.get("units") for name in axes_of(points)}
    record = Values(tuple(_ranges(points)), tuple(_withheld(points)))
    return Part(record, figures(source.dataset, comparison), headline(opening, units) if opening else "")


def _withheld(points: xr.Dataset) -> Iterator[Withheld]:
    for name in main_quantities(points):
        if count := int(is_made_by_mesh(points, name).sum()):
            yield Withheld(name, count, points.run_state.size)


def _ranges(points: xr.Dataset) -> Iterator[Range]:
    """Smallest and largest value of each main quantity, without those that are no answer."""
    places = places_of(points)
    for name in main_quantities(points):
        values = np.where(is_made_by_mesh(points, name), np.nan, points[name].values.ravel())
        bars = error_bars(points, name).values.ravel()
        if np.isfinite(values).any():
            low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
            yield Range(
                quantity=name,
                unit=str(points[name].attrs["units"]),
                smallest=float(values[low]),
                smallest_uncertainty=finite(float(bars[low])),
                smallest_at=places[low],
                largest=float(values[high]),
                largest_uncertainty=finite(float(bars[high])),
                largest_at=places[high],
            )
