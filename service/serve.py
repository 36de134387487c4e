"""``whipple serve``: interface, queue and local workers together, until somebody says stop."""

import signal
import socket
import sys
from ipaddress import ip_address
from types import FrameType

import uvicorn

from service.access import check_binding
from service.app import open_service
from service.settings import Settings
from studies.errors import Finding, InvalidInput

LEAVE_SECONDS = 3  # that open connections get after SIGTERM


def serve(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; raises InvalidInput for an address that cannot be taken."""
    check_binding(settings)
    signal.signal(signal.SIGTERM, _leave)
    from service import local

    with _listening(settings) as listener, open_service(settings, local.start_engine) as app:
        config = uvicorn.Config(
            app,
            log_level="warning",
            lifespan="off",
            server_header=False,
            timeout_graceful_shutdown=LEAVE_SECONDS,
        )
        _Server(config, settings).run(sockets=[listener])


class _Server(uvicorn.Server):
    """Says where it listens as soon as it does."""

    def __init__(self, config: uvicorn.Config, settings: Settings):
        super().__init__(config)
        self._settings = settings

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        assert sockets
        port = sockets[0].getsockname()[1]
        host = self._settings.host
        shown = f"[{host}]" if ":" in host else host
        data = self._settings.data.absolute()
        print(f"whipple serves http://{shown}:{port} (data in {data})", flush=True)


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


def _leave(number: int, frame: FrameType | None) -> None:
    """SIGTERM is a wish, not an accident: everything is closed in order, and the status is 0."""
    sys.exit(0)
