"""An edge in lines for people and as JSON: its life, its setting, its errors by contact angle."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.domain.edge_life import EdgeLife
from trueloop.domain.edge_names import edge_name, time, where
from trueloop.domain.life import EdgeEvent
from trueloop.memory.edge.learnt import Learned, Learnt
from trueloop.report.style import plain, signed
from trueloop.report.tool.shown import ShownEdge, angles_deg, unseen
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

STEP_DEG: Final = 10
"""Between the rows of the table in the terminal."""
NOTHING: Final = (
    "no part of this edge was touched or inspected on an arc or a curve, along which the contact angle turns"
)


def event_line(event: EdgeEvent) -> str:
    """One event: when, which edge, what, by whom, with its values."""
    values = ", ".join(f"{name} {value:g}" for name, value in event.values.items())
    by = f", by {event.by}" if event.by else ""
    return f"{time(event.at)}  {edge_name(event.edge)}: {event.kind}" + (f" ({values})" if values else "") + by


def event_as_dict(event: EdgeEvent) -> dict[str, object]:
    """The same as JSON."""
    return {
        "kind": str(event.kind),
        "at": event.at.isoformat(),
        "by": event.by,
        "machine": None if event.machine is None else event.machine.name,
        **_edge(event),
        "values": dict(event.values),
    }


def life_line(life: EdgeLife) -> str:
    """A mounted edge, or one that ended, in a line."""
    end = life.ended
    nose = life.edge.tool.corner_radius_mm
    radius = "" if nose is None else f", nose radius {nose:g} mm"
    state = f"set {time(life.set_at)}" if end is None else f"{end.kind} {time(end.at)}"
    return f"{where(life)}{radius}: mounted {time(life.began)}, {state}"


def life_as_dict(life: EdgeLife) -> dict[str, object]:
    """The same as JSON."""
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
    """All that is known of an edge, for people."""
    yield life_line(shown.life)
    yield from (f"  {event_line(event)}" for event in shown.life.events)
    yield cut_words(shown)
    if shown.learnt is None:
        yield f"nothing learnt yet: {NOTHING}"
    else:
        yield from _learnt_lines(shown, shown.learnt)
    yield from map(str, shown.findings)


def edge_as_dict(shown: ShownEdge) -> dict[str, object]:
    """The same as JSON; errors in µm, positive where material is left on."""
    return {
        **life_as_dict(shown.life),
        "events": [event_as_dict(event) for event in shown.life.events],
        "cuts": len(shown.cuts),
        "minutes_in_cut": shown.minutes_in_cut,
        "learnt": None if shown.learnt is None else _learnt(shown, shown.learnt),
        "findings": [f"{finding.code}: {finding.message}" for finding in shown.findings],
    }


def cut_words(shown: ShownEdge) -> str:
    """How much an edge cut."""
    minutes = shown.minutes_in_cut
    return f"{len(shown.cuts)} cuts kept" + ("" if minutes is None else f", {minutes:.0f} minutes in cut")


def setting_words(found: Learnt) -> str:
    """Where the tip lies off its setting, with what is not known of it."""
    (x, z), (ux, uz) = UM_PER_MM * found.setting_mm, UM_PER_MM * NORMAL_95 * found.setting_u_mm
    return f"setting: x {signed(float(x))} ± {ux:.1f} µm (of the radius), z {signed(float(z))} ± {uz:.1f} µm (95 %)"


def rows_of(shown: ShownEdge, found: Learnt) -> Iterator[tuple[str, ...]]:
    """Every so many degrees: angle, form, transfer, what each part type adds and has in all; dashes where nothing was
    seen.
    """
    at, bare = angles_deg(found), unseen(shown, found)
    for k in np.flatnonzero(np.round(at) % STEP_DEG == 0):
        terms = (found.form, found.transfer, *(term[name] for name in found.by_type for term in _by_type(found)))
        yield f"{at[k]:.0f}", *("–" if bare[k] else _value(term, int(k)) for term in terms)


def heads_of(found: Learnt) -> tuple[str, ...]:
    """Of these columns."""
    of_types = (f"{name} {what} (µm)" for name in found.by_type for what in ("adds", "in all"))
    return "angle (°)", "form (µm)", "finish less semi-finish (µm)", *of_types


def _by_type(found: Learnt) -> tuple[Mapping[str, Learned], Mapping[str, Learned]]:
    return found.by_type, found.in_all


def _learnt_lines(shown: ShownEdge, found: Learnt) -> Iterator[str]:
    yield f"learnt from {found.parts} parts, {found.inspected} of them inspected after the finish cut"
    yield setting_words(found)
    rows = [heads_of(found), *rows_of(shown, found)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    yield from ("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)


def _value(term: Learned, k: int) -> str:
    half = plain(NORMAL_95 * UM_PER_MM * float(term.u_mm[k]))
    return f"{signed(UM_PER_MM * float(term.mean_mm[k]))} ± {half}"


def _learnt(shown: ShownEdge, found: Learnt) -> dict[str, object]:
    bare = unseen(shown, found)
    return {
        "parts": found.parts,
        "inspected": found.inspected,
        "setting_um": {"x_radius": _um(found.setting_mm)[0], "z": _um(found.setting_mm)[1]},
        "setting_u_um": {"x_radius": _um(found.setting_u_mm)[0], "z": _um(found.setting_u_mm)[1]},
        "contact_angle_deg": [round(float(angle), 3) for angle in angles_deg(found)],
        "seen": [not one for one in bare.tolist()],
        "form_um": _um(found.form.mean_mm),
        "form_u_um": _um(found.form.u_mm),
        "transfer_um": _um(found.transfer.mean_mm),
        "transfer_u_um": _um(found.transfer.u_mm),
        "by_type_um": {name: _um(term.mean_mm) for name, term in found.by_type.items()},
        "in_all_um": {name: _um(term.mean_mm) for name, term in found.in_all.items()},
        "in_all_u_um": {name: _um(term.u_mm) for name, term in found.in_all.items()},
        "by_type_u_um": {name: _um(term.u_mm) for name, term in found.by_type.items()},
    }


def _um(values_mm: "Sequence[float] | np.ndarray") -> list[float]:
    return [round(UM_PER_MM * float(value), 3) + 0.0 for value in values_mm]


def _edge(event: EdgeEvent) -> dict[str, object]:
    edge = event.edge
    return {"tool": edge.tool.number, "holder": edge.tool.name, "insert": edge.insert, "corner": edge.corner}
