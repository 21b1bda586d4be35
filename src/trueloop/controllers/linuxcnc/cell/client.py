"""The client: sees, decides (`decide.py`), writes into its journal, acts; one step at a time."""

import http.client
import json
import re
import secrets
import ssl
import time
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from itertools import takewhile
from typing import Any, Final, TypeVar
from urllib.parse import urlsplit

from trueloop.controllers.linuxcnc.cell.decide import (
    Action,
    Control,
    ControlNow,
    Do,
    Patience,
    ServiceState,
    decide,
    seen,
)
from trueloop.controllers.linuxcnc.cell.journal import Entry, Journal, JournalState, RunNow, known, with_entry
from trueloop.controllers.linuxcnc.cell.linuxcnc import EMPTY
from trueloop.domain.factory import FactKind
from trueloop.errors import Code, TrueloopError
from trueloop.nc.witness import log_lines

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
            self._post("/cell/facts", {"facts": [dict(entry.values) for entry in entries]})
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


T = TypeVar("T")
BATCH: Final = 100
"""So many facts at most go in one request."""
_PROBE_LOG: Final = re.compile(rb"\(\s*(?:PROBEOPEN\s|LOGOPEN\s*,)\s*([^\s)/]+)\s*\)", re.IGNORECASE)


@dataclass(frozen=True)
class Pace:
    """How often: seconds between looks, questions, words of life and tries of a service that is away."""

    look_s: float = 0.1
    ask_s: float = 1.0
    alive_s: float = 2.0
    retry_s: float = 5.0
    patience: Patience = field(default_factory=Patience)


class Client:
    """One machine's cell. `step` never waits longer than one request; `said` is what it waits for, for people."""

    def __init__(self, machine: str, control: Control, service: Service, journal: Journal, pace: Pace = Pace()) -> None:
        self.machine, self.control, self.service, self.journal, self.pace = machine, control, service, journal, pace
        self.known: JournalState = known(journal.entries)
        self.said = ""
        self.fault: TrueloopError | None = None
        self._asked, self._text = ServiceState(), b""
        self._next_ask = self._next_try = self._next_word = 0.0

    def step(self) -> bool:
        """Looks, and does one thing. False: there is nothing to do but wait."""
        self._deliver()
        action, control = self._decided()
        self._alive(control, action)
        self.said = action.why
        try:
            return self._do(action)
        except TrueloopError as error:
            if error.code is Code.CEL_JOURNAL:
                raise
            self.fault = error
            return False

    def _decided(self) -> tuple[Action, ControlNow]:
        now, run = self.control.now(), self.known.run  # first what it does, then what was logged: see `Control.witness`
        logged = seen(self.control.witness(), run.key) if run else seen("", "")
        asked, self._asked = self._asked, ServiceState()
        return decide(run, now, logged, asked, self.pace.patience), now

    def _do(self, action: Action) -> bool:
        run = self.known.run
        if action.do is Do.ASK:
            return self._ask()
        if action.do is Do.WAIT or run is None:
            return False
        if action.do is Do.TELL:
            self._tell(run, action)
        else:
            how = {Do.SEND: self._send, Do.OPEN: self._open, Do.BEGIN: self._begin, Do.GATHER: self._gather}
            how.get(action.do, self._clear)(run)
        if action.do is Do.CLOSE:
            self._note("closed", run=run.key)
        return True

    def _tell(self, run: RunNow, action: Action) -> None:
        """As a run begins, what it is read from is looked at once more."""
        assert action.fact is not None
        self._fact(run.key, action.fact, action.witness, {"why": action.why} if action.why else {})
        if action.fact is FactKind.STARTED and self._read_back(run.program) not in (run.sent_sha256, ""):
            self._verified(run.key, run.program)

    def _open(self, run: RunNow) -> None:
        if run.touches:
            self.control.discard_touches(run.touches)
        self.control.open(run.program)
        self._note("opened", run=run.key)

    def _begin(self, run: RunNow) -> None:
        if self._read_back(run.program) == run.sent_sha256:
            self._note("begun", run=run.key)
            self.control.cycle_start()
        else:
            self._verified(run.key, run.program)

    def _clear(self, run: RunNow) -> None:
        self.control.clear(run.program)

    def _send(self, run: RunNow) -> None:
        self.control.write(run.program, self._text)
        self._fact(run.key, FactKind.SENT, "cell", {})
        self._verified(run.key, run.program)

    def _verified(self, key: str, program: str) -> None:
        self._fact(key, FactKind.VERIFIED, "cell", {"read_back_sha256": self._read_back(program)})

    def _read_back(self, program: str) -> str:
        content = self.control.read_back(program)
        return "" if content is None else sha256(content).hexdigest()

    def _gather(self, run: RunNow) -> None:
        content = self.control.touches(run.touches)
        if content is None:
            self._note("no-touches", run=run.key)
        else:
            self._note("touches", run=run.key, name=run.touches, file=encoded(content))

    def _ask(self) -> bool:
        """Only with all words delivered: the service takes one who asks for one who does not run anything."""
        now = time.monotonic()
        if self.known.waiting or now < max(self._next_ask, self._next_try):
            return False
        self._next_ask = now + self.pace.ask_s
        offer, run = self._reached(self.service.next), self.known.run
        if run is not None and (offer is None or offer.key != run.key):
            over = run.facts & {FactKind.UNKNOWN}
            if over and offer is None:
                return False
            self._note("closed" if over else "withdrawn", run=run.key)
            return True
        if offer is None:
            return False
        require_own(offer, self.machine)
        if run is None:
            return self._take(offer)
        if offer.sent_sha256 != run.sent_sha256:
            raise _not_ours(f"run {offer.key!r} was {run.sent_sha256[:16]!r} and now is {offer.sent_sha256[:16]!r}")
        self._asked, self._text = ServiceState(offer.key, offer.armed, offer.text), offer.text
        return True

    def _take(self, offer: Offered) -> bool:
        """A key runs once: one that is over the service has lost the end of. Its facts are sent again."""
        if offer.key in self.known.over:
            again = [entry for entry in self.journal.entries if entry.values.get("run") == offer.key]
            for entry in again:
                if entry.what in ("fact", "touches"):
                    self._note(entry.what, **entry.values)
            raise _not_ours(f"run {offer.key!r} is over: it runs once")
        gauges = offer.kind in ("probe", "inspect")
        name = _PROBE_LOG.search(offer.text) if gauges else None
        self._asked, self._text = ServiceState(offer.key, offer.armed, offer.text), offer.text
        said = name[1].decode(errors="replace") if name else ""
        self._note("run", key=offer.key, sent_sha256=offer.sent_sha256, touches=said, kind=offer.kind)
        return True

    def temperatures(self, signals: dict[str, float], age_s: float = 0.0) -> None:
        """Records the machine's temperatures by signal, °C, as they were so long ago."""
        run = self.known.run.key if self.known.run else ""
        at = datetime.now(UTC) - timedelta(seconds=age_s)
        self._note("temperatures", signals=signals, at=at.isoformat(), run=run)

    def _fact(self, key: str, what: FactKind, witness: str, values: dict[str, str]) -> None:
        self._note("fact", run=key, what=what.value, at=datetime.now(UTC).isoformat(), witness=witness, values=values)

    def _note(self, what: str, /, **values: object) -> None:
        self.known = with_entry(self.known, self.journal.add(what, **values))

    def _deliver(self) -> None:
        """Sends everything that waits, oldest first, until the service is away; a batch refused, entry by entry."""
        most = BATCH
        while self.known.waiting and time.monotonic() >= self._next_try:
            batch = _batch(self.known.waiting, most)
            numbers = [entry.no for entry in batch]
            try:
                self._reached(lambda given=batch: self.service.tell(given))  # type: ignore[misc]
                self._note("acknowledged", entries=numbers)
            except RefusedError as refused:
                self.fault = refused
                if len(batch) == 1:
                    self._note("refused", entries=numbers, said=refused.message)
                most = 1
            except TrueloopError as away:
                self.fault = away
                return

    def _reached(self, request: Callable[[], T]) -> T:
        try:
            answer = request()
        except RefusedError:
            raise
        except TrueloopError:
            self._next_try = time.monotonic() + self.pace.retry_s
            raise
        self.fault = None
        return answer

    def _alive(self, control: ControlNow, action: Action) -> None:
        now = time.monotonic()
        if now < max(self._next_word, self._next_try):
            return
        self._next_word = now + self.pace.alive_s
        program = "" if control.program == EMPTY else control.program
        said = {"state": control.doing.value, "program": program, "line": control.line}
        try:
            self._reached(lambda: self.service.heartbeat(said))
        except TrueloopError as away:
            self.fault = away


def _batch(waiting: Sequence[Entry], most: int) -> list[Entry]:
    """The first entries that go in one request: facts together, anything else by itself."""
    facts = list(takewhile(lambda entry: entry.what == "fact", waiting[:most]))
    return facts or [waiting[0]]


def require_own(offer: Offered, machine: str) -> None:
    """Raises CEL-OFFER for a block of another machine, another text than named, or one that does not witness itself."""
    if offer.machine != machine:
        raise _not_ours(f"run {offer.key!r} is for machine {offer.machine!r}, and this is {machine!r}")
    if sha256(offer.text).hexdigest() != offer.sent_sha256:
        raise _not_ours(f"run {offer.key!r} is to be {offer.sent_sha256[:16]!r} and its text is not")
    head, tail = (b"\n".join(lines) for lines in log_lines(offer.key))
    plain = offer.text.replace(b"\r\n", b"\n")
    if plain.count(head) != 1 or tail not in plain:
        raise _not_ours(f"run {offer.key!r} does not witness itself")


def _not_ours(why: str) -> TrueloopError:
    return Code.CEL_OFFER.refusal(why, hint="see that key and settings are of one machine; nothing is started")
