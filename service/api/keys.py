"""Who is asking: API keys as bearer tokens (RFC 6750), what each may do, and whose sweep is whose.

A request that came by a name of the loopback, to a service that listens there, needs no key: whoever
can send it is a user of this machine. Everybody else needs one, unless the request comes from the
address of a declared proxy, which has checked who is asking. A key that is given counts everywhere: its
name owns what is submitted with it, and its scopes are the limit. Secrets are compared as digests, by
the store; they are never logged, and never part of an answer.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Request, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer, SecurityScopes
from fastapi.security.base import SecurityBase

from service.api.access import is_of_this_machine, is_of_trusted_proxy
from service.api.errors import NoKey, NotAllowed
from service.records.jobs import Scope, SweepStatus
from service.records.settings import Settings
from service.store import Store

LONGEST_SECRET = 200  # characters; those that the service makes are shorter

# What a scope allows beside its own.
INCLUDES = {
    Scope.READ: frozenset({Scope.READ}),
    Scope.SUBMIT: frozenset({Scope.SUBMIT, Scope.READ}),
    Scope.ADMIN: frozenset(Scope),
}


@dataclass(frozen=True)
class Caller:
    """Somebody who asks, as far as the service knows."""

    name: str  # of the API key; empty without one
    scopes: frozenset[Scope]

    def may(self, scope: Scope) -> bool:
        """Whether what ``scope`` stands for is allowed."""
        return any(scope in INCLUDES[own] for own in self.scopes)

    def check_owns(self, sweep: SweepStatus) -> None:
        """Raises NotAllowed, unless the sweep is the caller's own or the caller an ``admin``."""
        if sweep.owner != self.name and not self.may(Scope.ADMIN):
            raise NotAllowed(
                "the sweep was submitted with another key; ask its owner, or use a key with the "
                f"scope `{Scope.ADMIN}`",
                scope=Scope.ADMIN,
            )


WITHOUT_KEY = Caller("", frozenset(Scope))  # a user of this machine, or checked by the proxy

bearer: SecurityBase = HTTPBearer(
    scheme_name="API key",
    description="`Authorization: Bearer KEY`; not needed on the service's own machine.",
    auto_error=False,
)


def the_caller(
    request: Request,
    wanted: SecurityScopes,
    given: Annotated[HTTPAuthorizationCredentials | None, Depends(bearer)],
) -> Caller:
    """Who is asking, if that may do what the endpoint is for; raises NoKey, NotAllowed."""
    caller = _known(request, given)
    request.state.caller = caller.name
    for scope in _scopes(wanted.scopes):
        if not caller.may(scope):
            raise NotAllowed(
                f"the key {caller.name!r} does not have the scope `{scope}`; ask for one that has",
                scope=scope,
            )
    return caller


def _known(request: Request, given: HTTPAuthorizationCredentials | None) -> Caller:
    if given is not None:
        return _holder(request.app.state.store, given.credentials)
    if "authorization" in request.headers:
        raise NoKey("write the header as `Authorization: Bearer KEY`", given=True)
    settings: Settings = request.app.state.settings
    is_checked = is_of_trusted_proxy(request.scope, settings)
    if is_checked or is_of_this_machine(request.scope, settings):
        return WITHOUT_KEY
    raise NoKey(
        "send `Authorization: Bearer KEY`; a key is made on the service's machine with `whipple keys`",
        given=False,
    )


def _holder(store: Store, secret: str) -> Caller:
    """Whose key this is."""
    found = store.find_key(secret) if 0 < len(secret) <= LONGEST_SECRET else None
    if found is None:
        raise NoKey("this key is unknown, revoked or past its time; ask for another", given=True)
    return Caller(found.name, found.scopes)


def _scopes(words: Iterable[str]) -> list[Scope]:
    return [Scope(word) for word in words]


def allows(scope: Scope) -> Any:
    """A dependency that lets in only those who may do what ``scope`` stands for."""
    return Security(the_caller, scopes=[scope.value])


Submitter = Annotated[Caller, allows(Scope.SUBMIT)]
Administrator = Annotated[Caller, allows(Scope.ADMIN)]
