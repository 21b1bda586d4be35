"""What is noticed of events in the simulated shop, and what is noticed where nothing happened.

The edge model judges parts of a shop that it was not made from (`trueloop_lab.simulator.series`): six parts are in, the
seventh has the event. Tables of `studies.memory_study`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from studies.memory_level_study import SEED
from trueloop.arrays import Array, Integers
from trueloop.domain.life import Stage
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.memory.noticing import PartChanges, notice_part
from trueloop_lab.simulator.series import Event, Series, Shop, What, draw

HISTORIES: Final = 60
PARTS: Final = 6
LIKE_IT: Final = 30
ALIKE: Final = 30
"""Histories, and parts that might follow each, where nothing happens."""
PROBE_U_MM: Final = 0.0005
THREE: Final = np.array([2, 9, 16])
"""The 3rd, 10th and 17th touch."""
SHOP: Final = Shop(parts=PARTS + 1)
MEMORY: Final = "memory"
EVENTS: Final[tuple[tuple[str, What | str, tuple[float, ...], str, str], ...]] = (
    (
        "form of the edge differs by 3 / 5 / 10 / 20 µm RMS",
        What.EDGE,
        (0.003, 0.005, 0.010, 0.020),
        "8 / 55 / 97 / 100",
        "3 / 19 / 61 / 93 → 6 / 47 / 96 / 100",
    ),
    ("offset of both cuts by 10 / 15 µm", What.OFFSET, (0.010, 0.015), "74 / 100", "63 / 99"),
    (
        "finish cut of one part off by 5 / 8 / 12 µm",
        What.FINISH,
        (0.005, 0.008, 0.012),
        "after: 9 / 60 / 99",
        "→ 6 / 46 / 97",
    ),
    ("correction not run / run twice", What.CORRECTION, (0.0, 2.0), "after: 100", "→ 100"),
    ("its share from memory likewise", MEMORY, (0.0, 2.0), "after: 99.9", "→ 99.9"),
)
"""Name, kind, sizes, and what the design's own simulation noticed with 20 and with 3 touches, in %."""
NOISES: Final = (
    ("normal", SHOP),
    ("t₄", replace(SHOP, heavy_tails=True)),
    ("2 % gross touches", replace(SHOP, gross_share=0.02)),
)


def cleaned(part: MadePart, found: Mapping[Stage, PartChanges]) -> MadePart:
    """The part as it may be learned from: without the touches that were left out, and without its finish inspection
    where that is in quarantine.
    """
    before, after = (found.get(stage, PartChanges()) for stage in (Stage.SEMIFINISH, Stage.FINISH))
    touches = part.semifinish.chosen(_stays(len(part.semifinish), before))
    if part.finish is None or after.quarantine:
        return replace(part, semifinish=touches, finish=None, correction_mm=None, from_memory_mm=None)
    stays = _stays(len(part.finish), after)
    taken, added = part.correction_mm, part.from_memory_mm
    return replace(
        part,
        semifinish=touches,
        finish=part.finish.chosen(stays),
        correction_mm=None if taken is None else taken[stays],
        from_memory_mm=None if added is None else added[stays],
    )


def _stays(places: int, found: PartChanges) -> Integers:
    return np.delete(np.arange(places), [touch.index for touch in found.left_out])


def events(histories: int = HISTORIES, shop: Shop = SHOP) -> str:
    """Shares of parts noticed, by event, with 20 and with 3 touches."""
    every = np.arange(len(shop.angle_rad))
    noticed = {n: [_of_history(shop, k, touches) for k in range(histories)] for n, touches in ((20, every), (3, THREE))}
    rows = []
    for name, kind, sizes, by_20, by_3 in EVENTS:
        cells = []
        for n in (20, 3):
            before, after = (
                " / ".join(_share([one[kind, size][which] for one in noticed[n]]) for size in sizes) for which in (0, 1)
            )
            cells.append(f"{before} → {after}")
        rows.append(f"| {name} | {cells[0]} | {by_20} | {cells[1]} | {by_3} |")
    head = "| event | 20 touches, before → after | design | 3 touches, before → after | design |"
    return "\n".join([f"{histories} histories of six parts.", "", head, "|---|---|---|---|---|", *rows, ""])


def quiet_events(histories: int = HISTORIES) -> str:
    """The same where parts have no form of their own, nothing wears and nothing warms up."""
    still = replace(SHOP, own_form_mm=0.0, wear_mm=0.0, break_in_mm=0.0, warming_mm=0.0)
    return events(histories, still)


def false_alarms(histories: int = LIKE_IT) -> str:
    """Shares of parts at which something was noticed although nothing happened, with two and with six parts in."""
    rows = []
    for name, shop in NOISES:
        for touches in (np.arange(len(shop.angle_rad)), THREE):
            cells = []
            for known in (2, PARTS):
                found = [one for k in range(histories) for one in _plain(shop, k, touches, known)]
                cells += [_percent([any(f.alarms for f in one) for one in found])]
            cells.append(_percent([any(f.left_out for f in one) for one in found]))
            rows.append(f"| {name} | {len(touches)} | {' | '.join(cells)} |")
    head = "| noise | touches | parts alarmed, two parts in | six parts in | parts with a touch left out |"
    return "\n".join([f"{histories * ALIKE} parts a cell.", "", head, "|---|---:|---:|---:|---:|", *rows, ""])


def part_of(series: Series, k: int, touches: Integers, correction: Array, added: Array, run: float = 1.0) -> MadePart:
    """Part k as it is kept: touched at some places, inspected at all. Of memory's share `added`, `run` arrived."""
    finish = series.inspected_mm(k, correction + (run - 1) * added)
    at = np.arange(len(series.angle_rad))
    before, after = _errors(series, touches, series.semifinish_mm[k][touches]), _errors(series, at, finish)
    return MadePart("arc", str(k), "set", k, before, after, correction, added, series.minutes_in_cut[k])


def _of_history(shop: Shop, number: int, touches: Integers) -> dict[tuple[What | str, float], tuple[bool, bool]]:
    """Whether each event is noticed at the seventh part, by its touches and by its inspection or these."""
    found = {}
    for _, kind, sizes, _, _ in EVENTS:
        for size in sizes:
            happened = [] if kind is MEMORY else [Event(What(kind), PARTS, size)]
            series = draw(shop, np.random.default_rng(SEED + number), happened)
            corrections = _corrections(series, touches)
            made = [part_of(series, k, touches, *corrections[k]) for k in range(PARTS)]
            last = part_of(series, PARTS, touches, *corrections[PARTS], size if kind is MEMORY else 1.0)
            said = notice_part(tuple(made), last)
            before, after = (said[stage].own_fit for stage in (Stage.SEMIFINISH, Stage.FINISH))
            found[kind, size] = before, before or after
    return found


def _corrections(series: Series, touches: Integers) -> list[tuple[Array, Array]]:
    """What is corrected, and memory's share of it: the mean of earlier parts, moved to where today's touches lie; with
    all touches these themselves, and the mean of what finish cuts did differently so far.
    """
    before, after = series.semifinish_mm, series.uncorrected_mm
    if len(touches) == len(series.angle_rad):
        differ = after - before
        added = [differ[:k].mean(axis=0) if k else 0 * differ[0] for k in range(len(differ))]
        return [(before[k] + more, more) for k, more in enumerate(added)]
    ways, found = np.stack([np.sin(series.angle_rad), np.cos(series.angle_rad)], axis=1), []
    for k, touched in enumerate(before):
        mean = after[:k].mean(axis=0) if k else 0 * touched
        own = ways @ np.linalg.lstsq(ways[touches], (touched - mean)[touches], rcond=None)[0]
        found.append((mean + own, mean))
    return found


def _plain(shop: Shop, number: int, touches: Integers, known: int) -> list[tuple[PartChanges, ...]]:
    """What is noticed of parts that might come after `known` ones; what is left out of those is not learned."""
    alike = replace(shop, parts=known + ALIKE, stands_from=known)
    series = draw(alike, np.random.default_rng(SEED + number))
    corrections, found = _corrections(series, touches), []
    history: tuple[MadePart, ...] = ()
    for k in range(known):
        part = part_of(series, k, touches, *corrections[k])
        history = (*history, cleaned(part, notice_part(history, part)))
    for k in range(known, alike.parts):
        part = replace(part_of(series, k, touches, *corrections[known]), order=known)
        found.append(tuple(notice_part(history, part).values()))
    return found


def _errors(series: Series, at: Integers, error_mm: Array) -> CutErrors:
    names = tuple(f"P{k + 1}" for k in at)
    return CutErrors(("arc",) * len(at), names, series.angle_rad[at], error_mm, np.full(len(at), PROBE_U_MM))


def _share(found: Sequence[bool]) -> str:
    return f"{100 * np.mean(found):.0f}"


def _percent(found: Sequence[bool]) -> str:
    return f"{100 * np.mean(found):.2f} %"
