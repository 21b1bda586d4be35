"""What attempts to get in cost: after some that failed each further one has to wait, per account and per address.

An attempt is noted before the password is looked at, and taken back when it was right: of a hundred at once no more
get through than one after the other. Names are noted as hashes: people type passwords where the name belongs.
"""

from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from typing import Any, Final

from sqlalchemy import Connection, delete, func, insert, select

from trueloop.errors import Code, TrueloopError
from trueloop.storage.factory_tables import ATTEMPT, stamp
from trueloop.storage.store import Store


@dataclass(frozen=True)
class Delays:
    """`free` attempts, then 1, 2, 4 … seconds after the last one, at most `longest_s`."""

    free: int
    longest_s: float

    def after(self, failed: int) -> float:
        """How long the next attempt has to wait after so many failed ones, s."""
        return min(2.0 ** min(failed - self.free, 30), self.longest_s) if failed >= self.free else 0.0


OF_ACCOUNT: Final = Delays(free=5, longest_s=60.0)
"""Short: otherwise anybody could lock anybody out."""
OF_ADDRESS: Final = Delays(free=20, longest_s=900.0)
WINDOW: Final = timedelta(hours=1)
"""After it a failed attempt is forgotten."""


def begin(store: Store, name: str, address: str, now: datetime) -> int:
    """Notes an attempt as failed: its number, for `succeeded`. Raises SRV-DELAY where it comes too early."""
    subject = sha256(name.encode()).hexdigest()
    with store.writing() as connection:
        connection.execute(delete(ATTEMPT).where(ATTEMPT.c.failed_at < stamp(now - WINDOW)))
        wait_s = max(
            _wait_s(connection, ATTEMPT.c.subject == subject, OF_ACCOUNT, now),
            _wait_s(connection, ATTEMPT.c.address == address, OF_ADDRESS, now),
        )
        if wait_s > 0:
            raise too_early(wait_s)
        row = insert(ATTEMPT).values(subject=subject, address=address, failed_at=stamp(now)).returning(ATTEMPT.c.id)
        return int(connection.execute(row).scalar_one())


def succeeded(store: Store, attempt: int) -> None:
    """Forgets the attempts of that account from that address."""
    with store.writing() as connection:
        one = connection.execute(select(ATTEMPT).where(ATTEMPT.c.id == attempt)).one_or_none()
        if one is not None:
            same = (ATTEMPT.c.subject == one.subject) & (ATTEMPT.c.address == one.address)
            connection.execute(delete(ATTEMPT).where(same))


def too_early(wait_s: float) -> TrueloopError:
    """SRV-DELAY; whole seconds, as `Retry-After` has them."""
    seconds = int(wait_s) + 1
    return TrueloopError(
        Code.SRV_DELAY,
        f"too many attempts: the next one is taken in {seconds} s",
        hint="wait; an administrator can set a new password: trueloop user password NAME",
        values={"retry_after_s": float(seconds)},
    )


def _wait_s(connection: Connection, which: Any, delays: Delays, now: datetime) -> float:
    counted = select(func.count(), func.max(ATTEMPT.c.failed_at)).where(which)
    failed, last = connection.execute(counted).one()
    if not failed:
        return 0.0
    return delays.after(failed) - (now - datetime.fromisoformat(last)).total_seconds()
