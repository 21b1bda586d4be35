"""Figures of an edge: a term of its errors over contact angle, with its band and the parts behind it."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.memory.edge.learnt import Learned, Learnt
from trueloop.report.style import (
    AFTER,
    BAND,
    GRID,
    INK,
    LEFT_ON,
    TAKEN,
    Figure,
    Trace,
    apart,
    area,
    axis,
    dots,
    label,
    layout,
    lines,
    note,
    padded,
    signed,
)
from trueloop.report.tool.shown import ShownEdge, angles_deg, unseen
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

COLOURS: Final = (INK, TAKEN, AFTER, LEFT_ON, "#b26a00", "#6a1b9a", "#5d4037", "#00838f")
WIDTH: Final = 760
HEIGHT: Final = 380


def error_figure(shown: ShownEdge, found: Learnt) -> Figure:
    """The finish error of a next part by its type, had nothing been corrected, with the inspections behind it."""
    at_mm = found.in_all_at_mm + found.behind.left_mm
    return _figure(shown, found, found.in_all, at_mm, found.behind.finish, "error of the finish cut")


def form_figure(shown: ShownEdge, found: Learnt) -> Figure:
    """w(φ) with the semi-finish touches behind it."""
    behind = found.behind
    terms = {"": found.form}
    return _figure(shown, found, terms, found.form_at_mm + behind.left_mm, ~behind.finish, "form of the edge")


def transfer_figure(shown: ShownEdge, found: Learnt) -> Figure:
    """d(φ) with the finish inspections behind it."""
    behind = found.behind
    at_mm = found.transfer_at_mm + behind.left_mm
    return _figure(shown, found, {"": found.transfer}, at_mm, behind.finish, "finish cut less semi-finish cut")


def types_figure(shown: ShownEdge, found: Learnt) -> Figure:
    """What each part type adds, a line with its name each."""
    at = angles_deg(found).tolist()
    ends = {name: UM_PER_MM * float(term.mean_mm[-1]) for name, term in found.by_type.items()}
    low, high = padded([UM_PER_MM * value for term in found.by_type.values() for value in term.mean_mm.tolist()])
    places = apart(ends, 0.06 * (high - low))
    traces = [*_grey(shown, found, low, high)]
    notes = []
    for colour, (name, term) in zip(_colours(found), found.by_type.items(), strict=True):
        traces.append(lines(at, (UM_PER_MM * term.mean_mm).tolist(), colour))
        notes.append(note(at[-1], places[name], f" {label(name)}", xanchor="left", font={"color": colour}))
    axes = {
        "xaxis": axis("contact angle (°)", at[0], at[-1] + 0.15 * (at[-1] - at[0])),
        "yaxis": axis("added by the part type (µm)", min(low, *places.values()), max(high, *places.values())),
        "annotations": notes,
    }
    return {"data": traces, "layout": layout(WIDTH, HEIGHT, **axes)}


def _figure(
    shown: ShownEdge, found: Learnt, terms: Mapping[str, Learned], at_mm: Array, of: Flags, title: str
) -> Figure:
    at, behind = angles_deg(found).tolist(), found.behind
    seen = ~unseen(shown, found)
    ends = [
        UM_PER_MM * (term.mean_mm + sign * NORMAL_95 * term.u_mm)[seen] for term in terms.values() for sign in (1, -1)
    ]
    low, high = padded(np.concatenate([*ends, UM_PER_MM * at_mm[of]]).tolist())
    colour = dict(zip(found.by_type, _colours(found), strict=True))
    points = [
        dots(
            np.degrees(behind.contact_angle_rad[rows]).tolist(),
            (UM_PER_MM * at_mm[rows]).tolist(),
            _hover(found, at_mm, np.flatnonzero(rows)),
            color=colour[name],
            size=4,
        )
        for name in found.by_type
        if np.any(rows := of & np.array([one == name for one in behind.part_type]))
    ]
    traces = [
        *_grey(shown, found, low, high),
        *(area([*at, *at[::-1]], _band(term), BAND) for term in terms.values()),
        *points,
        *(lines(at, (UM_PER_MM * term.mean_mm).tolist(), colour.get(name, INK), 2) for name, term in terms.items()),
    ]
    axes = {"xaxis": axis("contact angle (°)", at[0], at[-1]), "yaxis": axis(f"{title} (µm)", low, high)}
    return {"data": traces, "layout": layout(WIDTH, HEIGHT, **axes)}


def _band(term: Learned) -> list[float]:
    mean, half = UM_PER_MM * term.mean_mm, UM_PER_MM * NORMAL_95 * term.u_mm
    return [*(mean + half).tolist(), *(mean - half).tolist()[::-1]]


def _hover(found: Learnt, at_mm: Array, rows: np.ndarray) -> list[str]:
    behind = found.behind
    return [
        f"part {label(behind.serial[k])} ({label(behind.part_type[k])})<br>"
        f"{np.degrees(behind.contact_angle_rad[k]):.1f}°: {signed(UM_PER_MM * float(at_mm[k]))} µm"
        for k in rows
    ]


def _grey(shown: ShownEdge, found: Learnt, low: float, high: float) -> Iterator[Trace]:
    """Where no part was touched or inspected: up to half a step beyond the angles that are drawn."""
    at, bare = angles_deg(found), unseen(shown, found)
    step = float(at[1] - at[0]) if len(at) > 1 else 0.0
    changes = [0, *(np.flatnonzero(bare[1:] != bare[:-1]) + 1).tolist(), len(at)]
    for first, end in pairwise(changes):
        if bare[first]:
            left, right = float(at[first]) - step / 2, float(at[end - 1]) + step / 2
            yield area([left, right, right, left], [low, low, high, high], GRID)


def _colours(found: Learnt) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(len(found.by_type))]
