"""POSTs done once: the answer is kept under the caller's key, and given again instead of doing it again.

A refusal is not kept: nothing was changed, and asked again it is judged anew. What was begun and never answered (the
service was killed) is not repeated: the caller is told to look, and, where the change is known to be made
(`carry_out` notes it in the change's own transaction), that it is.
"""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

from sqlalchemy import delete, insert, select, update

from trueloop.errors import Code, TrueloopError
from trueloop.storage.schema import BEGUN, DONE, IDEMPOTENCY, stamp
from trueloop.storage.store import Store

KEPT: Final = timedelta(days=7)
LONGEST_KEY: Final = 128


@dataclass(frozen=True)
class Answer:
    """As it was given the first time."""

    status: int
    body: bytes


@dataclass(frozen=True)
class KeyedRequest:
    """Who asked for what, under which key; `request_sha256` of method, address and body."""

    who: str
    key: str
    request_sha256: str


def begin(store: Store, request: KeyedRequest, now: datetime) -> Answer | None:
    """Returns the answer given before; None: do it now, then `finish` or `give_up`. Raises SRV-REUSED."""
    mine = (IDEMPOTENCY.c.account == request.who) & (IDEMPOTENCY.c.key == request.key)
    with store.writing() as connection:
        connection.execute(delete(IDEMPOTENCY).where(IDEMPOTENCY.c.created_at < stamp(now - KEPT)))
        found = connection.execute(select(IDEMPOTENCY).where(mine)).one_or_none()
        if found is None:
            row = {"account": request.who, "key": request.key, "request_sha256": request.request_sha256}
            connection.execute(insert(IDEMPOTENCY).values(**row, status=BEGUN, body=b"", created_at=stamp(now)))
            return None
    if found.request_sha256 != request.request_sha256:
        raise _reused(request.key, "was used for another request", "take a new key for a new request")
    if found.status == BEGUN:
        raise _reused(
            request.key,
            f"was begun at {found.created_at} and has no answer yet",
            "wait, then look whether it was done; take a new key only if it was not",
        )
    if found.status == DONE:
        raise _reused(
            request.key,
            f"of {found.created_at} was done, and its answer was lost",
            "look at what it has changed; under a new key it would be done again",
        )
    if not found.body:
        raise _reused(request.key, "was answered, and that answer is given once only", "take a new key")
    return Answer(found.status, bytes(found.body))


def finish(store: Store, request: KeyedRequest, answer: Answer) -> None:
    """Keeps the answer; without a body it is known only that it was given."""
    mine = (IDEMPOTENCY.c.account == request.who) & (IDEMPOTENCY.c.key == request.key)
    with store.writing() as connection:
        connection.execute(update(IDEMPOTENCY).where(mine).values(status=answer.status, body=answer.body))


def give_up(store: Store, request: KeyedRequest) -> None:
    """Frees the key of a request that was refused and changed nothing."""
    mine = (IDEMPOTENCY.c.account == request.who) & (IDEMPOTENCY.c.key == request.key) & (IDEMPOTENCY.c.status == BEGUN)
    with store.writing() as connection:
        connection.execute(delete(IDEMPOTENCY).where(mine))


def _reused(key: str, why: str, hint: str) -> TrueloopError:
    return Code.SRV_REUSED.refusal(f"the Idempotency-Key {key!r} {why}", hint=hint, values={"key": key})
