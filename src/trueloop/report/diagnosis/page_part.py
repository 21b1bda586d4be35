"""The page of one part: its feature errors by who saw them, and surface/error diagrams at its gauging points."""

from collections.abc import Sequence
from typing import Final

from trueloop.report.diagnosis.causes import (
    causes_section,
    device_name,
    error_name,
    findings_section,
    kind_name,
    mean_with_u,
    unexplained_section,
    verdict,
    with_u,
)
from trueloop.report.diagnosis.figures import COVERAGE, SHOWN, fixturing_figure, series_figure, surface_figures
from trueloop.report.diagnosis.shapes import (
    FeatureErrorShape,
    FeatureMeansShape,
    FixtureDiagnosisShape,
    FixturingShape,
    FrameShape,
    JudgedShape,
    MeanShape,
    PartDiagnosisShape,
    PointMeansShape,
    PointShape,
    SeriesDiagnosisShape,
)
from trueloop.report.markup import as_room_allows, esc, figure_block, html_page, on_screen, section, table
from trueloop.report.texts.texts import ENGLISH, Texts

LARGEST: Final = 300_000
"""Bytes of diagrams on one page: what is beyond stands in the table alone."""


def part_page(part: PartDiagnosisShape, say: Texts = ENGLISH, points: Sequence[str] = ()) -> str:
    """Writes the page as HTML in one file; the diagrams of `points` by name come first, else of the furthest off."""
    named = f"{esc(part.part_type)} {esc(part.part.serial)}"
    when = f" · {esc(part.part.at)}" if part.part.at else ""
    standard = f" · {say('standard part: nothing was cut on it')}" if part.part.standard else ""
    said = verdict(part.causes, 1, say) if part.causes is not None else ""
    body = (
        f'<header><p class="kicker">{say("trueloop · diagnosis of a part")}</p><h1>{named}</h1>'
        f'<p class="meta">{_counted(part, say)}{when}{standard}</p>{said}<p class="note">{signs(say)}</p></header>'
        + section("errors", say("Errors of its features"), errors_table(part, say))
        + causes_section(part.causes, say)
        + _points(part, points, say)
        + findings_section(part.findings, say)
    )
    return html_page(f"{named} – {say('diagnosis')}", body, language=say.language)


def _counted(part: PartDiagnosisShape, say: Texts) -> str:
    said = [
        say("{device}: {n} errors", device=device_name(device, say), n=len(errors))
        for device, errors in part.part.errors.items()
    ]
    return " · ".join(said) or say("No errors of features are known.")


def errors_table(part: PartDiagnosisShape, say: Texts) -> str:
    """Writes the table of every error with its standard uncertainty, by device, and CMM less machine."""
    by_key: dict[tuple[str, str, str], dict[str, FeatureErrorShape]] = {}
    for device, errors in part.part.errors.items():
        for error in errors:
            by_key.setdefault((error.feature, error.other, error.kind), {})[device] = error
    if not by_key:
        return f"<p>{say('No errors of features are known.')}</p>"
    head = (
        say("feature"), say("error"), say("points"), say("machine’s probe<br>({um})"), say("CMM or gauge<br>({um})"),
        say("difference<br>({um})"),
    )  # fmt: skip
    rows = [_row(of_it, say) for of_it in by_key.values()]
    note = say("± is the standard uncertainty. Difference: CMM less machine, what the model of the machine left.")
    return table(head, rows, words=(0, 1), name="errors-table", stacks=True) + f"<p class='note'>{note}</p>"


def _row(of_it: dict[str, FeatureErrorShape], say: Texts) -> tuple[str, ...]:
    any_one = next(iter(of_it.values()))
    machine, cmm = (of_it.get(device) for device in ("machine", "CMM"))
    return (
        esc(error_name(any_one)),
        kind_name(any_one.kind, say),
        " / ".join(str(shape.points) for shape in (machine, cmm) if shape is not None),
        _value(machine, say),
        _value(cmm, say),
        _difference(machine, cmm, say),
    )


def _value(feature_error: FeatureErrorShape | None, say: Texts) -> str:
    return "–" if feature_error is None else with_u(feature_error.value_um, feature_error.standard_u_um, say)


def _difference(machine: FeatureErrorShape | None, cmm: FeatureErrorShape | None, say: Texts) -> str:
    if machine is None or cmm is None or machine.value_um is None or cmm.value_um is None:
        return "–"
    both = (machine.standard_u_um, cmm.standard_u_um)
    u = None if both[0] is None or both[1] is None else (both[0] ** 2 + both[1] ** 2) ** 0.5
    return with_u(cmm.value_um - machine.value_um, u, say)


def _points(part: PartDiagnosisShape, first: Sequence[str], say: Texts) -> str:
    if not part.points:
        return ""
    figures, left_out = _diagrams(part.points, first, say)
    note = say("{n} more points stand in the table alone.", n=left_out) if left_out else ""
    how = say(
        "◆ surfaces, counted from NOMINALSURFACE CMM; arrows go from one surface to another: red leaves material on, "
        "blue takes too much, green is a compensation. All lie on the normal at the point and are drawn one below the "
        "other; the tinted band is the error of the part [6876 §3, Fig. 12–15]."
    )
    return section(
        "points",
        say("Surfaces and errors at gauging points"),
        frame_note(part.frame, say),
        points_table(part.points, say),
        f"<p class='note'>{how}</p>",
        figures,
        f"<p class='note'>{note}</p>" if note else "",
    )


def _diagrams(points: Sequence[PointShape], first: Sequence[str], say: Texts) -> tuple[str, int]:
    """Named points first, then those of the largest error, as far as the page has room."""
    order = sorted(points, key=lambda shape: (shape.name not in first, -abs(shape.error_pp_um)))
    blocks = (
        figure_block(f"point-{k}", surface_figures(shape, say), f"<b>{esc(shape.name)}</b>")
        for k, shape in enumerate(order, 1)
    )
    return as_room_allows(blocks, len(points), LARGEST)


def points_table(points: Sequence[PointShape], say: Texts) -> str:
    """Components at every point."""
    head = (
        say("point"), "ERROR_PP", "ERROR_MTG", "ERROR_MTG,<br>RESID", "ERROR_PROC", "ERROR_PROC,<br>RESID",
        "COMP_MTG", "COMP_PROC",
    )  # fmt: skip
    rows = [
        (
            esc(point.name),
            with_u(point.error_pp_um, point.u_error_pp_um, say),
            say.error(point.error_mtg_um),
            with_u(point.error_mtg_resid_um, point.u_error_mtg_um, say),
            say.error(point.error_proc_um),
            with_u(point.error_proc_resid_um, point.u_error_proc_um, say),
            say.error(point.comp_mtg_um),
            say.error(point.comp_proc_um),
        )
        for point in points
    ]
    return table(head, rows, stacks=True)


def frame_note(frame: FrameShape | None, say: Texts) -> str:
    """Writes what was taken out as a difference of the part frames."""
    if frame is None:
        return ""
    said = say(
        "Difference of the part frames of CMM and machine, taken out: shift ({shift}) {um}, turn ({turn}) µrad; "
        "CMM less machine along the normals {before} → {after} {um} RMS.",
        shift=", ".join(say.error(one) for one in frame.shift_um),
        turn=", ".join(say.number(one, 0) for one in frame.turn_urad),
        before=say.size(frame.rms_before_um),
        after=say.size(frame.rms_after_um),
    )
    return f"<p>{said}</p>"


def fixture_page(diagnosis: FixtureDiagnosisShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    figures = "".join(
        figure_block(f"fixturing-{k + 1}", fixturing_figure(shape, say), f"<b>{esc(shape.name)}</b>", small=True)
        for k, shape in enumerate(diagnosis.fixturings)
    )
    how = say(
        "Repeats at one point, each less their mean, with bars of 95 %; dashed: what they may vary by; grey: a drift "
        "or a step beyond chance. While a fixturing is unstable nothing else is concluded [4773 §4.1]."
    )
    drawn = (
        (
            _table(diagnosis, say),
            f"<p class='note'>{how}</p>",
            on_screen(say),
            f'<div class="figures pairs">{figures}</div>',
        )
        if diagnosis.fixturings
        else (f"<p>{say('No repeats are known.')}</p>",)
    )
    body = (
        f'<header><p class="kicker">{say("trueloop · fixturing")}</p><h1>{esc(diagnosis.machine)}</h1>'
        f"{_verdict(diagnosis, say)}</header>"
        + section("repeats", say("Repeats"), *drawn)
        + findings_section(diagnosis.findings, say)
    )
    return html_page(f"{esc(diagnosis.machine)} – {say('fixturing')}", body, language=say.language)


def _verdict(diagnosis: FixtureDiagnosisShape, say: Texts) -> str:
    unstable = [fixturing.name for fixturing in diagnosis.fixturings if not fixturing.stable]
    if not diagnosis.fixturings:
        words = say("Nothing is concluded; the findings say why.")
    elif unstable:
        words = say(
            "<strong>Unstable</strong>: {names}. Nothing else is concluded until this is mended.",
            names=esc(", ".join(unstable)),
        )
    else:
        words = say(
            "<strong>Stable</strong>: {names}. Repeats vary by no more than chance and limits allow.",
            names=esc(", ".join(fixturing.name for fixturing in diagnosis.fixturings)),
        )
    return f'<p class="verdict">{words}</p>'


def _table(diagnosis: FixtureDiagnosisShape, say: Texts) -> str:
    head = (
        say("fixturing"), say("repeats"), say("spread ({um})"), say("drift ({um})"), say("step ({um})"),
        say("limit ({um})"), say("verdict"),
    )  # fmt: skip
    rows = [
        (
            esc(fixturing.name),
            str(len(fixturing.values_um)),
            _judged(fixturing.spread, say, signed=False),
            _judged(fixturing.drift, say),
            _judged(fixturing.step, say) + _where(fixturing, say),
            "–" if fixturing.limit_um is None else say.size(fixturing.limit_um),
            f"✓ {say('stable')}" if fixturing.stable else f"<strong>✗ {say('unstable')}</strong>",
        )
        for fixturing in diagnosis.fixturings
    ]
    note = say("± 95 %; bold: beyond what chance explains.")
    return table(head, rows, words=(0, 6), name="fixturings", stacks=True) + f"<p class='note'>{note}</p>"


def _judged(judged: JudgedShape, say: Texts, *, signed: bool = True) -> str:
    value = say.error(judged.value_um) if signed else say.size(judged.value_um)
    text = f"{value} ± {say.size(COVERAGE * judged.standard_u_um)}"
    return f"<strong>{text}</strong>" if judged.significant else text


def _where(fixturing: FixturingShape, say: Texts) -> str:
    if fixturing.step_after is None or not fixturing.step.significant:
        return ""
    return "<br>" + say("after repeat {n}", n=fixturing.step_after)


def series_page(series: SeriesDiagnosisShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    standards = sum(part.standard for part in series.parts)
    cut = len(series.parts) - standards
    counted = say("{parts} parts, {n} errors of features.", parts=cut, n=len(series.means))
    more = " " + say("{n} standard parts.", n=standards) if standards else ""
    body = (
        f'<header><p class="kicker">{say("trueloop · diagnosis of a series")}</p><h1>{esc(series.part_type)}</h1>'
        f'<p class="meta">{counted}{more}</p>{verdict(series.causes, cut, say, series.unexplained)}'
        f'<p class="note">{signs(say)}</p></header>'
        + unexplained_section(series.unexplained, say)
        + causes_section(series.causes, say)
        + _errors(series, say)
        + points_section(series.points, say)
        + findings_section(series.findings, say)
    )
    return html_page(f"{esc(series.part_type)} – {say('diagnosis')}", body, language=say.language)


def signs(say: Texts) -> str:
    """Explains how errors are counted, and which device sees what."""
    return say(
        "Errors are along the outward normal, + where material is left on; a radius is a radius. The machine’s probe, "
        "corrected by the model of the machine, sees what the process did; a CMM or gauge sees what the model left too."
    )


def _errors(series: SeriesDiagnosisShape, say: Texts) -> str:
    if not series.means:
        return section("errors", say("Errors over the parts"), f"<p>{say('No part has errors of features.')}</p>")
    figures, left_out = _figures(series, say)
    reading = say(
        "○ machine’s probe, ◆ CMM or gauge, bars of 95 %; dotted: a tool was set. Mean ± its standard uncertainty; "
        "difference: CMM less machine, of parts that both saw, is what the model of the machine left."
    )
    note = say("{n} more errors stand in the table alone.", n=left_out) if left_out else ""
    return section(
        "errors",
        say("Errors over the parts"),
        means_table(series.means, say),
        f"<p class='note'>{reading}</p>",
        on_screen(say),
        f'<div class="figures pairs">{figures}</div>',
        f"<p class='note'>{note}</p>" if note else "",
    )


def points_section(points: Sequence[PointMeansShape], say: Texts) -> str:
    """Writes mean and standard deviation at every gauging point by device, as [6811 Tables 2–11] have them."""
    if not points:
        return ""
    head = (
        say("feature"), say("x radius<br>({mm})"), say("z<br>({mm})"), say("parts"),
        *(text for _ in range(2) for text in (say("mean<br>({um})"), say("standard<br>deviation ({um})"))),
    )  # fmt: skip
    rows = [
        (
            *(esc(point.feature), say.mm(point.x_mm), say.mm(point.z_mm)),
            str(max(mean.parts for mean in (point.machine, point.cmm) if mean is not None)),
            *(cell for mean in (point.machine, point.cmm) for cell in _mean_and_scatter(mean, say)),
        )
        for point in points
    ]
    note = say(
        "First mean and standard deviation from part to part as the machine’s probe saw them, then as the CMM or gauge "
        "did. The JSON file has the error of each part."
    )
    drawn = table(head, rows, words=(0,), name="points-table", stacks=True)
    return section("points", say("Gauging points over the parts"), drawn, f"<p class='note'>{note}</p>")


def _mean_and_scatter(mean: MeanShape | None, say: Texts) -> tuple[str, str]:
    if mean is None:
        return "–", "–"
    return say.error(mean.mean_um), "–" if mean.scatter_um is None else say.size(mean.scatter_um)


def means_table(means: Sequence[FeatureMeansShape], say: Texts) -> str:
    """Writes the table of mean and scatter of every error by device, µm."""
    head = (
        say("feature"), say("error"), say("parts"), say("machine’s probe<br>({um})"), say("CMM or gauge<br>({um})"),
        say("difference<br>({um})"), say("scatter over<br>the parts ({um})"),
    )  # fmt: skip
    rows = [
        (
            esc(error_name(shape)),
            kind_name(shape.kind, say),
            str(max(mean.parts for mean in (shape.machine, shape.cmm) if mean is not None)),
            mean_with_u(shape.machine, say),
            mean_with_u(shape.cmm, say),
            mean_with_u(shape.difference, say),
            _scatter(shape, say),
        )
        for shape in means
    ]
    return table(head, rows, words=(0, 1), name="errors-table", stacks=True)


def _scatter(means: FeatureMeansShape, say: Texts) -> str:
    known = [mean.scatter_um for mean in (means.machine, means.cmm) if mean is not None and mean.scatter_um is not None]
    return " / ".join(say.size(value) for value in known) or "–"


def _figures(series: SeriesDiagnosisShape, say: Texts) -> tuple[str, int]:
    """Figures of the errors, those furthest from none first, as far as the page has room; and how many it has not."""
    blocks = (
        figure_block(f"error-{k}", series_figure(series.parts, shape, say), _caption(series, shape, say), small=True)
        for k, shape in enumerate(sorted(series.means, key=_surprise, reverse=True), 1)
    )
    return as_room_allows(blocks, len(series.means), LARGEST)


def _surprise(means: FeatureMeansShape) -> float:
    return max(map(_ratio, (means.machine, means.cmm, means.difference)))


def _ratio(mean: MeanShape | None) -> float:
    return 0.0 if mean is None else abs(mean.mean_um) / max(mean.standard_u_um or 1.0, 0.1)


def _caption(series: SeriesDiagnosisShape, means: FeatureMeansShape, say: Texts) -> str:
    parts = sum(not part.standard for part in series.parts)
    more = say(", the latest {shown} of {all} parts", shown=SHOWN, all=parts) if parts > SHOWN else ""
    return f"<b>{esc(error_name(means))}</b>, {kind_name(means.kind, say)}{more}"
