"""Places in lists, signed: what a cursor says is what this service said, and another list's does not fit."""

import hmac
import json
from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections.abc import Sequence
from typing import Annotated, Final

from fastapi import Query

from trueloop.errors import Code, TrueloopError

Limit = Annotated[int, Query(ge=1, le=500)]
Cursor = Annotated[str | None, Query(max_length=1000)]
_SIGNED: Final = 16


def cursor_of(secret: bytes, of: str, after: Sequence[str | int]) -> str:
    """Makes the cursor of the list `of` (its address and the request), after the row with these values."""
    said = json.dumps(list(after)).encode()
    return urlsafe_b64encode(_signature(secret, of, said) + said).decode().rstrip("=")


def place_of(secret: bytes, of: str, cursor: str) -> list[str | int]:
    """Returns the values that `cursor_of` was given. Raises SRV-CURSOR for anything else."""
    try:
        raw = urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4))
    except ValueError:
        raise _refused(cursor) from None
    signature, said = raw[:_SIGNED], raw[_SIGNED:]
    if not hmac.compare_digest(signature, _signature(secret, of, said)):
        raise _refused(cursor)
    found: list[str | int] = json.loads(said)
    return found


def _signature(secret: bytes, of: str, said: bytes) -> bytes:
    return hmac.digest(secret, of.encode() + b"\n" + said, "sha256")[:_SIGNED]


def _refused(cursor: str) -> TrueloopError:
    return Code.SRV_CURSOR.refusal(
        f"{cursor[:40]!r} is no place in this list that this service gave since it was started",
        hint="ask for the list from its beginning, without cursor",
    )
