"""The command that starts the service."""

from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands.options import Data, Threads, settings_of
from service.memory import importing

app = typer.Typer()

Pem = Annotated[Path | None, typer.Option(metavar="FILE", help="PEM file for --engine.")]


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 selects a free one.")] = None,
    data: Data = None,
    engine: Annotated[
        str | None,
        typer.Option(help="tls://HOST:PORT of a Dask scheduler; by default runs are computed on this machine."),
    ] = None,
    tls_ca: Pem = None,
    tls_cert: Pem = None,
    tls_key: Pem = None,
    threads: Threads = None,
) -> None:
    """Start the service: HTTP interface, queue and workers. Defaults come from WHIPPLE_*."""
    with importing():
        from service.cli.serve import serve as run

    tls = {"tls_ca": tls_ca, "tls_cert": tls_cert, "tls_key": tls_key}
    run(settings_of(host=host, port=port, data=data, engine=engine, threads=threads, **tls))
