"""Signing in by an identity provider (OpenID Connect): authorization code with PKCE, state and nonce.

What a sign-in needs is kept here until its answer comes, once and for ten minutes; the browser holds a cookie that
belongs to it, so that no other browser can end it.
"""

import secrets
from base64 import urlsafe_b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from hmac import compare_digest
from threading import Lock
from typing import Final
from urllib.parse import urlencode

from joserfc import jwt
from joserfc.errors import JoseError
from joserfc.jwk import KeySet

from trueloop.server.identity.provider import Oidc, Provider, failed, refused
from trueloop.server.identity.who import hashed

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
