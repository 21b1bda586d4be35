"""Page of a replay: what was cut, and what a fit of each part's own touches, or memory, would have left in it."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from studies.replay.figures import key, parts_figure, places_figure
from studies.replay.replay import Replayed
from trueloop.report.markup import esc, figure_block, html_page, section, table
from trueloop.report.style import plain
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

WIDTHS: Final = {"wide": 980, "narrow": 370}
HOW: Final = (
    "All figures are root mean squares in µm over the places of the finish inspections. <b>As cut</b> is what was "
    "measured. The others are what would have been left: the error that the finish cut had where nothing was "
    "corrected (measured error and correction together), less what was predicted of it. Each part is predicted from "
    "the parts before it and its own touches, nothing else."
)


def replay_page(
    name: str,
    source: str,
    fits: Sequence[Replayed],
    memory: Mapping[str, Sequence[Replayed]],
    as_first: Sequence[Replayed],
) -> str:
    """`fits` are all parts by the fit of their own touches; `memory` the replays by how they are called.

    `as_first`, where not empty: parts of a new type, each as if it had been the first of it.
    """
    first = next(iter(memory))
    body = (
        f'<header><p class="kicker">trueloop · memory of an edge</p><h1>{esc(name)}</h1>'
        f'{_verdict(fits, memory, first)}<p class="note">{esc(source)}</p></header>'
        + section("types", "By part type", _by_type(fits, memory), f"<p class='note'>{HOW}</p>", _as_first(as_first))
        + section("parts", "Part by part", _parts_figure(fits, memory), _by_part(fits, memory))
        + section("places", "Place by place", _places(fits, memory[first], first))
    )
    return html_page(f"{esc(name)} – memory of an edge", body)


def learned_from(replayed: Sequence[Replayed]) -> list[Replayed]:
    """Without the first part of the edge and the first of each type, of which memory knows least."""
    seen: set[str] = set()
    later = []
    for one in replayed:
        if one.part.part_type in seen and not one.own_fit:
            later.append(one)
        seen.add(one.part.part_type)
    return later


def left_um(replayed: Sequence[Replayed]) -> float:
    """Root mean square of what would have been left."""
    return rms(np.concatenate([one.left_mm for one in replayed])) * UM_PER_MM


def cut_um(replayed: Sequence[Replayed]) -> float:
    """Root mean square of what was measured after the finish cut."""
    errors = [one.part.finish.error_mm for one in replayed if one.part.finish is not None]
    return rms(np.concatenate(errors)) * UM_PER_MM


def inside(replayed: Sequence[Replayed]) -> float:
    """Share of places inside the 95 % band."""
    return float(np.mean(np.concatenate([np.abs(one.left_mm) <= one.predicted.half_band_mm for one in replayed])))


def _verdict(fits: Sequence[Replayed], memory: Mapping[str, Sequence[Replayed]], first: str) -> str:
    later = learned_from(memory[first])
    own = _same_parts(fits, later)
    return (
        f'<p class="verdict"><span class="stamp">Replayed</span>On the {len(later)} parts whose type the edge had cut '
        f"before, memory would have left {plain(left_um(later), 2)} µm RMS ({esc(first)}), the fit of their own "
        f"touches {plain(left_um(own), 2)} µm; {plain(cut_um(later), 2)} µm were cut.</p>"
    )


def _same_parts(fits: Sequence[Replayed], chosen: Sequence[Replayed]) -> list[Replayed]:
    serials = {one.part.serial for one in chosen}
    return [one for one in fits if one.part.serial in serials]


def _by_type(fits: Sequence[Replayed], memory: Mapping[str, Sequence[Replayed]]) -> str:
    """A row for the first part of each type, and one for those after it."""
    head = ["parts", "as cut", "own fit", *(f"memory,<br>{esc(name)}" for name in memory)]
    rows = []
    for part_type in dict.fromkeys(one.part.part_type for one in fits):
        of_type = [one for one in fits if one.part.part_type == part_type]
        for name, group in ((f"{part_type}, first part", of_type[:1]), (f"{part_type}, parts after it", of_type[1:])):
            if group:
                rows.append((esc(name), *_figures(group, memory)))
    everything = [one for one in fits if one.part.serial != fits[0].part.serial]
    shares = [f"{inside(_same_parts(replayed, everything)):.1%}" for replayed in memory.values()]
    of_fits = f"{inside(everything):.1%}"
    rows.append(("inside their 95 % bands, all but the first", "", of_fits, *shares))
    return table(head, rows, name="types-table", stacks=True)


def _figures(group: Sequence[Replayed], memory: Mapping[str, Sequence[Replayed]]) -> list[str]:
    by_memory = (plain(left_um(_same_parts(replayed, group)), 2) for replayed in memory.values())
    return [plain(cut_um(group), 2), plain(left_um(group), 2), *by_memory]


def _as_first(as_first: Sequence[Replayed]) -> str:
    if not as_first:
        return ""
    return (
        f"<p>Each of the {len(as_first)} {esc(as_first[0].part.part_type)} parts as if it had been the first of its "
        f"type, at contact angles that the edge had seen: memory would have left {plain(left_um(as_first), 2)} µm RMS, "
        f"{plain(cut_um(as_first), 2)} µm were cut.</p>"
    )


def _parts_figure(fits: Sequence[Replayed], memory: Mapping[str, Sequence[Replayed]]) -> str:
    series = {
        "as cut": [cut_um([one]) for one in fits],
        "own fit": [left_um([one]) for one in fits],
        **{f"memory, {name}": [left_um([one]) for one in replayed] for name, replayed in memory.items()},
    }
    serials = [one.part.serial for one in fits]
    caption = f"RMS over the places of each part, in cutting order: {key(list(series))}."
    return figure_block("rms", {kind: parts_figure(serials, series, width) for kind, width in WIDTHS.items()}, caption)


def _by_part(fits: Sequence[Replayed], memory: Mapping[str, Sequence[Replayed]]) -> str:
    head = ["part", "type", "as cut", "own fit"]
    for name in memory:
        head += [f"memory,<br>{esc(name)}", "touches<br>used", "inside<br>its band"]
    rows = []
    for k, fit in enumerate(fits):
        cells = [esc(fit.part.serial), esc(fit.part.part_type), plain(cut_um([fit]), 2), plain(left_um([fit]), 2)]
        for replayed in memory.values():
            one = replayed[k]
            left = plain(left_um([one]), 2) + (" (own fit)" if one.own_fit else "")
            cells += [left, str(one.touches), f"{one.inside:.0%}"]
        rows.append(cells)
    return table(head, rows, words=(0, 1), name="parts-table", stacks=True)


def _places(fits: Sequence[Replayed], replayed: Sequence[Replayed], name: str) -> str:
    """A figure a part."""
    blocks = []
    for fit, one in zip(fits, replayed, strict=True):
        by = "own fit" if one.own_fit else f"memory, {name}"
        part = f"<b>{esc(one.part.serial)}</b> ({esc(one.part.part_type)})"
        caption = f"{part}: {esc(by)}, with its 95 % band"
        blocks.append(figure_block(f"part {one.part.serial}", places_figure(fit, one, by), caption, small=True))
    marks = f"<p class='note'>Over contact angle: {key(['as cut', 'own fit', f'memory, {name}'])}; band: 95 %.</p>"
    return f'{marks}<div class="figures">{"".join(blocks)}</div>'
