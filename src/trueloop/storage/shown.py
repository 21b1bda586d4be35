"""A store's file or URL as it may be printed: `shown`. It needs no database's package, for it stands in messages."""

import re
from typing import Final

_BEFORE_HOST: Final = re.compile(r"(?<=://)([^/:?]*):.*@", re.DOTALL)
"""User and password: to the last `@`, for passwords are pasted with one in them."""
_IN_QUERY: Final = re.compile(r"([?&][^=&]*(?:pass|secret|%)[^=&]*=)[^&]*", re.IGNORECASE)
"""`password`, `sslpassword`, and names written with `%`, in which these could hide."""


def shown(place: str) -> str:
    """A store's file or URL without its passwords, whether they stand before the host or in the query.

    >>> shown("postgresql://ana:secret@plant/parts")
    'postgresql://ana:***@plant/parts'
    >>> shown("postgresql://ana@plant/parts?password=secret&sslmode=require")
    'postgresql://ana@plant/parts?password=***&sslmode=require'
    """
    if "://" not in place:
        return place
    return _IN_QUERY.sub(r"\1***", _BEFORE_HOST.sub(r"\1:***@", place))
