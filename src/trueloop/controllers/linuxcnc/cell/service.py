"""The service as a cell reaches it: `Service`."""

import http.client
import json
import secrets
import ssl
from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final
from urllib.parse import urlsplit

from trueloop.controllers.linuxcnc.cell.journal import Entry
from trueloop.errors import Code, TrueloopError

PREFIX: Final = "/api/v1"
REFUSALS: Final = frozenset(("SRV-REQUEST", "SRV-LARGE", "STO-TEXT", "FAC-UNKNOWN", "FAC-TOUCHES"))
"""The codes by which the service judges an entry itself and will never take it. Whatever else is answered, by the
service, a proxy or nobody, says nothing of the entry: it is sent again."""


@dataclass(frozen=True)
class Offered:
    """A block that the machine may run: the text as sent; `armed`: it may start without Cycle Start."""

    key: str
    machine: str
    kind: str
    sent_sha256: str
    text: bytes
    armed: bool


class RefusedError(TrueloopError):
    """An entry that the service refuses for good, with one of `REFUSALS` as its reason. CEL-SERVICE."""


class Service:
    """One address and one key. Every method raises CEL-SERVICE where the service is not reached or refuses."""

    def __init__(self, url: str, key: str, certificates: str | None = None, timeout_s: float = 5.0) -> None:
        parts = urlsplit(url)
        self.where, self._key, host, port = url, key, parts.hostname or "", parts.port
        self._connection: http.client.HTTPConnection = (
            http.client.HTTPSConnection(
                host, port, timeout=timeout_s, context=ssl.create_default_context(cafile=certificates)
            )
            if parts.scheme == "https"
            else http.client.HTTPConnection(host, port, timeout=timeout_s)
        )

    def next(self) -> Offered | None:
        """Fetches what the machine may run now; None: nothing."""
        said = self._post("/cell/next", {})
        if said is None:
            return None
        run = said["run"]
        return Offered(
            key=run["key"],
            machine=run["machine"]["name"],
            kind=said["block"]["kind"],
            sent_sha256=run["sent_sha256"],
            text=b64decode(said["program"]),
            armed=said["mode"] == "armed",
        )

    def tell(self, entries: Sequence[Entry]) -> None:
        """Facts, of which there may be several, or touches, or temperatures. Raises RefusedError besides."""
        first = dict(entries[0].values)
        if entries[0].what == "fact":
            self._post("/cell/facts", {"facts": [dict(one.values) for one in entries]})
        else:
            self._post(f"/cell/{entries[0].what}", first)

    def heartbeat(self, report: Mapping[str, Any]) -> None:
        """Reports the machine's present state."""
        self._post("/cell/heartbeat", dict(report))

    def trace(self, report: Mapping[str, Any]) -> None:
        """Reports what the machine's corrector did."""
        self._post("/cell/trace", dict(report))

    def arm(self, order: str, parts: int, why: str) -> Mapping[str, Any]:
        """Arms so many parts of an order: they start without Cycle Start."""
        done: Mapping[str, Any] = self._post(f"/orders/{order}/arm", {"parts": parts, "why": why})
        return done

    def close(self) -> None:
        """Lets the connection go; the next request makes another."""
        self._connection.close()

    def _post(self, path: str, body: Mapping[str, Any]) -> Any:
        headers = {"Authorization": f"Bearer {self._key}", "Content-Type": "application/json"}
        headers["Idempotency-Key"] = secrets.token_hex(16)
        try:
            self._connection.request("POST", PREFIX + path, json.dumps(body).encode(), headers)
            answer = self._connection.getresponse()
            content = answer.read()
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            raise self._failed(path, f"{type(error).__name__}: {error}") from error
        if answer.status >= 400:
            raise self._refusal(path, answer.status, content)
        return json.loads(content) if content else None

    def _refusal(self, path: str, status: int, content: bytes) -> TrueloopError:
        code = ""
        try:
            said = json.loads(content)
            code, words = str(said["code"]), f"{said['code']}: {said['detail']}"
        except (ValueError, KeyError, TypeError):
            words = content[:200].decode(errors="replace")
        return self._failed(path, f"status {status}: {words}", RefusedError if code in REFUSALS else TrueloopError)

    def _failed(self, path: str, why: str, of: type[TrueloopError] = TrueloopError) -> TrueloopError:
        hint = "see that the service runs and the key is this machine's; what is running goes on without it"
        return of(Code.CEL_SERVICE, f"{self.where}{path}: {why}", hint=hint)


def encoded(content: bytes) -> str:
    """Bytes as the service takes them."""
    return b64encode(content).decode()
