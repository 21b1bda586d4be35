"""The page's section on the sources of the errors: a bar for the share of each source, feature by feature."""

from collections.abc import Callable
from typing import Final

from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.error_sources import FeatureSources, Share, Source
from trueloop.report import style
from trueloop.report.markup import esc, section, table
from trueloop.report.still import svg
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.units import UM_PER_MM

ROW_PX: Final = 17
HALF_BAR: Final = 0.36
"""Half of a bar's height, in rows."""
U_ENDS: Final = 0.2


def source_name(source: Source, say: Texts) -> str:
    """Names a source in the page's language."""
    return {
        Source.MACHINE: say("machine"),
        Source.SETTING: say("tool setting"),
        Source.NOSE: say("nose of the tool"),
        Source.PART: say("part and clamping"),
        Source.NEXT_CUT: say("next cut"),
        Source.MEASURING: say("measuring"),
    }[source]


def source_bars(correction: Correction, width: int, say: Texts = ENGLISH) -> Figure:
    """Draws a bar in µm for the mean share of each source, red = leaves material on, with ± U (95 %) as a line."""
    places, notes, traces, ends, row = dict[float, str](), list[dict[str, object]](), list[Trace](), [0.0], 0.0
    for source in correction.sources:
        notes.append({"row": row, "text": f"<b>{esc(correction.profile.names[source.index])}</b>"})
        for share in source.shares:
            row -= 1.0
            places[row] = source_name(share.source, say)
            traces += _bar(correction, source, share, row, say)
            u = coverage_factor() * share.standard_u_mm
            ends += [(share.mean_mm - u) * UM_PER_MM, (share.mean_mm + u) * UM_PER_MM]
        row -= 1.5
    low, high = style.padded(ends, 0.05)
    drawn = [style.note(low, float(str(note["row"])), str(note["text"]), xanchor="left") for note in notes]
    axis = style.axis(say("error ({um})"), low * say.per_um, high * say.per_um, width // 100)
    rows = {"tickvals": list(places), "ticktext": list(places.values()), "zeroline": False}
    layout = style.layout(
        width,
        round(-row * ROW_PX) + 90,
        margin={"l": 132, "r": 16, "t": 14, "b": 52},
        xaxis=axis,
        yaxis=style.axis("", row + 0.5, 0.8) | rows,
        annotations=[style.scaled(note, say.per_um, 1.0) for note in drawn],
        separators=say.separators,
    )
    return {"data": [style.scaled(trace, say.per_um, 1.0) for trace in traces], "layout": layout}


def source_svg(correction: Correction, width: int, say: Texts) -> str:
    """Draws the bars as a picture, with the sum of each feature in words."""
    sums = (f"{correction.profile.names[of.index]} {_sum(of, say)}" for of in correction.sources)
    said = say("Errors of the next cut, had nothing been corrected, in {um}: {sums}", sums="; ".join(sums))
    return svg(source_bars(correction, width, say), style.label(said))


def _bar(correction: Correction, of: FeatureSources, share: Share, row: float, say: Texts) -> list[Trace]:
    mean, u = share.mean_mm * UM_PER_MM, coverage_factor() * share.standard_u_mm * UM_PER_MM
    low, high = row - HALF_BAR, row + HALF_BAR
    bar = style.area([0.0, mean, mean, 0.0], [low, low, high, high], style.colour_of(mean))
    line = style.lines([mean - u, mean + u], [row, row], style.INK, 1.2)
    ends: list[Trace] = [
        style.lines([x, x], [row - U_ENDS, row + U_ENDS], style.INK, 1.2) for x in (mean - u, mean + u)
    ]
    hover = say(
        "{feature}, {source}<br>{mean} ± {u} {um}, along it {low} to {high} {um}",
        feature=style.label(correction.profile.names[of.index]),
        source=source_name(share.source, say),
        mean=say.error(mean),
        u=say.size(u),
        low=say.error(share.low_mm * UM_PER_MM),
        high=say.error(share.high_mm * UM_PER_MM),
    )
    return [bar, line, *ends, style.dots([mean], [row], [hover], color=style.INK, size=4)]


def sources_section(
    correction: Correction, say: Texts, figure: Callable[[str, Callable[[int], Figure], str], str]
) -> str:
    """Writes the section."""
    caption = say(
        "Mean share of each source in the error of the next cut, had nothing been corrected, with ± U (95 %): red "
        "leaves material on, blue takes too much."
    )
    meaning = say(
        "Tool setting displaces all features along X and Z alike; the nose goes by contact angle; part and clamping is "
        "what differs from feature to feature. Next cut: what the next cut does otherwise than the measured one. "
        "Measuring: by how much the measured mean of the feature is off what all measurements show there. Sources of "
        "like effect cannot be told apart on one part: each then has a wide U, their sum has not."
    )
    drawn = figure("sources", lambda width: source_bars(correction, width, say), caption)
    return section(
        "sources", say("Sources of the errors"), drawn, _table(correction, say), f"<p class='note'>{meaning}</p>"
    )


def _table(correction: Correction, say: Texts) -> str:
    shown = [
        source for source in Source if any(share.source is source for of in correction.sources for share in of.shares)
    ]
    headings = (say("feature"), *(source_name(source, say) for source in shown), say("sum<br>{um}"))
    rows = [_row(correction, of, shown, say) for of in correction.sources]
    return table(headings, rows, words=(0,), name="source-shares", stacks=True)


def _row(correction: Correction, of: FeatureSources, shown: list[Source], say: Texts) -> list[str]:
    shares = {share.source: (share.mean_mm, share.standard_u_mm) for share in of.shares}
    cells = [_with_u(*shares[one], say) if one in shares else "–" for one in shown]
    return [esc(correction.profile.names[of.index]), *cells, _sum(of, say)]


def _sum(of: FeatureSources, say: Texts) -> str:
    return _with_u(of.together_mm, of.together_u_mm, say)


def _with_u(mean_mm: float, standard_u_mm: float, say: Texts) -> str:
    return f"{say.error(mean_mm * UM_PER_MM)} ± {say.size(coverage_factor() * standard_u_mm * UM_PER_MM)}"
