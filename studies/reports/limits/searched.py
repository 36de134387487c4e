"""The limits of a search."""

from typing import Any

import xarray as xr

from studies.cubes import limits as cubes
from studies.cubes.points import axes_of, plain
from studies.cubes.reading import finite


def limits_of(dataset: xr.Dataset) -> dict[str, Any] | None:
    """The limits of a search with their intervals; None without a search."""
    if not cubes.LIMIT.is_in(dataset):
        return None
    about = dataset.limit.attrs
    others = [name for name in axes_of(dataset) if f"limit_{name}" in dataset]
    rows = [
        {
            "at": {name: plain(dataset[f"limit_{name}"].values[place]) for name in others},
            "limit": finite(dataset.limit.values[place]),
            "lower": finite(dataset.limit_lower.values[place]),
            "upper": finite(dataset.limit_upper.values[place]),
            "runs": int(dataset.limit_runs.values[place]),
            "verdict": cubes.VERDICTS[int(dataset.limit_verdict.values[place])].replace("_", " "),
            "reason": str(dataset.limit_reason.values[place]),
        }
        for place in range(dataset.sizes[cubes.SEARCH])
    ]
    label = about["axis"].replace("_", " ")
    return {"axis": label, "of": about["limit_of"], "unit": about["units"], "rows": rows}
