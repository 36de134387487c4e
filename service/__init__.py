"""HTTP in, files out: API, job store, execution on Dask, downloads, pages, command line."""

from importlib import metadata


def version() -> str:
    """The version of the installed distribution; "0+unknown" in a checkout that is not installed."""
    try:
        return metadata.version("whipple")
    except metadata.PackageNotFoundError:
        return "0+unknown"
