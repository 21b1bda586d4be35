"""Signing in by an identity provider (OpenID Connect): authorization code with PKCE, state and nonce.

An identity provider over HTTP: what it says of itself, its keys, and a token for a code.

What a sign-in needs is kept here until its answer comes, once and for ten minutes; the browser holds a cookie that
belongs to it, so that no other browser can end it.
"""

import json
import secrets
from base64 import b64encode, urlsafe_b64encode
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from hashlib import sha256
from hmac import compare_digest
from threading import Lock
from typing import Any, Final
from urllib.error import HTTPError, URLError
from urllib.parse import quote, urlencode, urlsplit
from urllib.request import HTTPRedirectHandler, Request, build_opener

from joserfc import jwt
from joserfc.errors import JoseError
from joserfc.jwk import KeySet
from sqlalchemy import Row, select

from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.keys import ROLES, Role, hashed
from trueloop.server.settings import is_loopback
from trueloop.storage.schema import ACCOUNT
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
"""How long the provider's configuration is kept; its keys are fetched again where a token names another."""


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


LONGEST: Final = timedelta(minutes=10)
MOST: Final = 1000
"""Sign-ins under way at most: beyond, the oldest is given up."""
_BYTES: Final = 32


@dataclass(frozen=True)
class Going:
    """Where the browser is sent, and the cookie that it has to come back with."""

    address: str
    cookie: str


@dataclass(frozen=True)
class _Pending:
    nonce: str
    verifier: str
    cookie_sha256: str
    redirect: str
    until: datetime


class SignIns:
    """The sign-ins under way at one provider."""

    def __init__(self, oidc: Oidc) -> None:
        self.oidc, self.provider = oidc, Provider(oidc.issuer)
        self._pending = dict[str, _Pending]()
        self._lock = Lock()

    def begin(self, redirect: str, now: datetime) -> Going:
        """Begins a sign-in, whose answer comes to `redirect`. Raises SRV-PROVIDER."""
        state, nonce, verifier, cookie = (secrets.token_urlsafe(_BYTES) for _ in range(4))
        address = self.provider.found(now).authorization
        with self._lock:
            self._pending = {key: pending for key, pending in self._pending.items() if pending.until > now}
            while len(self._pending) >= MOST:
                del self._pending[next(iter(self._pending))]
            self._pending[state] = _Pending(nonce, verifier, hashed(cookie), redirect, now + LONGEST)
        asked = {
            "response_type": "code",
            "client_id": self.oidc.client_id,
            "redirect_uri": redirect,
            "scope": "openid profile",
            "state": state,
            "nonce": nonce,
            "code_challenge": urlsafe_b64encode(sha256(verifier.encode()).digest()).decode().rstrip("="),
            "code_challenge_method": "S256",
        }
        return Going(f"{address}{'&' if '?' in address else '?'}{urlencode(asked)}", cookie)

    def claims(self, answer: Mapping[str, str], cookie: str, now: datetime) -> Mapping[str, object]:
        """Returns the provider's claims of who has signed in. Each sign-in is ended once, whatever comes of it.

        Raises SRV-OIDC for an answer that belongs to no sign-in of this browser, or a token that does not hold;
        SRV-PROVIDER where the provider does not answer as it should.
        """
        with self._lock:
            pending = self._pending.pop(answer.get("state", ""), None)
        if pending is None or pending.until <= now or not compare_digest(pending.cookie_sha256, hashed(cookie)):
            raise refused("its answer belongs to no sign-in that this browser has begun in the last 10 minutes")
        if answer.get("iss", self.oidc.issuer) != self.oidc.issuer:
            raise refused("the answer is another provider's")
        if "code" not in answer:
            said = "".join(one for one in answer.get("error", "")[:40] if one.isalnum() or one in "_-")
            raise refused(f"the provider has refused it: {said or 'no code'}")
        token = self.provider.token(self.oidc, answer["code"], pending.redirect, pending.verifier, now)
        return checked_claims(token, self.provider, self.oidc.client_id, pending.nonce, now)


SIGNED_BY: Final = ["RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512", "Ed25519", "EdDSA"]
"""Signatures by a key that the provider alone has: not `none`, and none by a secret that both have."""
CLOCKS_S: Final = 60
"""How far its clock and ours may differ."""


def checked_claims(token: str, provider: Provider, client: str, nonce: str, now: datetime) -> Mapping[str, object]:
    """Returns the claims of a token that holds (OpenID Connect Core 3.1.3.7). Raises SRV-OIDC, SRV-PROVIDER."""
    claims = _signed(token, provider, now)
    audience = claims.get("aud")
    audiences = [audience] if isinstance(audience, str) else audience
    at, until, subject = now.timestamp(), claims.get("exp"), claims.get("sub")
    if claims.get("iss") != provider.issuer:
        raise refused("its token is of another issuer")
    if not isinstance(audiences, list) or client not in audiences:
        raise refused("its token is for another client")
    if (len(audiences) > 1 or "azp" in claims) and claims.get("azp") != client:
        raise refused("its token was issued to another client")
    if not _number(until) or at >= float(until) + CLOCKS_S:  # type: ignore[arg-type]
        raise refused("its token has expired")
    for name in ("iat", "nbf"):
        begun = claims.get(name, at if name == "nbf" else None)
        if not _number(begun) or float(begun) > at + CLOCKS_S:  # type: ignore[arg-type]
            raise refused(f"its token is of a time to come, or says none: {name}")
    if claims.get("nonce") != nonce:
        raise refused("its token is of another sign-in")
    if not isinstance(subject, str) or not 1 <= len(subject) <= 255:
        raise refused("its token names nobody")
    return claims


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _signed(token: str, provider: Provider, now: datetime) -> Mapping[str, object]:
    try:
        keys = KeySet.import_key_set(provider.keys(now))  # type: ignore[arg-type]
    except (JoseError, ValueError, KeyError, TypeError) as error:
        raise failed("its keys cannot be read") from error
    try:
        return jwt.decode(token, keys, algorithms=SIGNED_BY).claims
    except (JoseError, ValueError, KeyError, TypeError) as error:
        raise refused(f"its token is not signed by a key of the provider ({type(error).__name__})") from error
