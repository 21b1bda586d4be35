"""The evidence of a cause in words with figures, and which measurement would decide between causes."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.diagnosis.causes.candidate import Candidate
from trueloop.diagnosis.causes.cause import Over
from trueloop.diagnosis.causes.columns import Variant, minutes_in_cut, tool_of
from trueloop.diagnosis.causes.form import Cell
from trueloop.diagnosis.causes.rows import Row
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenSeries
from trueloop.diagnosis.causes.weighing import Size
from trueloop.wording import Um, Wording, wording

OPEN, SETTLED = 0.02, 0.98
"""Causes between these probabilities are told apart by a further measurement."""
Form = Mapping[Cell, tuple[str, float, float]]


def support(
    variant: Variant, errors: Sequence[Row], form: Form, series: SeenSeries, size: Size, cells: Sequence[Cell]
) -> tuple[str, ...]:
    """Why it is probable."""
    said = [_form(form, cell) for cell in cells]
    shown = _shown(errors, size)
    if shown is None:
        return tuple(said)
    if _agrees(variant, errors, series, shown):
        said.append(_by_device(errors, series, shown))
    said += _course(variant, errors, series, size, shown)
    return tuple(said)


def against(
    variant: Variant, errors: Sequence[Row], form: Form, series: SeenSeries, size: Size, cells: Sequence[Cell]
) -> tuple[str, ...]:
    """What does not fit, and what is not known."""
    said = [wording("{kind} of {feature} is no larger than noise.", kind=str(cell[0]), feature=form[cell][0])
            for cell in cells if form[cell][1] < 2 * form[cell][2]]  # fmt: skip
    shown = _shown(errors, size)
    if shown is None:
        return tuple(said)
    if not _agrees(variant, errors, series, shown):
        said.append(_by_device(errors, series, shown))
    if variant.over is Over.DEPTH and not any(shown.feature in part.depth_of_cut_mm for part in series.parts):
        said.append(wording("The depths of cut are not recorded."))
    tool = variant.tool or tool_of(shown.feature, series)
    if variant.over is Over.WEAR and not any(tool in part.minutes_in_cut for part in series.parts):
        said.append(wording("The minutes in cut are not recorded: parts since the tool was set are counted instead."))
    if abs(size.mm) < 2 * size.standard_u_mm:
        said.append(wording("Its size, {size}, is less than twice its standard uncertainty.", size=Um(size.mm)))
    return tuple(said)


def decide(candidates: Sequence[Candidate], series: SeenSeries, rows: Sequence[Row]) -> tuple[str, ...]:
    """Measurements that would tell apart what is left; () where nothing is."""
    left = [one for one in candidates if OPEN < one.probability < SETTLED]
    if not left:
        return ()
    said: list[str] = []
    cut = [row for row in rows if not series.parts[row.part].standard]
    for seen_by, sentence in _MISSING.items():
        if not any(row.seen_by is seen_by for row in cut):
            said.append(sentence)
    keys = {one.cause.key for one in left}
    if keys & _PROBE and not any(part.standard for part in series.parts):
        said.append(_STANDARD)
    return tuple(dict.fromkeys([*said, *[one.cause.decided_by for one in left]]))


_PROBE: Final = frozenset({"part-probe-offset", "machine"})
_STANDARD: Final = wording(
    "Probe a standard part under standard conditions: no tool and no cut is in what it shows, but the part probe and a "
    "constant error of the machine."
)
_MISSING: Final = {
    SeenBy.MACHINE: wording(
        "Probe the parts on the machine before they are unclamped: what its probe sees too is the process."
    ),
    SeenBy.CMM: wording(
        "Measure finished parts on a measuring machine: what it sees alone is the machine or the part probe."
    ),
}


def _shown(errors: Sequence[Row], size: Size) -> Row | None:
    """The error on which it shows most."""
    return errors[int(np.argmax(np.abs(size.effect_mm)))] if len(errors) and np.any(size.effect_mm) else None


def _means(errors: Sequence[Row], series: SeenSeries, shown: Row) -> dict[SeenBy, tuple[float, int]]:
    """The mean of an error over the parts and their number, by who saw it; as it had been without correction."""
    found = {}
    for seen_by in SeenBy:
        some = [row.value_mm + row.corrected_mm for row in _same(errors, series, shown) if row.seen_by is seen_by]
        if some:
            found[seen_by] = (float(np.mean(some)), len(some))
    return found


def _same(errors: Sequence[Row], series: SeenSeries, shown: Row) -> list[Row]:
    """The same error of all parts that were cut."""
    of = (shown.feature, shown.other, shown.kind)
    return [row for row in errors if (row.feature, row.other, row.kind) == of and not series.parts[row.part].standard]


def _agrees(variant: Variant, errors: Sequence[Row], series: SeenSeries, shown: Row) -> bool:
    """Whether who sees most of it is who should."""
    means = _means(errors, series, shown)
    seen_by = next(sign.seen_by for sign in variant.signs if sign.kind is shown.kind)
    if len(means) < 2:
        return True
    (machine, _), (cmm, _) = means[SeenBy.MACHINE], means[SeenBy.CMM]
    largest = max(abs(machine), abs(cmm))
    alike = abs(machine - cmm) < 0.5 * largest
    if len(seen_by) == 2:
        return alike
    return not alike and (abs(cmm) > abs(machine)) == (seen_by == (SeenBy.CMM,))


def _by_device(errors: Sequence[Row], series: SeenSeries, shown: Row) -> Wording:
    means = _means(errors, series, shown)
    if len(means) == 2:
        (machine, parts), (cmm, _) = means[SeenBy.MACHINE], means[SeenBy.CMM]
        return wording(
            "{kind} of {feature}: the machine's probe finds {machine}, the CMM {cmm}, on average of {parts} parts.",
            kind=str(shown.kind), feature=shown.feature, machine=Um(machine), cmm=Um(cmm), parts=parts,
        )  # fmt: skip
    ((seen_by, (mean, parts)),) = means.items() if means else {shown.seen_by: (shown.value_mm, 1)}.items()
    if seen_by is SeenBy.MACHINE:
        return wording(
            "{kind} of {feature}: the machine's probe finds {mean} on average of {parts} parts; no CMM has seen it.",
            kind=str(shown.kind), feature=shown.feature, mean=Um(mean), parts=parts,
        )  # fmt: skip
    return wording(
        "{kind} of {feature}: the CMM finds {mean} on average of {parts} parts; the machine has not probed it.",
        kind=str(shown.kind), feature=shown.feature, mean=Um(mean), parts=parts,
    )  # fmt: skip


def _course(variant: Variant, errors: Sequence[Row], series: SeenSeries, size: Size, shown: Row) -> list[Wording]:
    """How it goes over the parts."""
    same = [row for row in _same(errors, series, shown) if row.seen_by is shown.seen_by]
    effect = {row.part: mm for row, mm in zip(errors, size.effect_mm.tolist(), strict=True)
              if row.seen_by is shown.seen_by and (row.feature, row.kind) == (shown.feature, shown.kind)}  # fmt: skip
    low, high = Um(min(effect.values())), Um(max(effect.values()))
    tool = variant.tool or tool_of(shown.feature, series)
    first = series.parts[variant.step].serial if variant.step < len(series.parts) else ""
    minutes = max((minutes_in_cut(row.part, tool, series) for row in same), default=0.0)
    u = Um(size.standard_u_mm)
    said = {
        Over.WEAR: wording("It goes with the minutes in cut, from {low} to {high} in {minutes:.0f} min.",
                           low=low, high=high, minutes=minutes),
        Over.TEMPERATURE: wording("It goes with {signal}, from {low} to {high}.",
                                  signal=variant.signal, low=low, high=high),
        Over.DEPTH: wording("It goes with the depth of cut, from {low} to {high}.", low=low, high=high),
        Over.SETTING: wording("It changes where the tool was set anew, from {low} to {high}.", low=low, high=high),
        Over.SCATTER: wording("It is another one on every part, from {low} to {high}.", low=low, high=high),
        Over.STEP: wording("It begins at part {serial}, {size}.", serial=first, size=Um(size.mm)),
        Over.CONSTANT: wording("It is the same on all parts: {size}, standard uncertainty {u}.", size=Um(size.mm), u=u),
    }  # fmt: skip
    followed = variant.over not in (Over.CONSTANT, Over.STEP)
    return [] if followed and str(low) == str(high) else [said[variant.over]]


def _form(form: Form, cell: Cell) -> Wording:
    feature, mean, u = form[cell]
    seen = _SEEN[cell[1]]
    return wording("{kind} of {feature} is {mean} as {seen} it, with a standard uncertainty of {u}.",
                   kind=str(cell[0]), feature=feature, mean=Um(mean), seen=seen, u=Um(u))  # fmt: skip


_SEEN: Final = {SeenBy.MACHINE: wording("the machine's probe finds"), SeenBy.CMM: wording("the CMM finds")}
