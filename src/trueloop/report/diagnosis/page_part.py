"""The page of one part: its feature errors by who saw them, and surface/error diagrams at its gauging points."""

from collections.abc import Sequence
from typing import Final

from trueloop.report.diagnosis.causes import causes_section, findings_section, verdict
from trueloop.report.diagnosis.names import device_name, error_name, kind_name, with_u
from trueloop.report.diagnosis.page_series import signs
from trueloop.report.diagnosis.shapes import FeatureErrorShape, FrameShape, PartDiagnosisShape, PointShape
from trueloop.report.diagnosis.surfaces import surface_figures
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page
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
        for one in errors:
            by_key.setdefault((one.feature, one.other, one.kind), {})[device] = one
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
        " / ".join(str(one.points) for one in (machine, cmm) if one is not None),
        _value(machine, say),
        _value(cmm, say),
        _difference(machine, cmm, say),
    )


def _value(one: FeatureErrorShape | None, say: Texts) -> str:
    return "–" if one is None else with_u(one.value_um, one.standard_u_um, say)


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
    order = sorted(points, key=lambda one: (one.name not in first, -abs(one.error_pp_um)))
    done: list[str] = []
    size = 0
    for k, one in enumerate(order):
        block = figure_block(f"point-{k + 1}", surface_figures(one, say), f"<b>{esc(one.name)}</b>")
        size += len(block.encode())
        if done and size > LARGEST:
            break
        done.append(block)
    return "".join(done), len(points) - len(done)


def points_table(points: Sequence[PointShape], say: Texts) -> str:
    """Components at every point."""
    head = (
        say("point"), "ERROR_PP", "ERROR_MTG", "ERROR_MTG,<br>RESID", "ERROR_PROC", "ERROR_PROC,<br>RESID",
        "COMP_MTG", "COMP_PROC",
    )  # fmt: skip
    rows = [
        (
            esc(one.name),
            with_u(one.error_pp_um, one.u_error_pp_um, say),
            say.error(one.error_mtg_um),
            with_u(one.error_mtg_resid_um, one.u_error_mtg_um, say),
            say.error(one.error_proc_um),
            with_u(one.error_proc_resid_um, one.u_error_proc_um, say),
            say.error(one.comp_mtg_um),
            say.error(one.comp_proc_um),
        )
        for one in points
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
