"""Transfers kept in a store: what went to a control or came from it, by whom, and what was read back."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

from trueloop.controllers.links.compare import Difference
from trueloop.domain.record import sha256_of
from trueloop.errors import TrueloopError
from trueloop.factory.carry_out import carry_out
from trueloop.factory.decisions.plan import not_released
from trueloop.factory.requests import RecordTransfer
from trueloop.factory.roles import By, Role
from trueloop.factory.shown.paging import known_of
from trueloop.factory.shown.programs import program_row
from trueloop.jobs.links.opened import Opened
from trueloop.jobs.links.send import send
from trueloop.jobs.links.sent import Replace, Sent
from trueloop.jobs.user import user_name
from trueloop.storage.store import Store


@dataclass(frozen=True)
class Recorder:
    """The store that keeps them, and the control by its link's name."""

    store: Store
    control: str

    def fetched(self, name: str, content: bytes) -> None:
        """A program came from the control."""
        sha = sha256_of(content)
        self._keep(name, "from", sha, "", sha, "fetched")

    def compared(self, name: str, content: bytes, at_control: bytes, found: Sequence[Difference]) -> None:
        """A program of the control was compared with a file."""
        outcome = f"differs: {'; '.join(map(_said, found))}" if found else "the same"
        self._keep(name, "from", sha256_of(content), "", sha256_of(at_control), outcome)

    def sent(
        self, opened: Opened, content: bytes, name: str, *, replace: Replace = False, not_running: bool = False
    ) -> Sent:
        """Sends a released program and keeps what came of it, a refusal too. Raises FAC-RELEASE, FAC-UNKNOWN before."""
        sha = sha256_of(content)
        with known_of(self.store) as known:
            if not program_row(known, sha).released:
                raise not_released(sha)
        try:
            done = send(opened, content, name, replace=replace, not_running=not_running)
        except TrueloopError as error:
            self._keep(name, "to", sha, sha, "", f"{error.code.value}: {error.message}")
            raise
        self._keep(name, "to", sha, sha, done.read_back_sha256, "read back" if done.written else "there already")
        return done

    def _keep(
        self, name: str, direction: Literal["to", "from"], program: str, sent: str, back: str, outcome: str
    ) -> None:
        request = RecordTransfer(self.control, program, name, direction, sent, back, outcome)
        carry_out(self.store, request, By(user_name(), Role.OPERATOR), datetime.now(UTC))


def _said(one: Difference) -> str:
    words = ", ".join(f"{word.what} {word.before!r} {word.after!r}" for word in one.words)
    return f"line {one.line or one.other_line} {words or f'{one.before!r} {one.after!r}'}"
