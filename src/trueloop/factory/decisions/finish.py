"""Checks before a program runs, above all before a finish cut: `checks_of`."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from typing import Final

from trueloop.domain.factory import BlockKind, StepState
from trueloop.domain.life import Identity
from trueloop.errors import Code
from trueloop.factory.known import OrderNow, PartNow, StepNow
from trueloop.wording import wording

AHEAD: Final = timedelta(seconds=60)
"""How far a cell's clock may be ahead of ours; beyond that nobody knows how old a value is."""


@dataclass(frozen=True)
class MachineFacts:
    """The last report of a machine; None: none came. `alarms` are the numbers of open ones that block it."""

    name: str
    calibrated_at: datetime | None = None
    temperature_at: datetime | None = None
    corrector: str = ""
    alarms: tuple[int, ...] = ()


@dataclass(frozen=True)
class CorrectionFacts:
    """The correction of a finish cut: its parts and programs; `probe_run`: the gauging run whose touches it is by."""

    id: str
    parts: tuple[Identity, ...]
    source_sha256: str
    corrected_sha256: str
    probe_run: str


@dataclass(frozen=True)
class Candidate:
    """The next step of a part, with what its checks need; `program`: its text, None where the store has none."""

    order: OrderNow
    part: PartNow
    step: StepNow
    program: bytes | None = None
    correction: CorrectionFacts | None = None


def checks_of(what: Candidate, machine: MachineFacts, now: datetime) -> tuple[str, ...]:
    """Returns what was checked, in words. Raises FAC errors for anything that is not in order."""
    found = (*_program(what),)
    return (*found, *_correction(what), *_machine(what, machine, now)) if what.step.kind is BlockKind.FINISH else found


def _program(what: Candidate) -> Iterator[str]:
    wanted = what.step.program_sha256
    found = "" if what.program is None else sha256(what.program).hexdigest()
    block = what.order.block(what.step.no)
    if not wanted or found != wanted or (not block.corrected and wanted != block.program_sha256):
        raise Code.FAC_PROGRAM.refusal(
            f"step {what.step.no} ({what.step.kind}) of part {what.part.value.serial!r}: the program accepted is "
            f"{wanted[:16] or 'none'!r}, the one in the store {found[:16] or 'none'!r}",
            hint="hold the part and look at its correction; nothing was sent",
            values={"accepted": wanted, "found": found},
        )
    yield f"program {wanted[:16]} as accepted"


def _correction(what: Candidate) -> Iterator[str]:
    block = what.order.block(what.step.no)
    if not block.corrected:
        return
    made, part, wanted = what.correction, what.part, what.step.program_sha256
    probes = [step for step in part.steps if step.kind is BlockKind.PROBE]
    if made is None or made.corrected_sha256 != wanted or made.source_sha256 != block.program_sha256:
        found = "none" if made is None else made.corrected_sha256
        raise Code.FAC_PROGRAM.refusal(
            f"part {part.value.serial!r}: no correction in the store leads from program {block.program_sha256[:16]!r} "
            f"to {wanted[:16]!r}, but to {found[:16]!r}",
            hint="hold the part; run its step 'correct' anew",
            values={"accepted": wanted, "found": found},
        )
    own = all(one == part.value.identity for one in made.parts) and made.parts
    if not own or made.probe_run not in [probe.run for probe in probes if probe.state is StepState.RECORDED]:
        raise Code.FAC_TOUCHES.refusal(
            f"correction {made.id!r} was made from touches of {'; '.join(map(_part_words, made.parts)) or 'no part'} "
            f"in run {made.probe_run!r}, not of part {part.value.serial!r}",
            hint="probe this part, and correct from its own touches",
            values={"run": made.probe_run},
        )
    yield f"correction {made.id} from this part's touches"


def _part_words(identity: Identity) -> str:
    """Returns a part in words: `shaft rev B serial b`."""
    name, revision, serial = identity
    return name + (f" rev {revision}" if revision else "") + (f" serial {serial}" if serial else "")


def _machine(what: Candidate, machine: MachineFacts, now: datetime) -> Iterator[str]:
    asked = what.order.order.route.conditions
    for code, name, at, limit in (
        (Code.FAC_CALIBRATION, "the calibration of the probe", machine.calibrated_at, asked.calibration_age_s),
        (Code.FAC_TEMPERATURE, "the latest temperature", machine.temperature_at, asked.temperature_age_s),
    ):
        if limit is not None:
            yield _fresh(code, machine.name, name, at, limit, now)
    planned = asked.model_sha256
    if planned is not None and machine.corrector != (planned or "off"):
        raise Code.FAC_CORRECTOR.refusal(
            f"machine {machine.name!r}: the corrector is to be {planned or 'off'!r} and is {machine.corrector!r}",
            hint="load the planned model, or plan the order for the one that is in force",
            values={"planned": planned or "off", "found": machine.corrector},
        )
    if machine.alarms:
        raise Code.FAC_ALARM.refusal(
            wording("alarm {alarm} ({n} in all) is not acknowledged", alarm=machine.alarms[0], n=len(machine.alarms)),
            hint=wording("look at it and acknowledge it; then the finish cut is offered"),
            values={"alarm": float(machine.alarms[0])},
        )
    yield "no alarm is open"


def _fresh(code: Code, machine: str, name: str, at: datetime | None, limit_s: float, now: datetime) -> str:
    age_s = None if at is None else (now - at).total_seconds()
    if age_s is not None and -AHEAD.total_seconds() <= age_s <= limit_s:
        return f"{name} is {max(age_s, 0.0):.0f} s old"
    said = "is not known" if age_s is None else f"is {age_s:.0f} s old"
    raise code.refusal(
        f"machine {machine!r}: {name} {said}; the limit is {limit_s:g} s",
        hint="calibrate the probe or have the cell send temperatures; an order may be planned without this",
        values={"machine": machine, "limit_s": limit_s},
    )
