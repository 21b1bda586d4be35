"""How a command keeps what it found, and what it says where that goes wrong."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from trueloop.errors import Finding, Severity, TrueloopError
from trueloop.jobs.store.where import Choice

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts


@dataclass(frozen=True)
class Keeping:
    """How a command keeps: in the store `db`; `serial` of the part where the job has none.

    `supersede`: what is stored with another content gives way; `accept`: codes of refusals that are to be warnings.
    """

    db: Choice = None
    serial: str | None = None
    supersede: bool = False
    accept: tuple[str, ...] = ()


@contextmanager
def accepting(codes: Collection[str], findings: list[Finding]) -> Iterator[None]:
    """Turns a refusal of one of these codes into a warning among the findings, if it has an override at all."""
    try:
        yield
    except TrueloopError as refused:
        if refused.code not in codes or refused.override is None:
            raise
        said = (refused.message, refused.hint, refused.place, refused.values)
        findings.append(Finding(Severity.WARNING, refused.code, *said))


@contextmanager
def kept_all_the_same(kept: "KeptFacts | None") -> Iterator[None]:
    """Adds to a refusal to write the outputs that the store has their content; None: there is no store."""
    try:
        yield
    except TrueloopError as refused:
        if kept is None:
            raise
        hint = f"{refused.hint}; {kept.words}: calling it again writes the files and keeps nothing twice"
        where, override, values = refused.place, refused.override, refused.values
        raise refused.code.refusal(
            refused.message, hint=hint, place=where, override=override, values=values
        ) from refused
