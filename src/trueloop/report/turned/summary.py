"""The head of the report: the verdict in few sentences, and before and after of every feature.

Every feature of a corrected part in figures and a few words: what the page, the terminal and JSON show of it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.life import Ran
from trueloop.domain.record import Program, Record
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import Outcome, causes_um, outcomes
from trueloop.report.markup import esc, fields, table
from trueloop.report.shape import Shape
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import rms
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

STAYS_MM = 5e-5
"""A cut that moves by less stays where it is."""


@dataclass(frozen=True)
class TouchFigures:
    """Errors at some touches in µm: RMS and the value of largest size; `nan` of no touch.

    Before: measured. Predicted: after the corrected cut. Left out: each touch predicted from all others.
    """

    touches: int
    before_rms_um: float
    before_worst_um: float
    predicted_rms_um: float
    predicted_worst_um: float
    left_out_rms_um: float


@dataclass(frozen=True)
class FeatureSummary:
    """One feature: its touches, and what it is expected to come out like, touched or not.

    `expected_um` is the expected error of largest size and `expanded_u_um` the largest expanded uncertainty, at the
    feature's touches or, without any, along it; `standard_u_um` what makes that up, by cause. `correction` and
    `expected` say in words how the feature is corrected and what to expect.
    """

    feature: str
    figures: TouchFigures
    correction: str
    expected_um: float
    expanded_u_um: float
    expected: str
    standard_u_um: dict[str, float]


def feature_summaries(correction: Correction, say: Texts = ENGLISH) -> list[FeatureSummary]:
    """One for each feature of the profile, in its order.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> for feature in trueloop.feature_summaries(trueloop.compensate(job.inputs))[-3:]:
    ...     print(feature.feature, feature.expected)
    main-face 0.0 ± 7.9 µm
    small-cylinder 0.0 ± 7.9 µm
    dome +2.9 ± 8.1 µm
    """
    return [_summary(correction, outcome, say) for outcome in outcomes(correction)]


def _summary(correction: Correction, outcome: Outcome, say: Texts) -> FeatureSummary:
    return FeatureSummary(
        feature=correction.profile.names[outcome.index],
        figures=touch_figures(correction, correction.touches.of_feature(outcome.index)),
        correction=say.note(kind_of_correction(correction, outcome.index)),
        expected_um=outcome.expected_mm * UM_PER_MM,
        expanded_u_um=outcome.expanded_u_mm * UM_PER_MM,
        expected=_expected_words(correction, outcome, say),
        standard_u_um=causes_um(outcome.budget),
    )


def touch_figures(correction: Correction, rows: NDArray[np.intp]) -> TouchFigures:
    """Computes the figures of the touches at these positions."""
    prediction = correction.prediction
    before, after, left_out = (
        values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm, prediction.leave_one_out_mm)
    )
    known = left_out[np.isfinite(left_out)]
    return TouchFigures(
        touches=len(rows),
        before_rms_um=rms(before),
        before_worst_um=worst_of(before),
        predicted_rms_um=rms(after),
        predicted_worst_um=worst_of(after),
        left_out_rms_um=rms(known),
    )


def worst_of(values: Array) -> float:
    """Returns the value of largest size, with its sign; nan of nothing."""
    return float(values[np.argmax(np.abs(values))]) if len(values) else float("nan")


def kind_of_correction(correction: Correction, index: int) -> str:
    """Describes in a few words how a feature's error is described and corrected."""
    curve = correction.model.curves[index]
    touches = len(correction.touches.of_feature(index))
    if _is_left(correction, index):
        return wording("not touched: left as programmed")
    if correction.by_offset[index]:
        return wording("constant offset")
    if curve.from_memory:
        return wording("by earlier parts and {n} touches", n=touches)
    return _shape_words(curve, touches)


def _shape_words(curve: ErrorCurve, touches: int) -> str:
    """The form of a curve through touches."""
    if touches == 0:
        return wording("not touched: estimated")
    if curve.spline.degree == 0:
        return wording("one touch: constant") if touches == 1 else wording("constant")
    if curve.spline.degree == 1:
        return wording("straight line: size and taper")
    knots = len(curve.knots_mm)
    shape = wording("parabola") if curve.spline.degree == 2 else wording("cubic spline")
    counted = wording("one knot") if knots == 1 else wording("{n} knots", n=knots)
    return wording("{curve}, {knots}", curve=shape, knots=counted)


def _expected_words(correction: Correction, outcome: Outcome, say: Texts) -> str:
    """Expected error and its expanded uncertainty; a feature that is left as programmed is called so."""
    u = say.size(outcome.expanded_u_mm * UM_PER_MM)
    if _is_left(correction, outcome.index):
        return say("left as programmed ± {u} {um}", u=u)
    return f"{say.error(outcome.expected_mm * UM_PER_MM)} ± {u} {say.um}"


def _is_left(correction: Correction, index: int) -> bool:
    """Returns True for a feature whose cut stays as programmed as its error is unknown: no offset moves it either."""
    feature = correction.profile.features[index]
    normals = feature.outward_normal(np.linspace(0.0, feature.length_mm, 17))
    moved = normals @ np.array(correction.decision.offset_mm) * correction.by_offset[index]
    return correction.model.curves[index].unsupported and bool(np.max(np.abs(moved)) < STAYS_MM)


def verdict(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to cut with and what to expect: at the touches, and of features without any (HTML)."""
    expected, point, feature = _worst_touch(correction, say)
    before_um = worst_of(correction.prediction.before_mm) * UM_PER_MM
    return say(
        "Finish with <code>{program}</code>: the worst error is expected to be <strong>{expected} {um}</strong> at "
        "point {point} on {feature} (worst measured before: {before} {um}).",
        program=esc(correction.name_to_run),
        expected=expected,
        point=esc(point),
        feature=esc(feature),
        before=say.error(before_um),
    ) + "".join(f" {esc(words)}" for words in _untouched_words(correction, say))


def headline(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to expect, as plain text: the worst touch, the widest uncertainty, features without a touch."""
    expected, point, feature = _worst_touch(correction, say)
    first = say(
        "Worst expected error at a touch: {expected} {um}, at point {point} on {feature}.",
        expected=expected,
        point=point,
        feature=feature,
    )
    return " ".join([first, *_untouched_words(correction, say)])


def _worst_touch(correction: Correction, say: Texts) -> tuple[str, str, str]:
    """The touch with the largest expected error: that with U, its point, its feature."""
    touches, prediction = correction.touches, correction.prediction
    k = int(np.argmax(np.abs(prediction.after_mm)))
    after, u = prediction.after_mm[k] * UM_PER_MM, prediction.expanded_u_mm[k] * UM_PER_MM
    return f"{say.error(after)} ± {say.size(u)}", touches.point[k], correction.profile.names[touches.feature_index[k]]


def _untouched_words(correction: Correction, say: Texts) -> Iterator[str]:
    """A sentence on the features without a touch: what is expected of each, and how sure that is."""
    summaries = feature_summaries(correction, say)
    untouched = [f"{summary.feature} {summary.expected}" for summary in summaries if not summary.figures.touches]
    if untouched:
        yield say("Without a touch: {features}.", features="; ".join(untouched))


def to_run(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes what to finish with, and what else may take its place: one of them (HTML)."""
    program, joint = esc(correction.name_to_run), bool(correction.joint_name)
    if correction.recommended is Ran.WEAR:
        return say("Enter the tool offset, and run <code>{program}</code> as it is.", program=program)
    if correction.recommended is Ran.OFFSETS and correction.by_tool is not None:
        return say(
            "Run <code>{program}</code>; or enter the tool offset instead and run <code>{given}</code> as it is.",
            program=program,
            given=esc(correction.source_name),
        )
    if joint or correction.by_tool is None:
        return say("Run <code>{program}</code>, the tool offset as it is.", program=program)
    return say(
        "Run <code>{program}</code>, the tool offset as it is. The offset below is instead of it, not with it.",
        program=program,
    )


def offset_words(correction: Correction, say: Texts = ENGLISH) -> str:
    """Describes the tool offset as numbers to enter, what it stands for, and what it leaves."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    worst = int(np.argmax(np.abs(left_um)))
    if correction.runs_as_given:
        use = say("enter it at the control once, then run {program} as it is", program=correction.name_to_run)
    elif correction.by_tool is None:
        use = say("not to be entered: the decisions say why")
    elif correction.joint_name:
        use = say("not with {program}, which moves this edge's contour instead", program=correction.name_to_run)
    else:
        use = say("instead of {program}, not with it", program=correction.name_to_run)
    return say(
        "{wear} ({use}; leaves up to {left} {um}, on {feature})",
        wear=correction.wear.words,
        use=use,
        left=say.size(abs(left_um[worst])),
        feature=correction.profile.names[correction.touches.feature_index[worst]],
    )


def feature_table(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the table: a row a feature and one for all touches together."""
    headings = (
        say("feature"), say("touches"), say("before<br>RMS {um}"), say("before<br>worst {um}"),
        say("after<br>RMS {um}"), say("after<br>worst {um}"), say("left out<br>RMS {um}"),
        say("largest U<br>{um}"), say("correction"),
    )  # fmt: skip
    summaries = feature_summaries(correction, say)
    rows = [
        _row(summary.feature, summary.figures, summary.expanded_u_um, summary.correction, say) for summary in summaries
    ]
    every = touch_figures(correction, np.arange(len(correction.touches.point)))
    widest_um = float(np.max(correction.prediction.expanded_u_mm)) * UM_PER_MM
    last = _row(say("all touches"), every, widest_um, "", say)
    return table(headings, [*rows, last], words=(0, 8), name="features", stacks=True)


def _row(name: str, of: TouchFigures, u_um: float, kind: str, say: Texts) -> list[str]:
    return [
        esc(name), str(of.touches), say.size(of.before_rms_um), say.error(of.before_worst_um),
        say.size(of.predicted_rms_um), say.error(of.predicted_worst_um), say.size(of.left_out_rms_um), say.size(u_um),
        esc(kind),
    ]  # fmt: skip


class Header(Shape):
    """Statements of the job, its files and the record; empty or null where they state nothing."""

    part: str
    """Name or number of the part type."""
    drawing: str
    """Number of the drawing, where it is not the name."""
    revision: str
    """Revision of the drawing."""
    material: str
    """The part's material."""
    serial: str
    """Serial number of the piece that was measured."""
    operator: str
    """Who measured."""
    device: str
    """The device: probe, gauge or measuring machine."""
    machine: str
    """The machine tool."""
    machine_serial: str
    """Its serial number."""
    program: str
    """File name of the finish program that was corrected."""
    program_sha256: str
    """SHA-256 of that file."""
    dialect: str
    """Dialect of its control."""
    tool: str
    """Name of the finishing tool or its holder."""
    tool_number: int | None
    """Number of its offset at the control, where the job states it."""
    nose_radius_mm: float | None
    """Its nose radius."""
    insert: str
    """The insert."""
    corner: str
    """Which corner of it cuts."""
    edge_set_at: str | None
    """When that edge was mounted, ISO 8601."""
    measured_at: str | None
    """When the part was measured, ISO 8601."""
    corrected_at: str
    """When the correction was made, ISO 8601."""
    corrected_by: str
    """Who made it."""
    record_id: str
    """Id of the correction's record, which stands in the corrected program too."""
    trueloop_version: str
    """The software that made it."""


def header(record: Record) -> Header:
    """Makes the header of a record."""
    part, tool, edge, machine = record.part_type, record.tool, record.edge, record.machine
    program = record.program or Program("", "", "")
    inspections = record.inspections
    return Header(
        part=part.name if part else "",
        drawing=part.drawing if part else "",
        revision=part.revision if part else "",
        material=part.material if part else "",
        serial=_all(inspection.part.serial for inspection in inspections),
        operator=_all(inspection.operator for inspection in inspections),
        device=_all(inspection.device for inspection in inspections),
        machine=machine.name if machine else "",
        machine_serial=machine.serial if machine else "",
        program=program.name,
        program_sha256=program.sha256,
        dialect=program.dialect,
        tool=tool.name if tool else "",
        tool_number=tool.number if tool else None,
        nose_radius_mm=tool.corner_radius_mm if tool else None,
        insert=edge.insert if edge else "",
        corner=edge.corner if edge else "",
        edge_set_at=_iso(record.edge_set_at),
        measured_at=_iso(
            max((inspection.measured_at for inspection in inspections if inspection.measured_at), default=None)
        ),
        corrected_at=record.made_at,
        corrected_by=record.made_by,
        record_id=record.id,
        trueloop_version=record.trueloop_version,
    )


def header_fields(of: Header, say: Texts = ENGLISH) -> str:
    """Writes the header as names and values (HTML); what is not stated is a dash."""
    number = None if of.tool_number is None else f"T{of.tool_number}"
    nose = None if of.nose_radius_mm is None else say("nose {r} {mm}", r=say.mm(of.nose_radius_mm, 4))
    edge = say("corner {corner}", corner=of.corner) if of.corner else ""
    digest = f'<br><code class="hash">{esc(of.program_sha256)}</code>' if of.program_sha256 else ""
    rows = [
        (say("Part"), esc(of.part)),
        (say("Drawing"), esc(of.drawing)),
        (say("Revision"), esc(of.revision)),
        (say("Serial number"), esc(of.serial)),
        (say("Material"), esc(of.material)),
        (say("Machine"), esc(_all([of.machine, of.machine_serial]))),
        (say("Tool"), esc(_all([number or "", of.tool, nose or ""]))),
        (say("Edge"), esc(_all([of.insert, edge, _moment(of.edge_set_at)]))),
        (say("Gauge"), esc(of.device)),
        (say("Operator"), esc(of.operator)),
        (say("Measured"), esc(_moment(of.measured_at))),
        (say("Corrected"), esc(_all([_moment(of.corrected_at), of.corrected_by]))),
        (say("Record"), f"<code>{esc(of.record_id)}</code>, trueloop {esc(of.trueloop_version)}"),
        (say("Program"), f"{esc(_all([of.program, of.dialect]))}{digest}"),
    ]
    return fields(rows)


def _all(texts: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(text for text in texts if text))


def _iso(moment: datetime | None) -> str | None:
    return None if moment is None else moment.isoformat(timespec="seconds")


def _moment(iso: str | None) -> str:
    """A date and time as people write it, with its zone."""
    if iso is None:
        return ""
    try:
        return datetime.fromisoformat(iso).strftime("%Y-%m-%d %H:%M %Z").replace("UTC+00:00", "UTC").strip()
    except ValueError:
        return iso
