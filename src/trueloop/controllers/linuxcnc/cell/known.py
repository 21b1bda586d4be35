"""What a journal says: the run in hand, runs that are over, and what the service has not acknowledged."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Final

from trueloop.controllers.linuxcnc.cell.journal import Entry
from trueloop.domain.factory import FactKind

TOLD: Final = ("fact", "touches", "temperatures")
"""Kinds of entries that the service is to have."""


@dataclass(frozen=True)
class RunNow:
    """A run in hand. `touches`: the file that its program writes; `facts`: what is noted of it.

    `opened`: the control was given it; `begun`: the client was about to start it; `withdrawn`: the service no longer
    offers it; `differs`: what was read back is not what was sent.
    """

    key: str
    sent_sha256: str
    touches: str = ""
    facts: frozenset[FactKind] = frozenset()
    opened: bool = False
    begun: bool = False
    withdrawn: bool = False
    differs: bool = False
    gathered: bool = False

    @property
    def program(self) -> str:
        """Returns the name of its file at the control."""
        return f"{self.key}.ngc"


@dataclass(frozen=True)
class Known:
    """`run`: None where none is in hand; `over`: keys that never run again; `waiting`: entries for the service."""

    run: RunNow | None = None
    over: frozenset[str] = frozenset()
    waiting: tuple[Entry, ...] = ()
    refused: tuple[Any, ...] = field(default=())


def known(entries: Iterable[Entry]) -> Known:
    """Folds the entries of a journal into what is known."""
    now = Known()
    for entry in entries:
        now = with_entry(now, entry)
    return now


def with_entry(now: Known, entry: Entry) -> Known:
    """Returns the state after one more entry."""
    values = entry.values
    if entry.what in TOLD:
        now = replace(now, waiting=(*now.waiting, entry))
    if entry.what == "run":
        return replace(now, run=RunNow(values["key"], values["sent_sha256"], values["touches"]))
    if entry.what in ("acknowledged", "refused"):
        left = tuple(one for one in now.waiting if one.no not in values["entries"])
        refused = (*now.refused, dict(values)) if entry.what == "refused" else now.refused
        return replace(now, waiting=left, refused=refused)
    run = now.run
    if run is None or values.get("run") != run.key:
        return now
    if entry.what == "closed":
        return replace(now, run=None, over=now.over | {run.key})
    return replace(now, run=_with(run, entry))


def _with(run: RunNow, entry: Entry) -> RunNow:
    if entry.what == "fact":
        what = FactKind(entry.values["what"])
        read = entry.values["values"].get("read_back_sha256", run.sent_sha256)
        return replace(run, facts=run.facts | {what}, differs=run.differs or read != run.sent_sha256)
    if entry.what in ("touches", "no-touches"):
        return replace(run, gathered=True)
    return replace(
        run,
        opened=run.opened or entry.what == "opened",
        begun=run.begun or entry.what == "begun",
        withdrawn=run.withdrawn or entry.what == "withdrawn",
    )
