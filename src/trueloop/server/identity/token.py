"""An identity token: whether the provider signed it, for us, for this sign-in, and now."""

from collections.abc import Mapping
from datetime import datetime
from typing import Final

from joserfc import jwt
from joserfc.errors import JoseError
from joserfc.jwk import KeySet

from trueloop.server.identity.provider import Provider, failed
from trueloop.server.identity.trusted import refused

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
