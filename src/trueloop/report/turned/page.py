"""The report: one HTML file that needs nothing else, neither a network nor, for its words and pictures, scripts.

For a quality manager first: what was corrected, whether it will be in tolerance, what to run; then how it is known.
Figures are Plotly specifications, drawn as pictures (SVG), once for a screen or paper and once for a telephone. A
script adds what only a screen can do: values when pointed at, and a closer look.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Final
from urllib.parse import quote

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.program_diff import changed_lines, program_diff
from trueloop.report.style import Figure, signed
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.characteristic_table import characteristic_table
from trueloop.report.turned.figures import whiskers
from trueloop.report.turned.figures.curves import error_curve, uncertainty
from trueloop.report.turned.figures.part_drawing import times
from trueloop.report.turned.remembered import memory_section
from trueloop.report.turned.sources import sources_section
from trueloop.report.turned.summary import (
    feature_table,
    header,
    header_fields,
    kind_of_correction,
    offset_words,
    to_run,
    verdict,
)
from trueloop.report.turned.touch_table import by_tool_block, composed_section, decisions, touches_csv, touches_table
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.turned.error_curve.junctions import DisplacedJunction, Tangency
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

POLICY = {
    "part": wording(
        "Tangent junctions by policy <b>part</b>: the curves meet in value, their slopes are free, so that the path "
        "takes the kink opposite to the error's and the part is tangent."
    ),
    "path": wording(
        "Tangent junctions by policy <b>path</b>: the curves meet in value and slope, so that the path is tangent and "
        "the error's kink stays on the part."
    ),
}
KINDS = {"tangent": wording("tangent"), "corner": wording("corner"), "apart": wording("apart")}
CLOSED_MM = 1e-6


def junctions(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the table, what its columns mean, the policy, and which corners could not be closed (HTML)."""
    columns = say(
        "Errors are the fitted curves' where one feature ends and the next starts; displaced x and z, where both "
        "curves meet, seen from the nominal junction. Turn is positive at a convex corner. Kink: step of the error's "
        "slope across a tangent junction; the part's tangency is the step predicted to remain on the part "
        "(1 µm/mm = 1 mrad)."
    )
    tangent = f"<p>{say.note(POLICY[correction.options.junctions])}</p>" if correction.model.tangency else ""
    flat = list(_open_corners(correction, say))
    return _table(correction, say) + (items(flat) if flat else "") + tangent + f"<p class='note'>{columns}</p>"


def _open_corners(correction: Correction, say: Texts) -> Iterator[str]:
    names = correction.profile.names
    for junction in correction.model.junctions:
        if junction.before is not None and junction.after is not None and junction.gap_mm > CLOSED_MM:
            yield f"{esc(names[junction.before])} – {esc(names[junction.after])}: {esc(say.note(junction.note))}"


def _table(correction: Correction, say: Texts) -> str:
    """A row a junction, from the chuck end to the free end, the two ends of the profile included."""
    tangencies: dict[tuple[int | None, int | None], Tangency]
    tangencies = {(one.before, one.after): one for one in correction.model.tangency}
    rows, k = [], coverage_factor(correction.model.degrees_of_freedom or None)
    for junction in correction.model.junctions:
        displaced = [
            f"{say.error(d * UM_PER_MM)} ± {say.size(k * u * UM_PER_MM)}"
            for d, u in zip(junction.displacement_mm, junction.standard_u_mm, strict=True)
        ]
        errors = [_error(junction.error_before_mm, say), _error(junction.error_after_mm, say)]
        tangency = tangencies.get((junction.before, junction.after))
        rows.append([*_place(correction, junction, say), *errors, *displaced, *_tangency(correction, tangency, say)])
    headings = (
        say("between"), say("kind"), say("turn<br>°"), say("error at end<br>{um}"), say("error at start<br>{um}"),
        say("displaced x<br>{um}"), say("displaced z<br>{um}"),
        say("kink of error<br>{slope}", slope=say.slope_name), say("part's tangency<br>{slope}", slope=say.slope_name),
    )  # fmt: skip
    return table(headings, rows, words=(0, 1), name="junctions", stacks=True)


def _place(correction: Correction, junction: DisplacedJunction, say: Texts) -> tuple[str, str, str]:
    """Between which features, the kind, and the turn in degrees, positive at a convex corner."""
    names = correction.profile.names
    if junction.before is None or junction.after is None:
        index = junction.after if junction.before is None else junction.before
        name = "" if index is None else esc(names[index])
        start = junction.before is None
        return (
            (say("start of {feature}", feature=name) if start else say("end of {feature}", feature=name)),
            say("end"),
            "",
        )
    met = correction.profile.junctions[junction.before]
    kind = say.note(KINDS[met.kind])
    between = f"{esc(names[junction.before])} – {esc(names[junction.after])}"
    kind = say("{kind} by design", kind=kind) if met.by_design else kind
    return between, kind, say.spelled(signed(math.degrees(met.turn_rad), 2))


def _error(error_mm: float | None, say: Texts) -> str:
    return "" if error_mm is None else say.error(error_mm * UM_PER_MM)


def _tangency(correction: Correction, tangency: Tangency | None, say: Texts) -> tuple[str, str]:
    """Kink of the error, and of the predicted part: what a full correction leaves and a weight below 1 keeps."""
    if tangency is None:
        return "", ""
    kept = tangency.predicted_rad + (1.0 - correction.options.weight) * (tangency.kink - tangency.predicted_rad)
    expanded = coverage_factor(correction.model.degrees_of_freedom or None) * tangency.standard_u_um_per_mm
    remains = f"{say.slope(kept * UM_PER_MM)} ± {say.slope(expanded).removeprefix('+')}"
    return say.slope(tangency.kink * UM_PER_MM), remains


WIDTHS: Final = {"wide": whiskers.WIDTH, "narrow": whiskers.NARROW}
"""Of every figure, by the class that a window's width shows."""


def page(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the whole report of one correction as HTML."""
    title = say("{part} – correction {record}", part=esc(correction.part), record=esc(correction.record.id))
    sections = (
        _part(correction, say),
        section("program", say("Changes to the program"), *_program(correction, say)),
        _curves(correction, say),
        sources_section(correction, say, _figure),
        memory_section(correction, say, _figure),
        section("uncertainty", say("Uncertainty"), uncertainty(correction, say)),
        section("meet", say("Junctions"), junctions(correction, say)),
        section("why", say("Decisions"), decisions(correction, say)),
        composed_section(correction, say),
        _numbers(correction, say),
        _origin(correction, say),
    )
    return html_page(title, _head(correction, say) + "".join(sections), language=say.language)


def _head(correction: Correction, say: Texts) -> str:
    kicker = say("trueloop · correction of a finish cut from the touches after semi-finishing")
    offset = say("Tool offset: {offset}", offset=esc(offset_words(correction, say)))
    return (
        f'<header><p class="kicker">{kicker}</p><h1>{esc(correction.part)}</h1>'
        f"{header_fields(header(correction.record), say)}</header>{_setup(correction, say)}"
        f'<p class="verdict"><span class="stamp">{say("Prediction")}</span>{verdict(correction, say)}</p>'
        + section("tolerances", say("Tolerances"), characteristic_table(correction.characteristics, say))
        + section(
            "run",
            say("What to run"),
            f"<p id='to-run'><strong>{to_run(correction, say)}</strong></p>",
            by_tool_block(correction, say),
            f"<p id='wear'>{offset}{_blocks(correction)}</p>",
        )
        + section("errors", say("Errors of the features"), feature_table(correction, say), _legend(correction, say))
    )


def _setup(correction: Correction, say: Texts) -> str:
    """In which frame positions are, of a part with several set-ups."""
    setup = correction.record.options.get("setup")
    if not isinstance(setup, dict):
        return ""
    words = say(
        "Set-up {name}: positions are those of its program, {formula} of the part.",
        name=esc(setup["name"]),
        formula=esc(setup["z_of_program"]),
    )
    return f"<p class='note' id='setup'>{words}</p>"


def _blocks(correction: Correction) -> str:
    """The tool offset in the control's words."""
    return "".join(f"<br><code>{esc(block)}</code>" for block in correction.wear.blocks)


def _legend(correction: Correction, say: Texts) -> str:
    """Explains the table's columns and signs."""
    columns = say(
        "Before: measured after the semi-finish cut. After: <b>predicted</b>, not measured, with U "
        "(<a href='#uncertainty'>what it holds</a>). Left out: each touch predicted from all others; what a place "
        "between the touches may expect."
    )
    signs = say(
        "Errors are along the outward normal of the nominal profile: <b class='on'>+ is material left on</b> (red), "
        "<b class='off'>− is too much taken</b> (blue). x is a radius. u is one standard uncertainty; "
    )
    return f"<p class='note'>{columns}</p><p class='note'>{signs}{_expanded(correction, say)}</p>{on_screen(say)}"


def _expanded(correction: Correction, say: Texts) -> str:
    """Explains ± and U."""
    spare = correction.model.degrees_of_freedom
    known = (
        say("Student’s distribution for {n} spare touches", n=spare)
        if spare
        else say("no touch is spare, so from gauging alone")
    )
    return say(
        "± and U hold 95 %: k u, with k = {fitted:.2f} for what is fitted or scatters ({known}) and k = {stated:.2f} "
        "for what was gauged or is stated beforehand, root of squares.",
        fitted=coverage_factor(spare or None),
        known=known,
        stated=coverage_factor(),
    )


def _part(correction: Correction, say: Texts) -> str:
    def both(width: int) -> Figure:
        return whiskers.before_and_after(correction, width, say)

    def enlarged(width: int) -> Figure:
        return whiskers.after_enlarged(correction, width, say)

    above = say("Errors × {times}: above the spindle axis as measured, below as predicted.", times=_times(both, say))
    after = say("Predicted errors × {times}, with U in grey.", times=_times(enlarged, say))
    return section("part", say("The part"), _figure("before-after", both, above), _figure("after", enlarged, after))


def _figure(name: str, drawn: Callable[[int], Figure], caption: str) -> str:
    """A figure as wide as the page, and as wide as a telephone."""
    return figure_block(name, {shown: drawn(width) for shown, width in WIDTHS.items()}, caption)


def _times(drawn: Callable[[int], Figure], say: Texts) -> str:
    return times(drawn(whiskers.WIDTH)["layout"]["meta"]["magnification"], say)


def _curves(correction: Correction, say: Texts) -> str:
    """A figure a feature with two touches or more; a line for the others."""
    drawn, undrawn = [], []
    for i, feature in enumerate(correction.profile.features):
        caption = f"<b>{esc(feature.name)}</b>: {esc(say.note(kind_of_correction(correction, i)))}"
        if _has_curve(correction, i):
            drawn.append(_figure(f"curve-{i}", partial(error_curve, correction, i, say=say), caption))
        else:
            undrawn.append(caption)
    legend = say(
        "Upper panel: touches with ±U, fitted curve, its 95 % band (Student), ▲ knots, □ prescribed ends. Lower panel, "
        "own scale: ● predicted after, ◇ the touch predicted without itself, grey: ±U of the next cut."
    )
    rest = say(
        "Without a figure: {features}. <a href='#why'>Decisions</a> says why.", features="; ".join(undrawn)
    )  # fmt: skip
    figures = f'<div class="figures">{"".join(drawn)}</div>'
    return section(
        "curves", say("Error curves"), f"<p class='note'>{legend}</p>", figures, f"<p>{rest}</p>" if undrawn else ""
    )


def _has_curve(correction: Correction, index: int) -> bool:
    """One touch makes a constant: a picture would add nothing to its number."""
    return len(correction.touches.of_feature(index)) > 1


def _program(correction: Correction, say: Texts) -> Iterator[str]:
    """The changes of the program to finish with, and of the variant that changes tool offsets only."""
    source, decision = correction.source_program, correction.decision
    if not decision.by_offset:
        name = f"<code>{esc(correction.corrected_name)}</code>"
        gone, come = changed_lines(source, correction.corrected_program)
        counted = say("{n} lines in the place of {gone}, all others as they were.", n=come, gone=gone)
        yield f"<p>{name}: {counted}</p>"
        yield program_diff(source, correction.corrected_program, say)
    if correction.offsets_program is None:
        return
    alone = say(
        "<code>{program}</code>: tool offsets alone, coordinates as they were; it leaves up to {left} {um}.",
        program=esc(correction.offsets_name),
        left=say.size(max(decision.x.largest_left_mm, decision.z.largest_left_mm) * UM_PER_MM),
    )
    yield f"<p>{alone}</p>"
    yield program_diff(source, correction.offsets_program, say)


def _numbers(correction: Correction, say: Texts) -> str:
    file = esc(f"touches-{correction.record.id}.csv")
    csv = quote(touches_csv(correction))
    button = f'<a download="{file}" href="data:text/csv;charset=utf-8,{csv}">{say("Download as CSV")}</a>'
    return section("numbers", say("Numbers"), touches_table(correction, say), f'<p class="button">{button}</p>')


def _origin(correction: Correction, say: Texts) -> str:
    record = correction.record
    inputs = [(esc(name), f"<code class='hash'>{esc(digest)}</code>") for name, digest in record.inputs_sha256.items()]
    options = [(esc(name), esc(say.value(value))) for name, value in flat(record.options, say)]
    version = say(
        "trueloop {version}. The record of this id names every changed word.", version=esc(record.trueloop_version)
    )
    return section(
        "origin",
        say("Made from"),
        table((say("input"), "SHA-256"), inputs, words=(0, 1), name="inputs"),
        table((say("option"), say("value")), options, words=(0, 1), name="options"),
        f"<p class='note'>{version}</p>",
    )


def flat(options: Mapping[str, object], say: Texts, prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yields options that are tables of options in turn, with dotted names; one left open as chosen by trueloop."""
    for name, value in options.items():
        if isinstance(value, Mapping):
            yield from flat(value, say, f"{prefix}{name}.")
        else:
            yield prefix + name, say("chosen by trueloop") if value is None else value
