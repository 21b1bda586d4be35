"""The acceptance of a proposal: each refusal names what overrides it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Final, Literal

from trueloop.domain.life import Identity
from trueloop.domain.proposal import Proposal, ProposalClass, ProposalDecision
from trueloop.errors import Code, TrueloopError
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.loops.post_process.tracked import TrackedSeries
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

SAME_MM: Final = 1e-9

OVERRIDES: Final[Mapping[Code, str]] = {
    Code.SER_LARGE: "large",
    Code.SER_OLD: "old",
    Code.SER_SUPERSEDED: "superseded",
    Code.SER_ALARM: "alarm",
}
"""The names by which a user overrides refusals; those not listed are final."""


def decide(
    proposal: Proposal,
    verdict: Literal["accepted", "rejected"],
    who: str,
    now: datetime,
    series: Mapping[Identity, TrackedSeries],
    earlier: Sequence[ProposalDecision],
    options: SeriesOptions,
    *,
    why: str = "",
    override: Collection[str] = (),
) -> ProposalDecision:
    """Decides on a proposal. `series` are those of its part type as they are now, by identity.

    Raises SER-DECIDED; of an acceptance SER-LARGE, SER-OLD, SER-SUPERSEDED and SER-ALARM that `override` does not name.
    """
    for one in earlier:
        if one.proposal == proposal.id:
            raise Code.SER_DECIDED.refusal(
                f"proposal {proposal.id} was {one.verdict} by {one.who} on {one.at:%Y-%m-%d %H:%M}",
                hint="`trueloop series propose` makes another one when a further part is in",
                values={"proposal": proposal.id},
            )
    overridden: list[str] = []
    for refusal in _refusals(proposal, now, series, options) if verdict == "accepted" else ():
        if OVERRIDES[refusal.code] not in override:
            raise refusal
        overridden.append(refusal.code)
    return ProposalDecision(proposal.id, verdict, who, now, why, overrides=tuple(dict.fromkeys(overridden)))


def _refusals(
    proposal: Proposal, now: datetime, series: Mapping[Identity, TrackedSeries], options: SeriesOptions
) -> Iterator[TrueloopError]:
    yield from _superseded(proposal, series)
    yield from _large(proposal, options)
    yield from _old(proposal, now, options)
    yield from _alarm(proposal, series)


def _override(code: Code) -> str:
    return f"--override {OVERRIDES[code]}"


def _superseded(proposal: Proposal, series: Mapping[Identity, TrackedSeries]) -> Iterator[TrueloopError]:
    for effect in proposal.effects:
        now = series.get(effect.series)
        if now is None or not now.series.latest:
            why = f"the nominal or the limits of {effect.characteristic!r} have changed since"
        elif len(now.parts) != effect.parts or now.last.made.serial != proposal.last_serial:
            why = f"it rests on {effect.parts} parts of {effect.characteristic!r}, now there are {len(now.parts)}"
        elif abs(now.in_force_mm - effect.in_force_mm) > SAME_MM:
            why = f"another proposal of {effect.characteristic!r} was accepted since"
        else:
            continue
        yield Code.SER_SUPERSEDED.refusal(
            f"proposal {proposal.id} is superseded: {why}",
            hint="`trueloop series propose` makes one of the parts there are now",
            override=_override(Code.SER_SUPERSEDED),
            values={"proposal": proposal.id},
        )
        return


def _large(proposal: Proposal, options: SeriesOptions) -> Iterator[TrueloopError]:
    for effect in proposal.effects:
        if abs(effect.size_change_mm) > options.largest_mm:
            size_um, limit_um = effect.size_change_mm * UM_PER_MM, options.largest_mm * UM_PER_MM
            yield Code.SER_LARGE.refusal(
                f"proposal {proposal.id} changes {effect.characteristic!r} by {size_um:+.1f} µm; the limit is "
                f"{limit_um:.1f} µm",
                hint="a constant this large is likelier a wrong datum, unit or nominal than an error of the machine",
                override=f"{_override(Code.SER_LARGE)}, or a larger --max-um",
                values={"characteristic": effect.characteristic, "size_um": size_um, "limit_um": limit_um},
            )
            return


def _old(proposal: Proposal, now: datetime, options: SeriesOptions) -> Iterator[TrueloopError]:
    age_h = (now - proposal.made_at).total_seconds() / 3600
    if 0.0 <= age_h <= options.age_hours:
        return
    when = f"{proposal.made_at:%Y-%m-%d %H:%M}"
    limit = f"the limit is {options.age_hours:g} h" if age_h > 0 else "a clock was set back"
    yield Code.SER_OLD.refusal(
        f"proposal {proposal.id} was made {age_h:.1f} h ago ({when}); {limit}",
        hint="the tool has cut since; propose anew from the latest parts",
        override=f"{_override(Code.SER_OLD)}, or another --max-age-h",
        values={"proposal": proposal.id, "age_h": age_h},
    )


def _alarm(proposal: Proposal, series: Mapping[Identity, TrackedSeries]) -> Iterator[TrueloopError]:
    if proposal.changes is ProposalClass.MEMORY:  # it is the answer to the alarm
        return
    for effect in proposal.effects:
        now = series.get(effect.series)
        alarm = None if now is None else now.open_alarm
        if alarm is None:
            continue
        yield Code.SER_ALARM.refusal(
            f"{effect.characteristic!r} is under alarm since part {alarm.made.serial!r}: "
            f"{alarm.made.error_mm * UM_PER_MM:+.1f} µm found, {(alarm.expected_mm or 0.0) * UM_PER_MM:+.1f} ± "
            f"{NORMAL_95 * (alarm.expected_u_mm or 0.0) * UM_PER_MM:.1f} µm expected",
            hint="find the cause; then accept the proposal that begins memory anew from that part, or inspect two more",
            override=_override(Code.SER_ALARM),
            values={"characteristic": effect.characteristic},
        )
        return
