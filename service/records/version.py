"""The version of the installed distribution."""

from importlib import metadata


def version() -> str:
    """The version of the installed distribution; "0+unknown" in a checkout that is not installed."""
    try:
        return metadata.version("whipple")
    except metadata.PackageNotFoundError:
        return "0+unknown"
