"""What can be done with what was answered, for programs that read the description (OpenAPI links)."""

from collections.abc import Iterable
from typing import Any

OF_A_SWEEP = (
    "show_sweep",
    "show_document",
    "list_runs",
    "change_sweep",
    "cancel_sweep",
    "retry_sweep",
    "delete_sweep",
    "list_sweep_events",
    "get_cube_nc",
    "get_report_html",
    "get_report_json",
)
OF_A_RUN = ("show_run", "list_files", "list_run_events", "download_log")


def links(operations: Iterable[str], **parameters: str) -> dict[str, Any]:
    """The part of a response's description that names operations, with their parameters.

    >>> links(["show_run"], id="$response.body#/id")["links"]["show_run"]["operationId"]
    'show_run'
    """
    return {"links": {name: {"operationId": name, "parameters": parameters} for name in operations}}
