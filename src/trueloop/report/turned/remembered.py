"""The page's section on earlier parts of the edge: what came from memory, what from today's touches, and alarms."""

from collections.abc import Callable, Sequence

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import is_curved
from trueloop.loops.turned.correction import Correction, FromMemory
from trueloop.memory.made_part import Expected
from trueloop.report import style
from trueloop.report.markup import esc, section, table
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.turned.fit.prior.remembered_fit import angles_along
from trueloop.units import UM_PER_MM


def remembered(
    correction: Correction, memory: FromMemory, expected: Expected, width: int, say: Texts = ENGLISH
) -> Figure:
    """Errors in µm over the contact angle in degrees, positive = material left on.

    Band: the next cut's error had nothing been corrected, 95 %. Dotted: the same without a touch of today. Line: what
    the correction takes off. Dots: today's touches, red = material left on, blue = too much taken.
    """
    arcs = [index for index in memory.features if is_curved(correction.profile.features[index])]
    degrees = np.degrees(expected.contact_angle_rad)
    mean = expected.gain * expected.mean_mm * UM_PER_MM
    half = coverage_factor() * np.sqrt(np.diag(expected.covariance_mm2)) * UM_PER_MM
    alone = expected.gain * expected.memory_mm * UM_PER_MM
    runs = [expected.rows(index) for index in arcs]
    shown = np.concatenate([np.empty(0, dtype=np.intp), *runs])
    bands = [_band(degrees[run], mean[run], half[run], say) for run in runs]
    dotted = [_line(degrees[run], alone[run], style.SOFT, say("memory alone"), "dot") for run in runs]
    applied = [_applied(correction, index, say) for index in arcs]
    touches = _touches(correction, arcs, say)
    seen = [
        *(mean + half)[shown],
        *(mean - half)[shown],
        *alone[shown],
        *touches["y"],
        *(y for trace in applied for y in trace["y"]),
    ]
    low, high = style.padded(seen)
    layout = style.layout(
        width,
        380,
        xaxis=style.axis(
            say("contact angle (°): 0 a face, 90 a cylinder"),
            degrees[shown].min() - 2.0,
            degrees[shown].max() + 2.0,
            width // 100,
        ),
        yaxis=style.axis(say("error ({um})"), low * say.per_um, high * say.per_um, 7),
        separators=say.separators,
    )
    data = [*bands, *dotted, *applied, touches]
    return {"data": [style.scaled(trace, 1.0, say.per_um) for trace in data], "layout": layout}


def _band(degrees: Array, mean: Array, half: Array, say: Texts) -> Trace:
    there_and_back = np.concatenate([degrees, degrees[::-1]]).tolist()
    outline = np.concatenate([mean + half, (mean - half)[::-1]]).tolist()
    return style.area(there_and_back, outline, style.BAND, name=say("95 % band"))


def _line(degrees: Array, um: Array, colour: str, name: str, dash: str = "solid") -> Trace:
    return style.lines(degrees.tolist(), um.tolist(), colour, 2, name=name, line={"dash": dash})


def _applied(correction: Correction, index: int, say: Texts) -> Trace:
    """Draws the amount that the correction of one arc takes off."""
    feature = correction.profile.features[index]
    s, angle = angles_along(correction.profile, index)
    taken = correction.options.weight * correction.model.curves[index].value_mm(s)
    if correction.by_offset[index]:
        taken = -(feature.outward_normal(s) @ np.array(correction.decision.offset_mm))
    return _line(np.degrees(angle), taken * UM_PER_MM, style.AFTER, say("applied"))


def _touches(correction: Correction, arcs: Sequence[int], say: Texts) -> Trace:
    vectors = correction.model.vectors
    rows = np.flatnonzero(np.isin(vectors.feature_index, arcs))
    degrees = np.degrees(correction.profile.contact_angle_rad(vectors.feature_index[rows], vectors.arc_length_mm[rows]))
    error = vectors.error_mm[rows] * UM_PER_MM
    hover = [
        say("point {point}", point=style.label(vectors.point[k])) + f"<br>{say.error(e)} {say.um}"
        for k, e in zip(rows, error, strict=True)
    ]
    colours = [style.colour_of(e) for e in error]
    return style.dots(degrees.tolist(), error.tolist(), hover, color=colours, size=9) | {"name": say("touches")}


Shown = Callable[[str, Callable[[int], Figure], str], str]
"""A figure by its name, as drawn for a width, with its caption."""


def memory_section(correction: Correction, say: Texts, figure: Shown) -> str:
    """Writes the section; empty without earlier parts."""
    memory = correction.memory
    if memory is None:
        return ""
    words = "".join(f"<li>{esc(say.note(word))}</li>" for word in memory.words(correction.profile))
    said = f"<ul>{words}</ul>"
    expected = memory.expected
    if expected is None:
        return section("memory", say("Earlier parts of the edge"), said)
    caption = say(
        "Band: the next cut’s error had nothing been corrected (95 %), by earlier parts and today’s touches; dotted: "
        "by earlier parts alone; line: what the correction takes off; ● today’s touches, red = material left on."
    )
    if not any(is_curved(correction.profile.features[index]) for index in memory.features):
        return section("memory", say("Earlier parts of the edge"), said, _table(correction, memory, say))
    drawn = figure("memory-angle", lambda width: remembered(correction, memory, expected, width, say), caption)
    return section("memory", say("Earlier parts of the edge"), said, drawn, _table(correction, memory, say))


def memory_as_dict(correction: Correction) -> dict[str, object] | None:
    """Converts the memory to a dict: lengths in µm, angles in degrees; None without earlier parts."""
    memory = correction.memory
    if memory is None:
        return None
    expected = memory.expected
    return {
        "edge": memory.edge,
        "use": memory.use,
        "applied": memory.applied,
        "inspected_parts": 0 if expected is None else expected.parts,
        "touches_used": len(memory.points),
        "enough_touches": None if expected is None else expected.enough_touches,
        "points_to_keep": list(memory.keep),
        "gain": 1.0 if expected is None else expected.gain,
        "features": [
            {"feature": correction.profile.names[index], "from_memory_percent": 100.0 * memory.share(index)}
            for index in memory.features
        ],
        "touches": _shares(correction, memory),
        "alarms": list(memory.alarms),
        "words": list(memory.words(correction.profile)),
    }


def _shares(correction: Correction, memory: FromMemory) -> list[dict[str, object]]:
    """Returns the correction at each touch of an arc that memory predicts, and memory's share of it."""
    vectors, weight = correction.model.vectors, correction.options.weight
    rows = np.flatnonzero(np.isin(vectors.feature_index, memory.features))
    from_memory = weight * memory.taken_off_mm(vectors.feature_index[rows], vectors.arc_length_mm[rows])
    found: list[dict[str, object]] = []
    for k, share in zip(rows.tolist(), from_memory.tolist(), strict=True):
        index = int(vectors.feature_index[k])
        taken = weight * float(correction.model.curves[index].value_mm(vectors.arc_length_mm[k])[0])
        found.append(
            {
                "feature": correction.profile.names[index],
                "point": vectors.point[k],
                "taken_off_um": taken * UM_PER_MM,
                "from_memory_um": share * UM_PER_MM,
            }
        )
    return found


def _table(correction: Correction, memory: FromMemory, say: Texts) -> str:
    headings = (
        say("feature"),
        say("touches"),
        say("from memory<br>%"),
        say("from touches<br>%"),
        say("largest U<br>{um}"),
    )
    rows = [_row(correction, memory, index, say) for index in memory.features]
    return table(headings, rows, words=(0,), name="memory-shares", stacks=True)


def _row(correction: Correction, memory: FromMemory, index: int, say: Texts) -> list[str]:
    share, along = memory.share(index), correction.profile.features[index].length_mm
    u = correction.next_cut(index, np.linspace(0.0, along, 33)).expanded_u_mm
    touches = len(correction.touches.of_feature(index))
    return [
        esc(correction.profile.names[index]),
        str(touches),
        f"{100.0 * share:.0f}",
        f"{100.0 * (1.0 - share):.0f}",
        say.size(float(np.max(u)) * UM_PER_MM),
    ]
