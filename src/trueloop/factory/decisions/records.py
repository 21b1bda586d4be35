"""Decisions that add a record: releases, transfers, calibrations, certificates, alarms, proposals, tools."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from json import dumps

from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.domain.proposal import Proposal
from trueloop.domain.tool import Edge
from trueloop.errors import Code, TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.book import Book
from trueloop.factory.decisions.plan import not_released
from trueloop.factory.known import Changes, Event, unknown
from trueloop.factory.requests import By, require_machine
from trueloop.loops.post_process.decide import decide
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.storage.schema import stamp
from trueloop.wording import wording


@dataclass(frozen=True)
class ProgramFacts:
    """State of a program in the store: text known, released."""

    known: bool
    released: bool


@dataclass(frozen=True)
class ProposalFacts:
    """A proposal with the book of its part type; None: there is no such proposal."""

    proposal: Proposal | None
    book: Book | None


def release_program(facts: ProgramFacts, request: ask.ReleaseProgram, by: By, now: datetime) -> Changes:
    """Releases a program of the store, once. Raises FAC-UNKNOWN."""
    if not facts.known:
        raise unknown(wording("program"), request.program_sha256[:16], wording("the store has no text of that hash"))
    if facts.released:
        return Changes()
    row = {"program_sha256": request.program_sha256, "at": stamp(now), "who": by.name, "why": request.why}
    event = Event("released", f"program:{request.program_sha256}", {"why": request.why})
    return Changes(rows=(("program_release", row),), events=(event,))


def record_transfer(facts: ProgramFacts, request: ask.RecordTransfer, by: By, now: datetime) -> Changes:
    """Records a transfer, as it went. Raises FAC-RELEASE for a program sent that is not released."""
    if request.direction == "to" and not facts.released:
        raise not_released(request.program_sha256)
    row = {
        **{"at": stamp(now), "who": by.name, "control": request.control, "program_sha256": request.program_sha256},
        **{"name": request.name, "direction": request.direction, "sent_sha256": request.sent_sha256},
        **{"read_back_sha256": request.read_back_sha256, "outcome": request.outcome, "document": "{}"},
    }
    said = {"control": request.control, "name": request.name, "outcome": request.outcome}
    return Changes(rows=(("transfer", row),), events=(Event("transfer", f"program:{request.program_sha256}", said),))


def calibrated(facts: None, request: ask.Calibrated, by: By, now: datetime) -> Changes:
    """Records that the probe of a machine was calibrated."""
    require_machine(by, request.machine)
    said = dumps(dict(request.values))
    row = {"machine": request.machine, "at": stamp(now), "who": by.name, "document": said}
    event = Event("calibrated", f"machine:{request.machine}", dict(request.values))
    return Changes(rows=(("calibration", row),), events=(event,))


def certify(facts: Collection[int], request: ask.Certify, by: By, now: datetime) -> Changes:
    """Keeps a certificate. `facts` are rows of parts that exist. Raises FAC-UNKNOWN."""
    if request.part not in facts:
        raise unknown(wording("part"), str(request.part), wording("the store has no such row"))
    hashed = sha256(request.content).hexdigest()
    row = {"part": request.part, "at": stamp(now), "who": by.name, "sha256": hashed}
    said = {"sha256": hashed, "verdict": request.verdict}
    more = {"verdict": request.verdict, "content": request.content}
    return Changes(rows=(("certificate", row | more),), events=(Event("certified", f"part:{request.part}", said),))


def raise_alarm(facts: None, request: ask.RaiseAlarm, by: By, now: datetime) -> Changes:
    """Raises an alarm; a cell raises those of its own machine alone."""
    require_machine(by, request.machine)
    row = {
        **{"at": stamp(now), "source": request.source, "code": request.code, "said": request.said},
        **{"document": dumps(dict(request.values)), "machine": request.machine, "part_type": request.part_type},
        "blocks": int(request.blocks),
    }
    said = {"source": request.source, "said": request.said}
    return Changes(rows=(("alarm", row),), events=(Event("alarm", f"alarm:{request.code}", said),))


def acknowledge(facts: bool | None, request: ask.Acknowledge, by: By, now: datetime) -> Changes:
    """Acknowledges an alarm. `facts`: whether it already is; None: no such alarm. Raises FAC-UNKNOWN, FAC-STALE."""
    if facts is None:
        raise unknown(wording("alarm"), str(request.alarm), wording("the store has no such alarm"))
    if facts:
        raise stale("open", "acknowledged")
    row = {"alarm": request.alarm, "at": stamp(now), "who": by.name, "why": request.why}
    event = Event("acknowledged", f"alarm:{request.alarm}", {"why": request.why})
    return Changes(rows=(("alarm_acknowledged", row),), events=(event,))


def decide_proposal(facts: ProposalFacts, request: ask.DecideProposal, by: By, now: datetime) -> Changes:
    """Decides a proposal by the post-process loop's rules. Raises FAC-UNKNOWN, FAC-STALE where decided, SER errors."""
    if facts.proposal is None or facts.book is None:
        raise unknown(wording("proposal"), request.proposal, wording("the store has none of that id"))
    if (earlier := facts.book.verdict(facts.proposal)) is not None:
        raise stale("open", f"{earlier.verdict} by {earlier.who}")
    given = (facts.book.by_identity, facts.book.decisions, SeriesOptions())
    why, overrides = request.why, request.overrides
    decision = decide(facts.proposal, request.verdict, by.name, now, *given, why=why, override=overrides)
    said = {"verdict": request.verdict, "why": why, "overrides": ", ".join(overrides)}
    return Changes(keep=(decision,), events=(Event(request.verdict, f"proposal:{request.proposal}", said),))


def set_tool(facts: Edge | None, request: ask.SetTool, by: By, now: datetime) -> Changes:
    """Records that an edge was set. `facts`: the edge as the store has it. Raises FAC-UNKNOWN."""
    if facts is None:
        raise unknown(wording("edge"), "/".join(request.edge), wording("the store has no such edge"))
    event = EdgeEvent(facts, EdgeEventKind.SET, request.set_at, by.name)
    said = {"set_at": request.set_at.isoformat()}
    return Changes(keep=(event,), events=(Event("set", f"edge:{'/'.join(request.edge)}", said),))


def stale(expected: str, version: str) -> TrueloopError:
    """Returns the error FAC-STALE."""
    return Code.FAC_STALE.refusal(
        wording("it was {expected!r} when it was read and is {now!r} now", expected=expected, now=version),
        hint=wording("read it again, and decide on what it is now"),
        values={"expected": expected, "found": version},
    )
