"""Cost of attempts to sign in: after some that failed each further one has to wait, per account and per address.

They are counted in this process by a clock that is never set. An attempt counts as failed while it is being looked at:
of a hundred at once no more get through than one after the other, and the rest wait until the first are judged.
Names are kept as hashes: people type passwords where the name belongs.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from threading import Condition
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.wording import wording


@dataclass(frozen=True)
class Delays:
    """`free` attempts, then 1, 2, 4 … seconds after the last one, at most `longest_s`."""

    free: int
    longest_s: float

    def after(self, failed: int) -> float:
        """Returns how long the next attempt has to wait after so many failed ones, s."""
        return min(2.0 ** min(failed - self.free, 30), self.longest_s) if failed >= self.free else 0.0


OF_ACCOUNT: Final = Delays(free=5, longest_s=60.0)
"""Short: otherwise anybody could lock anybody out."""
OF_ADDRESS: Final = Delays(free=20, longest_s=900.0)
WINDOW_S: Final = 3600.0
"""After it a failed attempt is forgotten."""
MOST: Final = 10_000
"""So many failed attempts are remembered, the latest."""
PATIENCE_S: Final = 20.0
"""So long an attempt waits for others that are being looked at."""


@dataclass(frozen=True)
class _Attempt:
    subject: str
    address: str
    at_s: float


class Attempts:
    """Those on one service. `seconds`: a clock that only goes on."""

    def __init__(self, seconds: Callable[[], float] = time.monotonic) -> None:
        self._seconds = seconds
        self._failed: list[_Attempt] = []
        self._pending: list[_Attempt] = []
        self._changed = Condition()

    @contextmanager
    def attempt(self, name: str, address: str) -> Iterator[None]:
        """Yields for an attempt, which the block judges: raising SRV-LOGIN is a failure, raising nothing a success.

        Raises SRV-DELAY where it comes too early. One that is right makes those before it, of that account from that
        address, forgotten.
        """
        one = self._begin(_Attempt(sha256(name.encode()).hexdigest(), address, self._seconds()))
        try:
            yield
        except BaseException as error:
            self._end(one, failed=isinstance(error, TrueloopError) and error.code is Code.SRV_LOGIN)
            raise
        self._end(one, right=True)

    def _begin(self, attempt: _Attempt) -> _Attempt:
        until_s = time.monotonic() + PATIENCE_S
        with self._changed:
            while True:
                now_s = self._seconds()
                self._failed = [other for other in self._failed if now_s - other.at_s < WINDOW_S][-MOST:]
                of_account = self._count(OF_ACCOUNT, lambda other: other.subject == attempt.subject, now_s)
                of_address = self._count(OF_ADDRESS, lambda other: other.address == attempt.address, now_s)
                if (wait_s := max(of_account[0], of_address[0])) > 0:
                    raise too_early(wait_s)
                if of_account[1] and of_address[1]:
                    self._pending.append(attempt)
                    return attempt
                if not self._changed.wait(until_s - time.monotonic()):
                    raise too_early(1.0)

    def _count(self, delays: Delays, which: Callable[[_Attempt], bool], now_s: float) -> tuple[float, bool]:
        """How long to wait, s, and whether there is room beside those that are being looked at."""
        failed = [other.at_s for other in self._failed if which(other)]
        wait_s = delays.after(len(failed)) - (now_s - max(failed)) if failed else 0.0
        return wait_s, sum(map(which, self._pending)) < max(1, delays.free - len(failed))

    def _end(self, attempt: _Attempt, *, failed: bool = False, right: bool = False) -> None:
        same = (attempt.subject, attempt.address)
        with self._changed:
            self._pending.remove(attempt)
            if failed:
                self._failed.append(attempt)
            if right:
                self._failed = [other for other in self._failed if (other.subject, other.address) != same]
            self._changed.notify_all()


def too_early(wait_s: float) -> TrueloopError:
    """Makes the error SRV-DELAY; whole seconds, as `Retry-After` has them."""
    seconds = int(wait_s) + 1
    return Code.SRV_DELAY.refusal(
        wording("too many attempts: the next one is taken in {seconds} s", seconds=seconds),
        hint=wording("wait; an administrator can set a new password: trueloop user password NAME"),
        values={"retry_after_s": float(seconds)},
    )
