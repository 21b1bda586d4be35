"""An identity provider on loopback, written apart from the code under test: tokens made by hand, RSA by `pow`."""

import json
import secrets
import threading
from base64 import b64decode, urlsafe_b64encode
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import sha256
from html import escape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlencode, urlsplit

from sympy import randprime

CLIENT, SECRET = "factory", "s3cret/of the+client"
SHA256_INFO = bytes.fromhex("3031300d060960864801650304020105000420")
"""What stands before a SHA-256 hash in a signature of PKCS #1 v1.5 (RFC 8017)."""


def b64(raw: bytes) -> str:
    return urlsafe_b64encode(raw).decode().rstrip("=")


class Key:
    """An RSA key of 2048 bits."""

    def __init__(self, kid: str) -> None:
        e = 65537
        while True:
            p, q = (int(randprime(3 << 1022, 1 << 1024)) for _ in range(2))
            if p != q and (p - 1) % e and (q - 1) % e:
                break
        self.kid, self.n, self.e, self.d = kid, p * q, e, pow(e, -1, (p - 1) * (q - 1))

    def jwk(self) -> dict[str, str]:
        raw = [b64(number.to_bytes(length)) for number, length in ((self.n, 256), (self.e, 3))]
        return {"kty": "RSA", "use": "sig", "alg": "RS256", "kid": self.kid, "n": raw[0], "e": raw[1]}

    def signed(self, claims: Mapping[str, object], **header: object) -> str:
        head = {"alg": "RS256", "typ": "JWT", "kid": self.kid} | header
        text = ".".join(b64(json.dumps(part).encode()) for part in (head, claims))
        if head["alg"] == "none":
            return f"{text}."
        info = SHA256_INFO + sha256(text.encode()).digest()
        block = b"\0\1" + b"\xff" * (256 - 3 - len(info)) + b"\0" + info
        return f"{text}.{b64(pow(int.from_bytes(block), self.d, self.n).to_bytes(256))}"


@dataclass
class IdentityProvider:
    """`at_s`: its clock. `changed`: claims of the next tokens, None: left out; `token`: one in place of its own.

    `person`: the subject who is signed in there.
    """

    issuer: str
    key: Key
    at_s: float
    changed: dict[str, object] = field(default_factory=dict)
    token: str | None = None
    calls_itself: str = ""
    person: str = ""
    codes: dict[str, dict[str, str]] = field(default_factory=dict)
    refusals: list[str] = field(default_factory=list)

    def agreed(self, location: str, subject: str) -> dict[str, str]:
        """The person signs in at the page to which the browser was sent: what the browser then brings back."""
        parts = urlsplit(location)
        assert f"{parts.scheme}://{parts.netloc}{parts.path}" == f"{self.issuer}/authorize"
        asked = {name: values[0] for name, values in parse_qs(parts.query, strict_parsing=True).items()}
        assert asked["response_type"] == "code" and asked["client_id"] == CLIENT
        assert "openid" in asked["scope"].split() and asked["code_challenge_method"] == "S256"
        code = secrets.token_urlsafe(8)
        self.codes[code] = asked | {"subject": subject}
        return {"code": code, "state": asked["state"], "iss": self.issuer}

    def claims(self, asked: Mapping[str, str]) -> dict[str, object]:
        """Those of a token."""
        usual: dict[str, object] = {
            "iss": self.issuer, "aud": CLIENT, "sub": asked["subject"], "nonce": asked["nonce"],
            "iat": int(self.at_s), "exp": int(self.at_s) + 300,
        }  # fmt: skip
        return {name: value for name, value in (usual | self.changed).items() if value is not None}

    def exchanged(self, given: Mapping[str, str], authorization: str) -> dict[str, Any] | None:
        """A token for a code, once; None where anything does not fit (RFC 6749, RFC 7636)."""
        asked = self.codes.pop(given.get("code", ""), None)
        pair = b64decode(authorization.removeprefix("Basic ")).decode()
        challenge = b64(sha256(given.get("code_verifier", "").encode()).digest())
        wrong = [
            what
            for what, holds in (
                ("code", asked is not None),
                ("grant", given.get("grant_type") == "authorization_code"),
                ("client", pair == f"{CLIENT}:s3cret%2Fof%20the%2Bclient"),
                ("verifier", asked is not None and challenge == asked["code_challenge"]),
                ("redirect", asked is not None and given.get("redirect_uri") == asked["redirect_uri"]),
            )
            if not holds
        ]
        self.refusals += wrong
        if wrong or asked is None:
            return None
        token = self.token if self.token is not None else self.key.signed(self.claims(asked))
        return {"access_token": "x", "token_type": "Bearer", "id_token": token}

    def discovery(self) -> dict[str, str]:
        names = {"authorization_endpoint": "authorize", "token_endpoint": "token", "jwks_uri": "keys"}
        return {k: f"{self.issuer}/{v}" for k, v in names.items()} | {"issuer": self.calls_itself or self.issuer}


@contextmanager
def identity_provider(key: Key, at_s: float) -> Iterator[IdentityProvider]:
    """One that runs."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path.startswith("/authorize?"):
                self.asked_for_consent()
                return
            if self.path == "/favicon.ico":
                self.send(b"", "image/x-icon")
                return
            pages = {"/.well-known/openid-configuration": provider.discovery(), "/keys": {"keys": [key.jwk()]}}
            self.answer(pages.get(self.path))

        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"])).decode()
            given = {name: values[0] for name, values in parse_qs(body).items()}
            assert self.path == "/token"
            self.answer(provider.exchanged(given, self.headers.get("Authorization", "")))

        def asked_for_consent(self) -> None:
            """The provider's own page: the person who is signed in there agrees by its link."""
            brought = provider.agreed(provider.issuer + self.path, provider.person)
            back = f"{provider.codes[brought['code']]['redirect_uri']}?{urlencode(brought)}"
            self.send(f"<!doctype html><title>Sign in</title><a href='{escape(back)}'>Agree</a>".encode(), "text/html")

        def answer(self, content: object) -> None:
            self.send(json.dumps(content).encode(), "application/json", 200 if content is not None else 400)

        def send(self, raw: bytes, media: str, status: int = 200) -> None:
            self.send_response(status)
            self.send_header("Content-Type", media)
            self.send_header("Content-Length", str(len(raw)))
            self.end_headers()
            self.wfile.write(raw)

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        provider = IdentityProvider(f"http://127.0.0.1:{server.server_port}", key, at_s)
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        try:
            yield provider
        finally:
            server.shutdown()
