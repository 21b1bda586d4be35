"""An edge and what it has taught: page, figures, lines, JSON."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.life import Cut, EdgeEvent, EdgeLife, edge_name, time, where
from trueloop.errors import Finding
from trueloop.memory.edge.learnt import EdgeKnowledge, Learned
from trueloop.report.markup import esc, fields, figure_block, html_page, items, section, table
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
    plain,
    signed,
)
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM


@dataclass(frozen=True, eq=False)
class ShownEdge:
    """The life of an edge, the cuts of it, and what it has taught: None while no part of it was touched.

    `unseen_rad`: nothing is predicted at angles farther from all that were seen. `minutes_in_cut` None: not stated.
    """

    life: EdgeLife
    cuts: tuple[Cut, ...]
    learnt: EdgeKnowledge | None
    findings: tuple[Finding, ...]
    minutes_in_cut: float | None
    unseen_rad: float


def angles_deg(knowledge: EdgeKnowledge) -> Array:
    """Returns the angles of what was learnt, in degrees."""
    return np.degrees(knowledge.contact_angle_rad)


def unseen(shown: ShownEdge, knowledge: EdgeKnowledge) -> Flags:
    """Returns the angles (n,) at which nothing was seen."""
    return knowledge.nearest_rad > shown.unseen_rad


COLOURS: Final = (INK, TAKEN, AFTER, LEFT_ON, "#b26a00", "#6a1b9a", "#5d4037", "#00838f")
WIDTH: Final = 760
HEIGHT: Final = 380


def error_figure(shown: ShownEdge, knowledge: EdgeKnowledge) -> Figure:
    """Draws the finish error of a next part by its type, had nothing been corrected, with the inspections behind it."""
    at_mm = knowledge.in_all_at_mm + knowledge.behind.left_mm
    return _figure(shown, knowledge, knowledge.in_all, at_mm, knowledge.behind.finish, "error of the finish cut")


def form_figure(shown: ShownEdge, knowledge: EdgeKnowledge) -> Figure:
    """Draws w(φ) with the semi-finish touches behind it."""
    behind = knowledge.behind
    terms = {"": knowledge.form}
    return _figure(shown, knowledge, terms, knowledge.form_at_mm + behind.left_mm, ~behind.finish, "form of the edge")


def transfer_figure(shown: ShownEdge, knowledge: EdgeKnowledge) -> Figure:
    """Draws d(φ) with the finish inspections behind it."""
    behind = knowledge.behind
    at_mm = knowledge.transfer_at_mm + behind.left_mm
    return _figure(shown, knowledge, {"": knowledge.transfer}, at_mm, behind.finish, "finish cut less semi-finish cut")


def types_figure(shown: ShownEdge, knowledge: EdgeKnowledge) -> Figure:
    """Draws what each part type adds, a line with its name each."""
    at = angles_deg(knowledge).tolist()
    ends = {name: UM_PER_MM * float(term.mean_mm[-1]) for name, term in knowledge.by_type.items()}
    low, high = padded([UM_PER_MM * value for term in knowledge.by_type.values() for value in term.mean_mm.tolist()])
    places = apart(ends, 0.06 * (high - low))
    traces = [*_grey(shown, knowledge, low, high)]
    notes = []
    for colour, (name, term) in zip(_colours(knowledge), knowledge.by_type.items(), strict=True):
        traces.append(lines(at, (UM_PER_MM * term.mean_mm).tolist(), colour))
        notes.append(note(at[-1], places[name], f" {label(name)}", xanchor="left", font={"color": colour}))
    axes = {
        "xaxis": axis("contact angle (°)", at[0], at[-1] + 0.15 * (at[-1] - at[0])),
        "yaxis": axis("added by the part type (µm)", min(low, *places.values()), max(high, *places.values())),
        "annotations": notes,
    }
    return {"data": traces, "layout": layout(WIDTH, HEIGHT, **axes)}


def _figure(
    shown: ShownEdge, knowledge: EdgeKnowledge, terms: Mapping[str, Learned], at_mm: Array, of: Flags, title: str
) -> Figure:
    at, behind = angles_deg(knowledge).tolist(), knowledge.behind
    seen = ~unseen(shown, knowledge)
    ends = [
        UM_PER_MM * (term.mean_mm + sign * NORMAL_95 * term.u_mm)[seen] for term in terms.values() for sign in (1, -1)
    ]
    low, high = padded(np.concatenate([*ends, UM_PER_MM * at_mm[of]]).tolist())
    colour = dict(zip(knowledge.by_type, _colours(knowledge), strict=True))
    points = [
        dots(
            np.degrees(behind.contact_angle_rad[rows]).tolist(),
            (UM_PER_MM * at_mm[rows]).tolist(),
            _hover(knowledge, at_mm, np.flatnonzero(rows)),
            color=colour[name],
            size=4,
        )
        for name in knowledge.by_type
        if np.any(rows := of & np.array([one == name for one in behind.part_type]))
    ]
    traces = [
        *_grey(shown, knowledge, low, high),
        *(area([*at, *at[::-1]], _band(term), BAND) for term in terms.values()),
        *points,
        *(lines(at, (UM_PER_MM * term.mean_mm).tolist(), colour.get(name, INK), 2) for name, term in terms.items()),
    ]
    axes = {"xaxis": axis("contact angle (°)", at[0], at[-1]), "yaxis": axis(f"{title} (µm)", low, high)}
    return {"data": traces, "layout": layout(WIDTH, HEIGHT, **axes)}


def _band(term: Learned) -> list[float]:
    mean, half = UM_PER_MM * term.mean_mm, UM_PER_MM * NORMAL_95 * term.u_mm
    return [*(mean + half).tolist(), *(mean - half).tolist()[::-1]]


def _hover(knowledge: EdgeKnowledge, at_mm: Array, rows: np.ndarray) -> list[str]:
    behind = knowledge.behind
    return [
        f"part {label(behind.serial[k])} ({label(behind.part_type[k])})<br>"
        f"{np.degrees(behind.contact_angle_rad[k]):.1f}°: {signed(UM_PER_MM * float(at_mm[k]))} µm"
        for k in rows
    ]


def _grey(shown: ShownEdge, knowledge: EdgeKnowledge, low: float, high: float) -> Iterator[Trace]:
    """Where no part was touched or inspected: up to half a step beyond the angles that are drawn."""
    at, bare = angles_deg(knowledge), unseen(shown, knowledge)
    step = float(at[1] - at[0]) if len(at) > 1 else 0.0
    changes = [0, *(np.flatnonzero(bare[1:] != bare[:-1]) + 1).tolist(), len(at)]
    for first, end in pairwise(changes):
        if bare[first]:
            left, right = float(at[first]) - step / 2, float(at[end - 1]) + step / 2
            yield area([left, right, right, left], [low, low, high, high], GRID)


def _colours(knowledge: EdgeKnowledge) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(len(knowledge.by_type))]


STEP_DEG: Final = 10
"""Between the rows of the table in the terminal."""
NOTHING: Final = (
    "no part of this edge was touched or inspected on an arc or a curve, along which the contact angle turns"
)


def event_line(event: EdgeEvent) -> str:
    """Describes one event: when, which edge, what, by whom, with its values."""
    values = ", ".join(f"{name} {value:g}" for name, value in event.values.items())
    by = f", by {event.by}" if event.by else ""
    return f"{time(event.at)}  {edge_name(event.edge)}: {event.kind}" + (f" ({values})" if values else "") + by


def event_as_dict(event: EdgeEvent) -> dict[str, object]:
    """Returns an event as JSON-ready values."""
    return {
        "kind": str(event.kind),
        "at": event.at.isoformat(),
        "by": event.by,
        "machine": None if event.machine is None else event.machine.name,
        **_edge(event),
        "values": dict(event.values),
    }


def life_line(life: EdgeLife) -> str:
    """Describes a mounted edge, or one that ended, in a line."""
    end = life.ended
    nose = life.edge.tool.corner_radius_mm
    radius = "" if nose is None else f", nose radius {nose:g} mm"
    state = f"set {time(life.set_at)}" if end is None else f"{end.kind} {time(end.at)}"
    return f"{where(life)}{radius}: mounted {time(life.began)}, {state}"


def life_as_dict(life: EdgeLife) -> dict[str, object]:
    """Returns a life as JSON-ready values."""
    end = life.ended
    return {
        **_edge(life.events[-1]),
        "machine": None if life.machine is None else life.machine.name,
        "nose_radius_mm": life.edge.tool.corner_radius_mm,
        "mounted_at": life.began.isoformat(),
        "set_at": life.set_at.isoformat(),
        "ended_by": None if end is None else str(end.kind),
        "ended_at": None if end is None else end.at.isoformat(),
    }


def edge_lines(shown: ShownEdge) -> Iterator[str]:
    """Yields all that is known of an edge, for people."""
    yield life_line(shown.life)
    yield from (f"  {event_line(event)}" for event in shown.life.events)
    yield cut_words(shown)
    if shown.learnt is None:
        yield f"nothing learnt yet: {NOTHING}"
    else:
        found = shown.learnt
        yield f"learnt from {found.parts} parts, {found.inspected} of them inspected after the finish cut"
        yield setting_words(found)
        rows = [heads_of(found), *rows_of(shown, found)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        yield from ("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    yield from map(str, shown.findings)


def edge_as_dict(shown: ShownEdge) -> dict[str, object]:
    """Returns an edge as JSON-ready values; errors in µm, positive where material is left on."""
    return {
        **life_as_dict(shown.life),
        "events": [event_as_dict(event) for event in shown.life.events],
        "cuts": len(shown.cuts),
        "minutes_in_cut": shown.minutes_in_cut,
        "learnt": None if shown.learnt is None else _summary_learnt(shown, shown.learnt),
        "findings": [f"{finding.code}: {finding.message}" for finding in shown.findings],
    }


def cut_words(shown: ShownEdge) -> str:
    """Describes how much an edge cut."""
    minutes = shown.minutes_in_cut
    return f"{len(shown.cuts)} cuts kept" + ("" if minutes is None else f", {minutes:.0f} minutes in cut")


def setting_words(knowledge: EdgeKnowledge) -> str:
    """Describes where the tip lies off its setting, with its uncertainty (95 %)."""
    (x, z), (ux, uz) = UM_PER_MM * knowledge.setting_mm, UM_PER_MM * NORMAL_95 * knowledge.setting_u_mm
    return f"setting: x {signed(float(x))} ± {ux:.1f} µm (of the radius), z {signed(float(z))} ± {uz:.1f} µm (95 %)"


def rows_of(shown: ShownEdge, knowledge: EdgeKnowledge) -> Iterator[tuple[str, ...]]:
    """Yields every so many degrees: angle, form, transfer, part type's addition and total; dashes where unseen."""
    at, bare = angles_deg(knowledge), unseen(shown, knowledge)
    for k in np.flatnonzero(np.round(at) % STEP_DEG == 0):
        terms = (
            knowledge.form,
            knowledge.transfer,
            *(term[name] for name in knowledge.by_type for term in _by_type(knowledge)),
        )
        yield f"{at[k]:.0f}", *("–" if bare[k] else _value(term, int(k)) for term in terms)


def heads_of(knowledge: EdgeKnowledge) -> tuple[str, ...]:
    """Returns the headings of the columns."""
    of_types = (f"{name} {what} (µm)" for name in knowledge.by_type for what in ("adds", "in all"))
    return "angle (°)", "form (µm)", "finish less semi-finish (µm)", *of_types


def _by_type(knowledge: EdgeKnowledge) -> tuple[Mapping[str, Learned], Mapping[str, Learned]]:
    return knowledge.by_type, knowledge.in_all


def _value(term: Learned, k: int) -> str:
    half = plain(NORMAL_95 * UM_PER_MM * float(term.u_mm[k]))
    return f"{signed(UM_PER_MM * float(term.mean_mm[k]))} ± {half}"


def _summary_learnt(shown: ShownEdge, knowledge: EdgeKnowledge) -> dict[str, object]:
    bare = unseen(shown, knowledge)
    return {
        "parts": knowledge.parts,
        "inspected": knowledge.inspected,
        "setting_um": {"x_radius": _um(knowledge.setting_mm)[0], "z": _um(knowledge.setting_mm)[1]},
        "setting_u_um": {"x_radius": _um(knowledge.setting_u_mm)[0], "z": _um(knowledge.setting_u_mm)[1]},
        "contact_angle_deg": [round(float(angle), 3) for angle in angles_deg(knowledge)],
        "seen": [not one for one in bare.tolist()],
        "form_um": _um(knowledge.form.mean_mm),
        "form_u_um": _um(knowledge.form.u_mm),
        "transfer_um": _um(knowledge.transfer.mean_mm),
        "transfer_u_um": _um(knowledge.transfer.u_mm),
        "by_type_um": {name: _um(term.mean_mm) for name, term in knowledge.by_type.items()},
        "in_all_um": {name: _um(term.mean_mm) for name, term in knowledge.in_all.items()},
        "in_all_u_um": {name: _um(term.u_mm) for name, term in knowledge.in_all.items()},
        "by_type_u_um": {name: _um(term.u_mm) for name, term in knowledge.by_type.items()},
    }


def _um(values_mm: "Sequence[float] | np.ndarray") -> list[float]:
    return [round(UM_PER_MM * float(value), 3) + 0.0 for value in values_mm]


def _edge(event: EdgeEvent) -> dict[str, object]:
    edge = event.edge
    return {"tool": edge.tool.number, "holder": edge.tool.name, "insert": edge.insert, "corner": edge.corner}


ERROR = (
    "Finish error of a next part of each type in the present setting, had nothing been corrected, with its 95 % band; "
    "dots: finish inspections with the correction added, as in the present setting. Grey: angles that no part was "
    "touched at."
)
FORM = (
    "Form of the edge with its 95 % band; dots: touches after the semi-finish cut, less what setting, part type and "
    "part add. Form and setting share an offset: each alone is known less well than their sum."
)
TRANSFER = (
    "What the finish cut leaves more than the semi-finish cut, with its 95 % band; dots: finish inspections with the "
    "correction added, less what all else adds."
)
TYPES = "What the finish cut of each part type has besides: its own setting, and its own share of the finish cut."


def edge_page(shown: ShownEdge) -> str:
    """Writes the page as HTML; it needs no other file."""
    name, life = esc(edge_name(shown.life.edge)), shown.life
    nose = life.edge.tool.corner_radius_mm
    end = life.ended
    head = (
        '<header><p class="kicker">trueloop · what an edge has taught</p>'
        f"<h1>{name}</h1><p class='meta'>{esc(cut_words(shown))}</p>"
        "<p class='note'>Errors in µm along the normal, positive where material is left on. The contact angle is 90° "
        "on a cylinder, 0° on a face that looks along +z.</p></header>"
    )
    rows = [
        ("Machine", "" if life.machine is None else esc(life.machine.name)),
        ("Nose radius", "" if nose is None else f"{nose:g} mm"),
        ("Mounted", time(life.began)),
        ("Set", time(life.set_at)),
        ("Ended", "" if end is None else f"{end.kind} {time(end.at)}"),
    ]
    body = head + fields(rows) + _learnt(shown)
    body += section("events", "Events", items(esc(event_line(event)) for event in life.events))
    if shown.findings:
        body += section("findings", "Findings", items(f"{esc(f.code)}: {esc(f.message)}" for f in shown.findings))
    return html_page(f"{name} – edge", body)


def _learnt(shown: ShownEdge) -> str:
    found = shown.learnt
    if found is None:
        return section("learnt", "Learnt", "<p>Nothing yet: " + NOTHING + ".</p>")
    said = f"<p>From {found.parts} parts, {found.inspected} of them inspected after the finish cut.</p>"
    figures = [figure_block("error", error_figure(shown, found), ERROR)]
    figures.append(figure_block("form", form_figure(shown, found), FORM))
    if found.inspected:
        figures.append(figure_block("transfer", transfer_figure(shown, found), TRANSFER))
    figures.append(figure_block("types", types_figure(shown, found), TYPES))
    rows = [tuple(map(esc, row)) for row in rows_of(shown, found)]
    return (
        section("learnt", "Error over contact angle", said, f"<p>{esc(setting_words(found))}</p>", *figures)
        + section("values", "Values", table(tuple(map(esc, heads_of(found))), rows, words=()))
    )  # fmt: skip
