"""Diagnoses as lines for a terminal, without findings."""

from collections.abc import Iterator, Sequence
from typing import Final

from trueloop.report.diagnosis.causes import (
    CREDIBLE,
    LEAST,
    SETS,
    SURE,
    credible,
    device_name,
    error_name,
    mean_with_u,
    share,
    source,
    with_u,
)
from trueloop.report.diagnosis.figures import COVERAGE
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape
from trueloop.report.diagnosis.shapes import (
    CandidateShape,
    CausesShape,
    FixtureDiagnosisShape,
    JudgedShape,
    PartDiagnosisShape,
    SeriesDiagnosisShape,
    UnexplainedShape,
)
from trueloop.report.style import plain, signed

FURTHEST: Final = 10
"""Gauging points in a terminal."""


def part_lines(diagnosis: PartDiagnosisShape) -> Iterator[str]:
    """Yields the lines of one part: errors by device, causes, and the gauging points furthest off."""
    yield f"{diagnosis.part_type} {diagnosis.part.serial}" + (" (standard part)" if diagnosis.part.standard else "")
    for device, errors in diagnosis.part.errors.items():
        yield f"{device_name(device)}, µm ± standard uncertainty:"
        for error in errors:
            value = with_u(error.value_um, error.standard_u_um)
            yield f"  {error_name(error)}, {error.kind}: {value} ({error.points} points)"
    if diagnosis.causes is not None:
        yield from causes_lines(diagnosis.causes)
    if diagnosis.points:
        yield "point: ERROR_PP = ERROR_MTG,RESID + ERROR_PROC,RESID, µm, + is material left on"
        for at in sorted(diagnosis.points, key=lambda each: -abs(each.error_pp_um))[:FURTHEST]:
            three = (at.error_pp_um, at.error_mtg_resid_um, at.error_proc_resid_um)
            yield f"  {at.name}: {' '.join(signed(value) for value in three)}"


def series_lines(diagnosis: SeriesDiagnosisShape) -> Iterator[str]:
    """Yields the lines of a series: how many parts, means of the errors, causes."""
    standards = sum(part.standard for part in diagnosis.parts)
    yield f"{diagnosis.part_type}: {len(diagnosis.parts) - standards} parts" + (
        f", {standards} standard parts" if standards else ""
    )
    for shape in diagnosis.means:
        three = (("machine", shape.machine), ("CMM", shape.cmm), ("difference", shape.difference))
        seen = "; ".join(f"{name} {mean_with_u(mean)}" for name, mean in three if mean is not None)
        yield f"  {error_name(shape)}, {shape.kind}: {seen} µm"
    if diagnosis.causes is None:
        yield "nothing is concluded"
    else:
        yield from causes_lines(diagnosis.causes, diagnosis.unexplained)


def causes_lines(causes: CausesShape, unexplained: Sequence[UnexplainedShape] = ()) -> Iterator[str]:
    """Yields the verdict, then what is not explained, then each cause with evidence, remedy and what would decide."""
    if unexplained and causes.sound >= SURE:
        yield f"no known cause ({share(causes.sound)} that none acts), but errors beyond their uncertainty"
    else:
        yield _verdict(causes)
    for each in unexplained[:FURTHEST]:
        size = signed(each.size_um) if each.shows == "mean" else plain(each.size_um)
        seen = f"{each.shows} {size} µm, standard uncertainty {plain(each.standard_u_um)}"
        yield f"  not explained: {error_name(each)}, {each.kind}, {device_name(each.device)}: {seen}"
    for candidate in causes.candidates:
        if candidate.probability >= LEAST:
            yield from _cause(candidate)
    for measurement in causes.decide:
        yield f"would decide: {measurement}"


def _verdict(causes: CausesShape) -> str:
    if causes.sound >= SURE:
        return f"sound: nothing acts, probability {share(causes.sound)}"
    names = {candidate.key: candidate.name for candidate in causes.candidates}
    likely = [shape for shape in credible(causes.hypotheses) if shape.causes]
    said = "; ".join(" + ".join(str(names.get(key, key)) for key in shape.causes) for shape in likely[:SETS])
    said += f"; {len(likely) - SETS} more" if len(likely) > SETS else ""
    if likely and likely[0].probability >= SURE:
        return f"cause: {said.split('; ')[0]}, probability {share(likely[0].probability)}"
    return f"one of {len(likely)} answers: {said} ({share(CREDIBLE)} together); nothing acts: {share(causes.sound)}"


def _cause(candidate: CandidateShape) -> Iterator[str]:
    size = "" if candidate.size_um is None else f", {signed(candidate.size_um)} µm"
    if candidate.size_um is not None and candidate.standard_u_um is not None:
        size += f" ± {plain(COVERAGE * candidate.standard_u_um)} (95 %)"
    on = f" on {', '.join(candidate.features)}" if candidate.features else ""
    yield f"  {share(candidate.probability)}  {candidate.name}{on}{size}"
    for word in candidate.supports:
        yield f"      + {word}"
    for word in candidate.contradicts:
        yield f"      − {word}"
    yield f"      remedy: {candidate.remedy} {source(candidate.section)}".rstrip()


def fixture_lines(diagnosis: FixtureDiagnosisShape) -> Iterator[str]:
    """Yields each fixturing: spread, drift and step with their bands of 95 %, * where beyond chance."""
    for fixturing in diagnosis.fixturings:
        three = (("spread", fixturing.spread), ("drift", fixturing.drift), ("step", fixturing.step))
        said = ", ".join(_judged(name, judged) for name, judged in three)
        at = (
            f" after repeat {fixturing.step_after}"
            if fixturing.step.significant and fixturing.step_after is not None
            else ""
        )
        verdict = "stable" if fixturing.stable else "UNSTABLE"
        yield f"{fixturing.name}: {verdict}; {len(fixturing.values_um)} repeats, µm: {said}{at}"
    if any(not fixturing.stable for fixturing in diagnosis.fixturings):
        yield "nothing else is concluded while a fixturing is unstable [NISTIR 4773 §4.1]"


def _judged(name: str, judged: JudgedShape) -> str:
    value = plain(judged.value_um) if name == "spread" else signed(judged.value_um)
    return f"{name} {value} ± {plain(COVERAGE * judged.standard_u_um)}{'*' if judged.significant else ''}"


def machine_lines(diagnosis: MachineDiagnosisShape) -> Iterator[str]:
    """Sets of axis errors that the model may have wrong, with what would divide them; refinement."""
    yield f"{diagnosis.machine}, model {diagnosis.model}: {diagnosis.points} gauging points of {diagnosis.parts} parts"
    if not diagnosis.sets:
        sure = "sound" if diagnosis.sound >= SURE else "probably sound"
        yield f"{sure}: the model has nothing wrong that these parts could show, probability {share(diagnosis.sound)}"
    for shape in diagnosis.sets:
        several = f"{shape.at_least} of " if len(shape.errors) > 1 else ""
        named = ", ".join(
            f"{each.error} ({f'with {each.follows}, ' if each.follows else ''}{share(each.probability)})"
            for each in shape.errors
        )
        yield f"  {share(shape.probability)}  {several}{named}"
        for word in shape.separated_by:
            yield f"      told apart by: {word}"
    if diagnosis.frames is not None:
        yield str(diagnosis.frames)
    refined = diagnosis.refinement
    if refined is not None:
        state = f"accepted {refined.accepted}" if refined.accepted else "offered, not in force"
        yield f"refined model, version {refined.version} ({state}); ERROR_MTG,RESID, µm RMS:"
        for left in refined.left_out:
            change = f"{plain(left.before_um, 2)} → {plain(left.after_um, 2)}"
            yield f"  {left.of} left out: {change} ({left.points} points)"
