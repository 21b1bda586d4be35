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

from trueloop.server.identity.provider import Provider
from trueloop.server.identity.token import checked_claims
from trueloop.server.identity.trusted import Oidc, refused

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
            self._pending = {key: one for key, one in self._pending.items() if one.until > now}
            while len(self._pending) >= MOST:
                del self._pending[next(iter(self._pending))]
            self._pending[state] = _Pending(nonce, verifier, _hash(cookie), redirect, now + LONGEST)
        asked = {
            "response_type": "code",
            "client_id": self.oidc.client_id,
            "redirect_uri": redirect,
            "scope": "openid profile",
            "state": state,
            "nonce": nonce,
            "code_challenge": _challenge(verifier),
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
        if pending is None or pending.until <= now or not compare_digest(pending.cookie_sha256, _hash(cookie)):
            raise refused("its answer belongs to no sign-in that this browser has begun in the last 10 minutes")
        if answer.get("iss", self.oidc.issuer) != self.oidc.issuer:
            raise refused("the answer is another provider's")
        if "code" not in answer:
            said = "".join(one for one in answer.get("error", "")[:40] if one.isalnum() or one in "_-")
            raise refused(f"the provider has refused it: {said or 'no code'}")
        token = self.provider.token(self.oidc, answer["code"], pending.redirect, pending.verifier, now)
        return checked_claims(token, self.provider, self.oidc.client_id, pending.nonce, now)


def _challenge(verifier: str) -> str:
    return urlsafe_b64encode(sha256(verifier.encode()).digest()).decode().rstrip("=")


def _hash(cookie: str) -> str:
    return sha256(cookie.encode("utf-8", "surrogateescape")).hexdigest()
