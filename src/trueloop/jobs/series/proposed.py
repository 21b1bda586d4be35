"""Proposals made, kept, decided, and written in a control's words or into its tool table."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from trueloop.domain.proposal import Proposal, ProposalClass, ProposalDecision
from trueloop.domain.tool_offset import ToolOffset
from trueloop.errors import Code, TrueloopError
from trueloop.factory.book import Book, read_book
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.tool_tables.known import read_tool_table
from trueloop.formats.tables.tool_tables.new_table import new_table
from trueloop.formats.tables.tool_tables.tool_table import Unit, XIs
from trueloop.jobs.series.tools_of_job import tools_of_job
from trueloop.jobs.user import user_name
from trueloop.loops.post_process.by_tool import tool_proposals
from trueloop.loops.post_process.decide import decide
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.propose import Made, proposals_of
from trueloop.storage.store import Store, find, keep
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.program.wear_words import CONTROLS, Control, counted, offset_program


@dataclass(frozen=True)
class Proposed:
    """Proposals that hold now, as the store has them, with what was decided; `new` are ids of those made now.

    `not_accepted` says why a proposal of an automatic class waits all the same.
    """

    book: Book
    proposals: tuple[Proposal, ...]
    new: frozenset[str]
    not_accepted: tuple[str, ...] = ()


def propose(store: Store, book: Book, options: SeriesOptions, job: Path | None = None) -> Proposed:
    """What the series propose for the next part, kept; classes switched to automatic are accepted at once.

    With a job the offsets are those of its tools. Raises JOB, NC and SER-TOOL errors.
    """
    made = Made(user_name(), datetime.now(UTC))
    found = list(proposals_of(book.tracked, options, made))
    if job is not None:
        found = [one for one in found if one.changes is not ProposalClass.TOOL_OFFSET]
        found += tool_proposals(book.tracked, tools_of_job(job, book), options, made)
    known = {one.id: one for one in book.proposals}
    kept = keep(store, [one for one in found if one.id not in known])
    proposals = tuple(known.get(one.id, one) for one in found)
    waiting: list[str] = []
    for one in proposals:
        if one.changes in options.automatic and book.verdict(one) is None:
            try:
                decision = decision_on(book, one, "accepted", options, why="its class is automatic")
                keep(store, [replace(decision, automatic=True)])
            except TrueloopError as refused:
                waiting.append(str(refused))
    new = frozenset(one.value.id for one in kept if one.new)
    return Proposed(read_book(store, book.part_type, options), proposals, new, tuple(waiting))


def decision_on(
    book: Book,
    proposal: Proposal,
    verdict: Literal["accepted", "rejected"],
    options: SeriesOptions,
    *,
    who: str = "",
    why: str = "",
    override: Collection[str] = (),
) -> ProposalDecision:
    """The decision on a proposal as the book stands. Raises SER errors that `override` does not name.

    Of two who decide at once the store takes the first: decisions have the proposal's identity.
    """
    now, series = datetime.now(UTC), book.by_identity
    by = who or user_name()
    return decide(proposal, verdict, by, now, series, book.decisions, options, why=why, override=override)


def proposal_named(store: Store, name: str) -> Proposal:
    """The proposal whose id begins so. Raises SER-PROPOSAL where there is none, or several."""
    every = [one.value for one in find(store, Proposal)]
    found = [one for one in every if one.id.startswith(name)]
    if len(found) == 1 and name:
        return found[0]
    raise TrueloopError(
        Code.SER_PROPOSAL,
        f"{name!r} is the beginning of {len(found)} of {len(every)} proposals",
        hint="`trueloop series status` lists those that wait for a decision",
        values={"proposal": name},
    )


def accepted(
    store: Store,
    name: str,
    options: SeriesOptions,
    where: "Written | None",
    *,
    who: str,
    why: str,
    override: Collection[str],
) -> tuple[Proposal, ProposalDecision, Path | None]:
    """Accepts a proposal by its id and writes its tool offset; where that cannot be written nothing is accepted."""
    proposal = proposal_named(store, name)
    book = read_book(store, proposal.part_type.name, options)
    decision = decision_on(book, proposal, "accepted", options, who=who, why=why, override=override)
    file = None if where is None else write_offset(proposal, where)
    keep(store, [decision])
    return proposal, decision, file


def rejected(store: Store, name: str, *, who: str, why: str) -> tuple[Proposal, ProposalDecision]:
    """Rejects a proposal by its id."""
    proposal, options = proposal_named(store, name), SeriesOptions()
    book = read_book(store, proposal.part_type.name, options)
    decision = decision_on(book, proposal, "rejected", options, who=who, why=why)
    keep(store, [decision])
    return proposal, decision


@dataclass(frozen=True)
class Written:
    """Where an accepted offset is to be written: in a control's words, or into a copy of its tool table.

    `control` None: that of the job's program; `x_is` None: as that counts.
    """

    output: Path
    control: Control | None = None
    table: Path | None = None
    unit: Unit | None = None
    x_is: XIs | None = None


def write_offset(proposal: Proposal, where: Written) -> Path:
    """Writes an accepted proposal's tool offset. Raises OFS-NONE where it has none, OFS and OUT errors."""
    offset = _offset_of(proposal)
    if where.table is not None:
        table = read_tool_table(where.table, where.unit)
        content, inputs = new_table(table, offset, proposal.id).content, [where.table]
    else:
        control = where.control or _control_of(proposal)
        counts = (where.x_is or offset.x_is) if control == proposal.control else counted(control, where.x_is)
        content, inputs = offset_program(control, WearOffset.of(offset, counts), proposal.id).encode(), []
    (written,) = write_all(where.output.parent, [(where.output.name, content)], inputs)
    return written


def _control_of(proposal: Proposal) -> Control:
    """That of the job's program; where there is none of ours, one without words, which says so."""
    return next((one for one in CONTROLS if one == proposal.control), "heidenhain")


def _offset_of(proposal: Proposal) -> ToolOffset:
    if proposal.tool_offset is None:
        names = ", ".join(map(repr, proposal.characteristics))
        raise TrueloopError(
            Code.OFS_NONE,
            f"proposal {proposal.id} changes {names} and names no tool",
            hint="`trueloop series propose --job JOB.toml` proposes the offset of the job's tool",
        )
    return proposal.tool_offset
