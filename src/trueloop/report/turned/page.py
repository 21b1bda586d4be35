"""The report: one HTML file that needs nothing else, neither a network nor, for its words and pictures, scripts.

Figures are Plotly specifications, drawn as pictures (SVG). A script adds what only a screen can do: values when pointed
at, and a closer look.
"""

from collections.abc import Iterator, Mapping
from typing import Final
from urllib.parse import quote

from trueloop.geometry.feature import Line
from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, section, table
from trueloop.report.program_diff import changed_lines, program_diff
from trueloop.report.shell import ON_SCREEN, figure_block, html_page
from trueloop.report.style import Figure, plain
from trueloop.report.turned import whiskers
from trueloop.report.turned.by_tool import by_tool_block
from trueloop.report.turned.composed import composed_section
from trueloop.report.turned.curves import error_curve
from trueloop.report.turned.decisions import decisions
from trueloop.report.turned.features import kind_of_correction
from trueloop.report.turned.junctions import junctions
from trueloop.report.turned.summary import feature_table, offset_words, verdict
from trueloop.report.turned.touch_table import touches_csv, touches_table
from trueloop.report.turned.uncertainty import uncertainty
from trueloop.turned.error_curve.coverage import coverage_factor
from trueloop.units import UM_PER_MM

FULL_WIDTH: Final = 980
HALF_WIDTH: Final = 480
SIGN: Final = (
    "Errors are along the outward normal of the nominal profile: <b class='on'>+ is material left on</b> (red), "
    "<b class='off'>− is too much taken</b> (blue). x is a radius. u is one standard uncertainty; "
)


def page(correction: Correction) -> str:
    """The whole report of one correction as HTML."""
    title = f"{esc(correction.part)} – correction {esc(correction.record.id)}"
    sections = (
        _part(correction),
        _curves(correction),
        section("uncertainty", "Uncertainty", uncertainty(correction)),
        section("meet", "Junctions", junctions(correction)),
        _program(correction),
        section("why", "Decisions", decisions(correction)),
        composed_section(correction),
        _numbers(correction),
        _origin(correction),
    )
    return html_page(title, _head(correction) + "".join(sections))


def _head(correction: Correction) -> str:
    record = correction.record
    return (
        '<header><p class="kicker">trueloop · correction of a finish cut from the touches after semi-finishing</p>'
        f"<h1>{esc(correction.part)}</h1>"
        f"<p class='meta'>Correction <code>{esc(record.id)}</code> · made {esc(record.made_at)} by "
        f"{esc(record.made_by)} · {esc(correction.dialect)} program · trueloop {esc(record.trueloop_version)}</p>"
        f"{by_tool_block(correction)}"
        f'<p class="verdict"><span class="stamp">Prediction</span>{verdict(correction)}</p>'
        f"<p id='wear'>Tool offset: {esc(offset_words(correction))}{_blocks(correction)}</p>"
        f"{feature_table(correction)}"
        "<p class='note'>Before: measured after the semi-finish cut. After: <b>predicted</b>, not measured, with U "
        "(<a href='#uncertainty'>what it holds</a>). Left out: each touch predicted from all others; what a place "
        "between the touches may expect.</p>"
        f"<p class='note'>{SIGN}{_expanded(correction)}</p>{ON_SCREEN}</header>"
    )


def _blocks(correction: Correction) -> str:
    """The tool offset in the control's words."""
    return "".join(f"<br><code>{esc(block)}</code>" for block in correction.wear.blocks)


def _expanded(correction: Correction) -> str:
    """What ± and U are."""
    spare = correction.model.degrees_of_freedom
    known = f"Student’s distribution for {spare} spare touches" if spare else "no touch is spare, so from gauging alone"
    return (
        f"± and U hold 95 %: k u, with k = {coverage_factor(spare or None):.2f} for what is fitted or scatters "
        f"({known}) and k = {coverage_factor():.2f} for what was gauged or is stated beforehand, root of squares."
    )


def _part(correction: Correction) -> str:
    both = whiskers.before_and_after(correction)
    enlarged = whiskers.after_enlarged(correction)
    return section(
        "part",
        "The part",
        figure_block(
            "before-after", both, f"Errors × {_times(both)}: above the spindle axis as measured, below as predicted."
        ),
        figure_block("after", enlarged, f"Predicted errors × {_times(enlarged)}, with U in grey."),
    )


def _times(figure: Figure) -> str:
    return f"{figure['layout']['meta']['magnification']:,.0f}".replace(",", "\u202f")


def _curves(correction: Correction) -> str:
    """A figure a feature with two touches or more, arcs wide and lines side by side; a line for the others."""
    drawn, undrawn = [], []
    for i, feature in enumerate(correction.profile.features):
        caption = f"<b>{esc(feature.name)}</b>: {kind_of_correction(correction, i)}"
        if _has_curve(correction, i):
            width = HALF_WIDTH if isinstance(feature, Line) else FULL_WIDTH
            drawn.append(
                figure_block(f"curve-{i}", error_curve(correction, i, width), caption, small=width == HALF_WIDTH)
            )
        else:
            undrawn.append(caption)
    legend = (
        "<p class='note'>Upper panel: touches with ±U, fitted curve, its 95 % band (Student), ▲ knots, □ prescribed "
        "ends. Lower panel, own scale: ● predicted after, ◇ the touch predicted without itself, grey: ±U of the next "
        "cut.</p>"
    )
    rest = f"<p>Without a figure: {'; '.join(undrawn)}. <a href='#why'>Decisions</a> says why.</p>" if undrawn else ""
    return section("curves", "Error curves", legend, f'<div class="figures">{"".join(drawn)}</div>', rest)


def _program(correction: Correction) -> str:
    """The changes of the program to finish with, and of the variant that changes tool offsets only."""
    source, decision = correction.source_program, correction.decision
    parts = []
    if not decision.by_offset:
        name = f"<code>{esc(correction.corrected_name)}</code>"
        gone, come = changed_lines(source, correction.corrected_program)
        parts.append(f"<p>{name}: {come} lines in the place of {gone}, all others as they were.</p>")
        parts.append(program_diff(source, correction.corrected_program))
    if correction.offsets_program is None:
        return section("program", "Changes to the program", *parts)
    left = plain(max(decision.x.largest_left_mm, decision.z.largest_left_mm) * UM_PER_MM)
    parts.append(
        f"<p><code>{esc(correction.offsets_name)}</code>: tool offsets alone, coordinates as they were; "
        f"it leaves up to {left} µm.</p>"
    )
    parts.append(program_diff(source, correction.offsets_program))
    return section("program", "Changes to the program", *parts)


def _numbers(correction: Correction) -> str:
    text = touches_csv(correction)
    file = esc(f"touches-{correction.record.id}.csv")
    return section(
        "numbers",
        "Numbers",
        touches_table(correction),
        f'<p class="button"><a download="{file}" href="data:text/csv;charset=utf-8,{quote(text)}">'
        "Download as CSV</a></p>",
        f"<details><summary>The same as CSV text</summary><pre id='csv'>{esc(text)}</pre></details>",
    )


def _origin(correction: Correction) -> str:
    record = correction.record
    inputs = [(esc(name), f"<code class='hash'>{esc(digest)}</code>") for name, digest in record.inputs_sha256.items()]
    options = [(esc(name), esc(value)) for name, value in _flat(record.options)]
    return section(
        "origin",
        "Made from",
        table(("input", "SHA-256"), inputs, words=(0, 1), name="inputs"),
        table(("option", "value"), options, words=(0, 1), name="options"),
        f"<p class='note'>trueloop {esc(record.trueloop_version)}. The record of this id names every changed word.</p>",
    )


def _flat(options: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Options that are tables of options in turn, with dotted names; what was left open is said to be chosen."""
    for name, value in options.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, "chosen by trueloop" if value is None else value


def _has_curve(correction: Correction, index: int) -> bool:
    """One touch makes a constant: no picture tells more of it than its number."""
    return len(correction.touches.of_feature(index)) > 1
