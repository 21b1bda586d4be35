"""What was done to accounts and keys, in the event log, in the transaction that did it."""

import json
from collections.abc import Mapping
from datetime import datetime

from sqlalchemy import Connection, insert

from trueloop.storage.factory_tables import EVENT, stamp


def note(connection: Connection, now: datetime, who: str, what: str, subject: str, values: Mapping[str, str]) -> None:
    """Writes a line of the event log."""
    document = json.dumps(dict(values), ensure_ascii=False)
    connection.execute(insert(EVENT).values(at=stamp(now), who=who, what=what, subject=subject, document=document))
