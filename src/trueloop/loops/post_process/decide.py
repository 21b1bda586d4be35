"""The acceptance of a proposal: each refusal names what overrides it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Identity
from trueloop.domain.part import PartType
from trueloop.domain.proposal import Proposal, ProposalClass, ProposalDecision
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.loops.post_process.series import LEAST_PARTS, PartSeen, Series, SeriesOptions, identity_of, sizes_of
from trueloop.loops.post_process.tracked import TrackedSeries
from trueloop.statistics import NORMAL_95
from trueloop.units import MM_PER_INCH, UM_PER_MM

EXACT_MM: Final = 1e-9
"""Values this close to the nominal were not measured, or rounded to it."""
SHARE_FILLED_IN: Final = 0.75
"""A part of which so many values, two at least, are exactly nominal is taken as filled in."""
SAME_RATIO: Final = 1e-3
"""Nominals whose ratio is 25.4 to this share differ by their unit."""
NEAR_RATIO: Final = 0.05
"""Value and nominal whose ratio is 25.4 to this share differ by their unit: they differ by the error too."""


def filled_in(inspection: Inspection) -> bool:
    """Returns whether a part's values look filled in and not measured: at least two and three quarters are nominal."""
    sizes = list(sizes_of(inspection))
    exact = sum(abs(error_mm) <= EXACT_MM for _, error_mm in sizes)
    return exact >= max(2.0, SHARE_FILLED_IN * len(sizes))


def nominal_findings(inspection: Inspection, *, used: bool) -> Iterator[Finding]:
    """Yields SER-NOMINAL: a part that looks filled in, or single values that are exactly nominal."""
    sizes, serial = list(sizes_of(inspection)), inspection.part.serial
    exact = [asked.name for asked, error_mm in sizes if abs(error_mm) <= EXACT_MM]
    if not exact:
        return
    if filled_in(inspection):
        what = "it counts all the same" if used else "it is left out"
        message = f"part {serial!r}: {len(exact)} of {len(sizes)} values are exactly nominal; {what}"
        hint = "such values are filled in, not measured: ask who measured; `--take-nominal` uses them"
        yield Finding(Severity.WARNING, Code.SER_NOMINAL, message, hint, values=_part(serial))
    else:
        message = f"part {serial!r}: {', '.join(map(repr, exact))} exactly nominal, of {len(sizes)} values"
        hint = "a value may be by chance; look whether it was measured. It counts"
        yield Finding(Severity.NOTE, Code.SER_NOMINAL, message, hint, values=_part(serial))


def _part(serial: str) -> Mapping[str, str]:
    return {"part": serial}


def unit_findings(characteristics: Mapping[str, Characteristic], inspection: Inspection) -> Iterator[Finding]:
    """Yields SER-UNIT, an error: sizes 25.4 times, or a 25.4th of, those known of the series or their nominal."""
    for asked, error_mm in sizes_of(inspection):
        before = characteristics.get(asked.name)
        against = before.nominal if before is not None else asked.nominal
        for value, near, what in (
            (asked.nominal, SAME_RATIO, "nominal"),
            (asked.nominal + error_mm, NEAR_RATIO, "value"),
        ):
            factor = _inches(value, against, near)
            if factor is not None:
                yield Finding(
                    Severity.ERROR,
                    Code.SER_UNIT,
                    f"part {inspection.part.serial!r}: the {what} of {asked.name!r}, {value:.4f} mm, is {factor:.4g} "
                    f"times the {against:.4f} mm of the series: a file in another unit",
                    "state the unit of the file: `--unit mm` or `--unit inch`",
                    values={"part": inspection.part.serial, "characteristic": asked.name, "value_mm": value},
                )
                return


def _inches(value: float, against: float, near: float) -> float | None:
    """Returns the factor 25.4 or its inverse, where it lies between two sizes."""
    if against == 0.0:
        return None
    ratios = (MM_PER_INCH, 1.0 / MM_PER_INCH)
    return next((ratio for ratio in ratios if abs(value / against / ratio - 1.0) <= near), None)


def known_findings(known: Mapping[str, Characteristic], inspection: Inspection) -> Iterator[Finding]:
    """Yields SER-UNKNOWN for characteristics new to the part type, SER-REVISION for other nominals or limits."""
    part_type: PartType = inspection.part.part_type
    for asked, _ in sizes_of(inspection) if known else ():
        before = known.get(asked.name)
        if before is None:
            yield Finding(
                Severity.WARNING,
                Code.SER_UNKNOWN,
                f"part {inspection.part.serial!r}: {asked.name!r} is not one of the {len(known)} characteristics known "
                f"of {part_type.name!r}: a new series begins",
                "look for a name that was changed in the measuring program",
                values={"characteristic": asked.name},
            )
        elif identity_of(part_type, before) != identity_of(part_type, asked):
            yield Finding(
                Severity.WARNING,
                Code.SER_REVISION,
                f"part {inspection.part.serial!r}: {asked.name!r} has {_sizes(asked)} mm and had {_sizes(before)} mm: "
                "a new series begins",
                "nothing learned of the earlier nominal or limits is used; look whether the drawing was changed",
                values={"characteristic": asked.name},
            )


def _sizes(characteristic: Characteristic) -> str:
    limits = [
        f"{characteristic.nominal:.4f}",
        *(f"{one:.4f}" for one in (characteristic.lower_limit, characteristic.upper_limit) if one is not None),
    ]
    return " / ".join(limits)


def few_findings(series: Sequence[Series]) -> Iterator[Finding]:
    """Yields SER-FEW for series of too few parts."""
    for one in series:
        if one.latest and len(one.made) < LEAST_PARTS:
            yield Finding(
                Severity.NOTE,
                Code.SER_FEW,
                f"{one.name!r} has {len(one.made)} inspected parts, fewer than {LEAST_PARTS}",
                "a proposal rests on what is believed of any series beforehand; measure more parts",
                values={"characteristic": one.name},
            )


def usable(parts: Sequence[PartSeen], *, take_nominal: bool) -> tuple[tuple[PartSeen, ...], tuple[Finding, ...]]:
    """Returns the parts that count, and findings on any of them. Takes them in cutting order."""
    kept: list[PartSeen] = []
    findings: list[Finding] = []
    known: dict[tuple[str, ...], dict[str, Characteristic]] = {}
    for part in parts:
        inspection, before = part.inspection, known.setdefault(part.inspection.part.part_type.identity, {})
        findings += nominal_findings(inspection, used=take_nominal)
        if filled_in(inspection) and not take_nominal:
            continue
        units = tuple(unit_findings(before, inspection))
        findings += units
        if units:
            continue
        findings += known_findings(before, inspection)
        kept.append(part)
        before.update({asked.name: asked for asked, _ in sizes_of(inspection)})
    return tuple(kept), tuple(findings)


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
    for decision in earlier:
        if decision.proposal == proposal.id:
            raise Code.SER_DECIDED.refusal(
                f"proposal {proposal.id} was {decision.verdict} by {decision.who} on {decision.at:%Y-%m-%d %H:%M}",
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
