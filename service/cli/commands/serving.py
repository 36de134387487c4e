"""The service itself: ``whipple serve``."""

from typing import Annotated

import typer

from service.cli.commands import SERVICE, Commands
from service.cli.options import Data, Threads, settings_of
from service.memory import importing

app = typer.Typer()
COMMANDS = Commands("serving", SERVICE, app)


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 selects a free one.")] = None,
    data: Data = None,
    engine: Annotated[
        str | None, typer.Option(help="tls://HOST:PORT of an engine; by default runs are computed on this machine.")
    ] = None,
    threads: Threads = None,
) -> None:
    """Start the service: HTTP interface, queue and workers. Defaults come from WHIPPLE_*."""
    with importing():
        from service.cli.serve import serve as run

    run(settings_of(host=host, port=port, data=data, engine=engine, threads=threads))
