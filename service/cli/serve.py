"""``whipple serve``: interface, queue and local workers together, until somebody says stop."""

import socket
from ipaddress import ip_address
from types import FrameType

import uvicorn
from fastapi import FastAPI

from service.api.app import open_service
from service.api.deadlines import LONGEST_HEAD, DeadlineProtocol
from service.cli import local
from service.files.data_directory import check_names, holding
from service.records import logs
from service.records.settings import Settings
from service.records.signals import Leaving, heeding
from studies.values.errors import Finding, InvalidInput

LEAVE_SECONDS = 3  # that open connections get after SIGTERM
# With so many requests under way a further one is answered 503 and its connection ends; streams that are open go
# on. Five times the event streams that are allowed, half the files that a process may have open where nobody set
# more (1024).
MOST_CONNECTIONS = 500
GONE_SECONDS = 9.0  # after it the process has ended, whatever hangs: a kill loses nothing either


def serve(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; raises DataInUse, InvalidInput for a setting that cannot be.

    Either signal is a wish, not an accident: everything is closed in order, and the status is 0.
    The process then ends here: a result that a thread still looks at is one for our next life.
    """
    logs.configure()
    check_names(settings)
    with (
        heeding(gone_within=GONE_SECONDS) as leaving,
        holding(settings),
        _listening(settings) as listener,
        open_service(settings, local.start_engine) as app,
    ):
        _Server(app, settings, leaving).run(sockets=[listener])
    leaving.go()


class _Server(uvicorn.Server):
    """Says where it listens as soon as it does, and lets runs and connections end side by side."""

    def __init__(self, app: FastAPI, settings: Settings, leaving: Leaving):
        config = uvicorn.Config(
            app,
            log_config=None,
            access_log=False,  # ours says more
            lifespan="off",
            server_header=False,
            http=DeadlineProtocol,
            ws="none",
            h11_max_incomplete_event_size=LONGEST_HEAD,
            proxy_headers=False,  # the peer is who is connected, whatever it says of itself
            limit_concurrency=MOST_CONNECTIONS,
            timeout_graceful_shutdown=LEAVE_SECONDS,
        )
        super().__init__(config)
        self._app = app
        self._settings = settings
        self._leaving = leaving

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """A signal: runs have as much time to write a checkpoint as connections have to close."""
        self._leaving.ask(sig)
        self._app.state.engine.leave()
        super().handle_exit(sig, frame)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self._leaving.asked():  # before there was somebody to hear it
            self.should_exit = True
            return
        assert sockets
        port = sockets[0].getsockname()[1]
        host = self._settings.host
        shown = f"[{host}]" if ":" in host else host
        data = self._settings.data.absolute()
        print(f"whipple serves http://{shown}:{port} (data in {data})", flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Event streams end at once: a client that wants to hear more asks again."""
        self._app.state.live.close()
        await super().shutdown(sockets)


def _listening(settings: Settings) -> socket.socket:
    """A socket that listens; port 0 takes a free one."""
    listener = socket.socket(_family(settings.host))
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((settings.host, settings.port))
    except OSError as error:
        listener.close()
        address = f"{settings.host} port {settings.port}"
        cure = f"choose another port, or 0 for a free one: {error.strerror}"
        raise InvalidInput([Finding("port", address, "an address that is free", cure)]) from None
    listener.set_inheritable(False)
    return listener


def _family(host: str) -> socket.AddressFamily:
    try:
        version = ip_address(host).version
    except ValueError:  # a name
        return socket.AF_INET
    return socket.AF_INET6 if version == 6 else socket.AF_INET
