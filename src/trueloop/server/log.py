"""The service's log: one JSON object a line on stderr, with no cookie, key, password or body in it."""

import json
import sys
from datetime import UTC, datetime
from threading import Lock
from typing import Final

_ONE: Final = Lock()


def log(what: str, **values: object) -> None:
    """Writes one line. JSON escapes what would end it: nobody writes a line of his own into it."""
    line = json.dumps({"at": datetime.now(UTC).isoformat(timespec="milliseconds"), "what": what, **values}, default=str)
    with _ONE:
        sys.stderr.write(line + "\n")
        sys.stderr.flush()
