"""HTTP in, files out: API, job store, execution on Dask, downloads, pages, command line."""
