"""Files that are made when they are asked for: results so far, cubes as Zarr, and what other features make of runs."""
