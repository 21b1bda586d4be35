"""An identity provider over HTTP: what it says of itself, its keys, and a token for a code."""

import json
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any, Final
from urllib.error import HTTPError, URLError
from urllib.parse import quote, urlencode, urlsplit
from urllib.request import HTTPRedirectHandler, Request, build_opener

from sqlalchemy import Row, select

from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.who import ROLES, Role
from trueloop.server.settings import is_loopback
from trueloop.storage.factory_tables import ACCOUNT
from trueloop.storage.store import Store


@dataclass(frozen=True)
class Oidc:
    """An identity provider that is trusted. `secret`: empty for a client without one. `label`: what pages call it.

    `role_claim`: the claim that gives the role, by `roles` (a value of the claim, a role), the highest that fits;
    empty: the role is the account's.
    """

    issuer: str
    client_id: str
    secret: str = field(default="", repr=False)
    label: str = "Single sign-on"
    role_claim: str = ""
    roles: tuple[tuple[str, Role], ...] = ()


def refused(why: str) -> TrueloopError:
    """Makes the error SRV-OIDC."""
    hint = "sign in anew; if it stays so, an administrator has to look at the account and the provider's settings"
    return Code.SRV_OIDC.refusal(f"the sign-in is not taken: {why}", hint=hint)


TIMEOUT_S: Final = 10.0
LARGEST: Final = 1 << 20
KEPT: Final = timedelta(hours=1)
"""How long is kept what it says of itself; its keys are asked for again where one is not among them."""


@dataclass(frozen=True)
class ProviderAddresses:
    """Its addresses, and whether it takes the client's secret in the body alone."""

    authorization: str
    token: str
    keys: str
    secret_in_body: bool


class Provider:
    """By its issuer. Raises SRV-PROVIDER for all that it does not answer as it should."""

    def __init__(self, issuer: str) -> None:
        self.issuer = issuer
        self._found: tuple[datetime, ProviderAddresses] | None = None

    def found(self, now: datetime) -> ProviderAddresses:
        """Its addresses (OpenID Connect Discovery)."""
        if self._found is None or now - self._found[0] > KEPT:
            said = _object(Request(f"{self.issuer.rstrip('/')}/.well-known/openid-configuration"))
            if said.get("issuer") != self.issuer:
                raise failed(f"it calls itself {said.get('issuer')!r}, where {self.issuer!r} is expected")
            methods = said.get("token_endpoint_auth_methods_supported", ["client_secret_basic"])
            in_body = "client_secret_basic" not in methods and "client_secret_post" in methods
            names = ("authorization_endpoint", "token_endpoint", "jwks_uri")
            authorization, token, keys = (_safe(str(said.get(name, ""))) for name in names)
            self._found = now, ProviderAddresses(authorization, token, keys, in_body)
        return self._found[1]

    def keys(self, now: datetime) -> dict[str, Any]:
        """Its public keys, as JWK."""
        return _object(Request(self.found(now).keys))

    def token(self, oidc: Oidc, code: str, redirect: str, verifier: str, now: datetime) -> str:
        """Fetches the identity token for a code."""
        found = self.found(now)
        given = {"grant_type": "authorization_code", "code": code, "redirect_uri": redirect, "code_verifier": verifier}
        headers = {"Content-Type": "application/x-www-form-urlencoded", "Accept": "application/json"}
        if oidc.secret and not found.secret_in_body:
            pair = f"{quote(oidc.client_id, '')}:{quote(oidc.secret, '')}"
            headers["Authorization"] = f"Basic {b64encode(pair.encode()).decode()}"
        else:
            given |= {"client_id": oidc.client_id} | ({"client_secret": oidc.secret} if oidc.secret else {})
        answer = _object(Request(found.token, urlencode(given).encode(), headers))
        token = answer.get("id_token")
        if not isinstance(token, str):
            raise failed("it gave no id_token")
        return token


def require_safe_issuer(issuer: str) -> None:
    """Raises SRV-PROVIDER for an issuer that others on the way could play."""
    _safe(issuer)
    if urlsplit(issuer).query or urlsplit(issuer).fragment:
        raise failed(f"{issuer!r} is no issuer: it has a query")


def failed(why: str) -> TrueloopError:
    """Makes the error SRV-PROVIDER."""
    hint = "see --oidc-issuer and --oidc-client-id, and the provider's own settings of this client"
    return Code.SRV_PROVIDER.refusal(f"the identity provider: {why}", hint=hint)


class _NoRedirect(HTTPRedirectHandler):
    """A code or secret goes to the address that was named, and nowhere else."""

    def redirect_request(self, *_: Any, **__: Any) -> None:
        """Returns None: a redirect is an error."""


_OPENER: Final = build_opener(_NoRedirect)


def _object(request: Request) -> dict[str, Any]:
    where = _safe(request.full_url)
    try:
        with _OPENER.open(request, timeout=TIMEOUT_S) as answer:
            said = json.loads(answer.read(LARGEST))
    except HTTPError as error:
        raise failed(f"{where} answered {error.code}") from error
    except (URLError, OSError, ValueError) as error:
        raise failed(f"{where}: {type(error).__name__}") from error
    if not isinstance(said, dict):
        raise failed(f"{where} answered with something else than an object")
    return said


def _safe(address: str) -> str:
    parts = urlsplit(address)
    if parts.scheme == "https" or (parts.scheme == "http" and is_loopback(parts.hostname or "")):
        return address
    raise failed(f"{address!r} is not https")


def account_of(store: Store, oidc: Oidc, claims: Mapping[str, object], now: datetime) -> Row[Any]:
    """Returns the account, with its claim's role. Raises SRV-OIDC: stranger, disabled, or a claim without a role."""
    subject = str(claims["sub"])
    found = _found(store, oidc, subject)
    if found is None or found.disabled:
        raise refused(
            f"no account is open for {subject!r} of {oidc.issuer}; an administrator links one: "
            f"trueloop user link NAME {subject!r} --issuer {oidc.issuer}"
        )
    if not oidc.role_claim:
        return found
    role = role_of(oidc, claims)
    if role == found.role:
        return found
    try:
        change_account(store, found.name, Change(role=role), now, by=oidc.issuer)
    except TrueloopError as error:
        raise refused(f"the role {role!r} cannot be given: {error.message}") from error
    changed = _found(store, oidc, subject)
    if changed is None or changed.disabled:
        raise refused("the account was changed meanwhile")
    return changed


def role_of(oidc: Oidc, claims: Mapping[str, object]) -> Role:
    """Returns the highest role that a value of the claim gives. Raises SRV-OIDC where none does."""
    claim = claims.get(oidc.role_claim)
    values = claim if isinstance(claim, list) else [claim]
    given = [role for value, role in oidc.roles if value in values]
    if not given:
        raise refused(f"its claim {oidc.role_claim!r} gives no role")
    return max(given, key=ROLES.index)


def _found(store: Store, oidc: Oidc, subject: str) -> Row[Any] | None:
    wanted = select(ACCOUNT).where(ACCOUNT.c.oidc_subject == subject_of(oidc.issuer, subject))
    with store.reading() as connection:
        return connection.execute(wanted).one_or_none()
