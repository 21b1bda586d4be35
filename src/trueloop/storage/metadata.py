"""The one collection of all tables of a store: `METADATA`."""

from typing import Final

from sqlalchemy import MetaData

METADATA: Final = MetaData()
