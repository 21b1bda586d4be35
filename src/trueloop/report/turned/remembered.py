"""The page's section on earlier parts of the edge: what came from memory, what from today's touches, and alarms."""

from collections.abc import Callable

import numpy as np

from trueloop.geometry.feature import is_curved
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.from_memory import FromMemory
from trueloop.report.markup import esc, section, table
from trueloop.report.style import Figure
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures.remembered import remembered
from trueloop.units import UM_PER_MM

Shown = Callable[[str, Callable[[int], Figure], str], str]
"""A figure by its name, as drawn for a width, with its caption."""


def memory_section(correction: Correction, say: Texts, figure: Shown) -> str:
    """The section; empty without earlier parts."""
    memory = correction.memory
    if memory is None:
        return ""
    words = "".join(f"<li>{esc(say.note(one))}</li>" for one in memory.words(correction.profile))
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
    """For JSON: lengths in µm, angles in degrees; None without earlier parts."""
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
            {
                "feature": correction.profile.names[index],
                "from_memory_percent": 100.0 * memory.share(index),
            }
            for index in memory.features
        ],
        "touches": _shares(correction, memory),
        "alarms": list(memory.alarms),
        "words": list(memory.words(correction.profile)),
    }


def _shares(correction: Correction, memory: FromMemory) -> list[dict[str, object]]:
    """What is taken off at each touch of an arc that memory tells, and the share of it that came from memory."""
    vectors, weight = correction.model.vectors, correction.options.weight
    rows = np.flatnonzero(np.isin(vectors.feature_index, memory.features))
    from_memory = weight * memory.taken_off_mm(
        vectors.feature_index[rows],
        vectors.arc_length_mm[rows],
    )
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
