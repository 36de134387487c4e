"""``whipple serve``: HTTP interface, queue and local workers in one process, until SIGTERM or SIGINT."""

import ctypes
import logging
import os
import pwd
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from ipaddress import ip_address
from types import FrameType

import uvicorn
from fastapi import FastAPI

from service import logs
from service.api.access import is_loopback
from service.api.app import open_service
from service.api.middleware import LONGEST_HEAD, DeadlineProtocol
from service.cli import local
from service.cli.signals import EndRequest, handling_end_signals
from service.files import SOCKET
from service.files.data_directory import check_names, holding
from service.settings import Settings
from service.store import Store
from studies.quantities.findings import Finding, InvalidInput

log = logging.getLogger(__name__)

LEAVE_SECONDS = 3  # grace for open connections after SIGTERM
# Requests beyond this number are refused with 503; open streams continue. It is five times the limit of event
# streams, and half the default limit of open files (1024).
MOST_CONNECTIONS = 500
# A thread that computes keeps the interpreter so long from the event loop, which asks for it a dozen times a request.
SWITCH_SECONDS = 0.001
EXIT_SECONDS = 9.0  # after which the process ends in any case: a kill loses nothing either
# ``mallopt`` of the GNU C library: its number of a parameter, and a value. With an arena of memory for each of forty
# threads, which keeps what was freed, large sweeps left 280 MB more (2026-11).
M_ARENA_MAX, ARENAS = -8, 2
FIRST_USER, NO_LOGIN = 1000, ("nologin", "false")  # first uid of a person; shells of accounts that nobody logs in to


def serve(settings: Settings) -> None:
    """Serve until SIGTERM or SIGINT; raises DataInUse, InvalidInput.

    Either signal closes everything in order, and the exit status is 0. The process ends here, even while a
    thread verifies a result, which the next start verifies again.
    """
    logs.configure()
    with suppress(AttributeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, ARENAS)
    sys.setswitchinterval(SWITCH_SECONDS)
    check_names(settings)
    Store.check_origin(settings.url)
    with (
        handling_end_signals(end_within=EXIT_SECONDS) as leaving,
        holding(settings),
        _listening(settings) as listener,
        _door_of_the_user(settings) as doors,
        open_service(settings, local.start_engine) as app,
    ):
        _warn_of_other_users(settings)
        _Server(app, settings, leaving).run(sockets=[listener, *doors])
    leaving.go()


@contextmanager
def _door_of_the_user(settings: Settings) -> Iterator[list[socket.socket]]:
    """The socket in the data directory that this service alone holds, where the loopback asks for a key."""
    place = settings.data / SOCKET
    if not settings.has_replicas:
        place.unlink(missing_ok=True)  # the socket that a killed service left
    if settings.has_replicas or settings.trust_loopback:
        yield []
        return
    with socket.socket(socket.AF_UNIX) as door:
        try:
            door.bind(str(place))
        except OSError as error:
            cure = "give a shorter path, or one relative to this folder, on a file system with sockets"
            raise InvalidInput([Finding("data", str(place), f"a place for a socket: {error}", cure)]) from None
        place.chmod(0o600)  # before anything listens
        try:
            yield [door]
        finally:
            place.unlink(missing_ok=True)


def _warn_of_other_users(settings: Settings) -> None:
    """Say that others may give orders, where the loopback is trusted and the machine has other users."""
    people = (user for user in pwd.getpwall() if user.pw_uid >= FIRST_USER and not user.pw_shell.endswith(NO_LOGIN))
    others = sum(user.pw_uid != os.getuid() for user in people)
    if others and settings.trust_loopback and is_loopback(settings.host):
        text = "%d other users of this machine may give orders without a key; WHIPPLE_TRUST_LOOPBACK=false asks for one"
        log.warning(text, others)


class _Server(uvicorn.Server):
    """A server that prints its address, and stops runs and connections at the same time."""

    def __init__(self, app: FastAPI, settings: Settings, leaving: EndRequest):
        config = uvicorn.Config(
            app,
            log_config=None,
            access_log=False,  # the middleware logs requests
            lifespan="off",
            server_header=False,
            http=DeadlineProtocol,
            ws="none",
            h11_max_incomplete_event_size=LONGEST_HEAD,
            proxy_headers=False,  # the address of the peer decides who is trusted
            limit_concurrency=MOST_CONNECTIONS,
            timeout_graceful_shutdown=LEAVE_SECONDS,
        )
        super().__init__(config)
        self._app = app
        self._settings = settings
        self._leaving = leaving

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Handle a signal: runs write checkpoints while connections close."""
        self._leaving.ask(sig)
        self._app.state.engine.leave()
        super().handle_exit(sig, frame)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        # The signal came before the server handled signals.
        if self._leaving.asked():
            self.should_exit = True
            return
        assert sockets
        port = sockets[0].getsockname()[1]
        host = self._settings.host
        name = f"[{host}]" if ":" in host else host
        data = self._settings.data.absolute()
        print(f"whipple serves http://{name}:{port} (data in {data})", flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End event streams at once; clients reconnect."""
        for end in self._app.state.at_end:
            end()
        await super().shutdown(sockets)


def _listening(settings: Settings) -> socket.socket:
    """A listening socket; port 0 selects a free one. Raises InvalidInput."""
    try:
        family = socket.AF_INET6 if ip_address(settings.host).version == 6 else socket.AF_INET
    except ValueError:  # a host name
        family = socket.AF_INET
    listener = socket.socket(family)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((settings.host, settings.port))
    except OSError as error:
        listener.close()
        address = f"{settings.host} port {settings.port}"
        cure = f"choose another port, or 0 for a free one: {error.strerror}"
        raise InvalidInput([Finding("port", address, "a free address", cure)]) from None
    listener.set_inheritable(False)
    return listener
