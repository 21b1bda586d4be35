"""A record in plain words: what was corrected, from what, by which model, within which limits, and what was decided."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.part import PartType
from trueloop.domain.record import Product, Record
from trueloop.units import UM_PER_MM

CORRECTED: Final = {
    Product.TURNED: "the finish program of a turned part, by touches",
    Product.SURFACE: "a surface and its program, by the points of several parts",
    Product.MACHINE: "a program, by a machine model or a field of displacements",
    Product.POINTS: "a drilling program, by errors in the plane",
}
LIMITS: Final = {
    "correction_mm": ("correction", UM_PER_MM, "µm"),
    "limit_mm": ("correction", UM_PER_MM, "µm"),
    "slope": ("slope of the correction", UM_PER_MM, "µm/mm"),
    "scatter_mm": ("scatter", UM_PER_MM, "µm"),
    "age_hours": ("age of the measurement", 1.0, "h"),
}
"""By the key in a record's options: what is limited, and the factor to the unit it is shown in."""


@dataclass(frozen=True)
class Limit:
    """The largest `value`, in `unit`, that was accepted; None: there was no limit."""

    name: str
    value: float | None
    unit: str

    def __str__(self) -> str:
        return f"{self.name}: " + ("no limit" if self.value is None else f"at most {self.value:g} {self.unit}")


def limits_of(record: Record) -> list[Limit]:
    """Returns the limits among a record's options."""
    given = {**record.options, **_table(record.options.get("limits"))}
    return [
        Limit(name, None if value is None else value * factor, unit)
        for key, (name, factor, unit) in LIMITS.items()
        if key in given and ((value := _number(given, key)) is not None or given[key] is None)
    ]


def as_dict(record: Record) -> dict[str, object]:
    """Converts a record to a dict: changes and components counted, measured values left to the record."""
    whole = asdict(record)
    whole["edge_set_at"] = record.edge_set_at and record.edge_set_at.isoformat()
    for inspection in whole["inspections"]:
        del inspection["values"]
        inspection["measured_at"] = inspection["measured_at"] and inspection["measured_at"].isoformat()
    counted = {"options", "model", "changes", "components"}
    return {key: value for key, value in whole.items() if key not in counted} | {
        "corrected": CORRECTED[record.product],
        "model": model_words(record),
        "limits": [asdict(limit) for limit in limits_of(record)],
        "changes": len(record.changes),
        "components": len(record.components),
    }


def words(record: Record) -> list[tuple[str, list[str]]]:
    """Headings, with the lines below each; a heading with nothing to say is left out."""
    program, machine = record.program, record.machine
    stated_by = _table(record.options.get("unit")).get("stated_by")
    unit = "" if program is None or program.unit is None else f", {program.unit} as stated by {stated_by}"
    sections = [
        ("Corrected", [CORRECTED[record.product]]),
        ("Part", [] if record.part_type is None else [_part(record.part_type)]),
        ("Program", [] if program is None else [f"{program.name} ({program.dialect}{unit})"]),
        ("Tool", _tool(record)),
        ("Machine", [] if machine is None else [_named(machine.name, machine.serial)]),
        ("Measured", [_inspected(inspection) for inspection in record.inspections]),
        ("Inputs, SHA-256", [f"{digest}  {name}" for name, digest in record.inputs_sha256.items()]),
        ("Model", [*model_words(record)]),
        ("Limits", [str(limit) for limit in limits_of(record)]),
        ("Decision", record.decision),
        ("Changes", [_changes(record)]),
        ("Made", [f"{record.made_at} by {record.made_by or 'not recorded'}, trueloop {record.trueloop_version}"]),
    ]
    return [(heading, lines) for heading, lines in sections if lines]


def model_words(record: Record) -> list[str]:
    """Describes what the correction was computed with."""
    model = record.model
    if record.product is Product.TURNED:
        scatter, free = _number(model, "scatter_mm"), _number(model, "degrees_of_freedom")
        suspects = _count(model.get("suspect_touches"))
        return [
            f"error curves of {_count(model.get('curves'))} features; scatter {_um(scatter, UM_PER_MM)}, "
            f"{free or 0:g} degrees of freedom",
            *([f"{suspects} touches contradict the others"] if suspects else []),
        ]
    if record.product is Product.SURFACE:
        random, missed = (_um(_number(model, key)) for key in ("random_sigma_um", "not_followed_um"))
        return [f"pattern of {_count(model.get('parts'))} parts; random errors {random}, not followed {missed}"]
    if "terms" in model:
        machine = _named(str(model.get("machine")), str(model.get("serial") or ""))
        return [f"{model['terms']} error terms of {machine}"]
    return [f"{key}: {value}" for key, value in model.items()]


def _part(part: PartType) -> str:
    more = [("drawing", part.drawing), ("material", part.material)]
    return ", ".join([_named(part.name, part.revision), *(f"{name} {value}" for name, value in more if value)])


def _named(name: str, number: str) -> str:
    return f"{name}, {number}" if number else name


def _tool(record: Record) -> list[str]:
    tool = record.tool
    if tool is None:
        return []
    radii = [("radius", tool.radius_mm), ("nose or corner radius", tool.corner_radius_mm)]
    number = [] if tool.number is None else [f"number {tool.number}"]
    named = [tool.name] if tool.name else []
    return [
        ", ".join([*named, *number, *(f"{name} {value:g} mm" for name, value in radii if value is not None)]),
        *_edge(record),
    ]


def _edge(record: Record) -> list[str]:
    edge, set_at = record.edge, record.edge_set_at
    if edge is None:
        return []
    said = [("insert", edge.insert), ("corner", edge.corner), ("set at", set_at and set_at.isoformat("T", "minutes"))]
    words = ", ".join(f"{name} {value}" for name, value in said if value)
    return [f"edge: {words}"] if words else []


def _inspected(one: Inspection) -> str:
    when = "at a time not stated" if one.measured_at is None else one.measured_at.isoformat(timespec="minutes")
    by = "".join(f" by {name}" for name in (one.device, one.operator) if name)
    warm = "".join(f", {name} {value:g}" for name, value in one.temperatures.items())
    return f"{one.count} {one.measured} of {'/'.join(filter(None, one.part.identity))}{by}, {when}{warm}"


def _changes(record: Record) -> str:
    edits = "not counted" if record.edits is None else f"{record.edits} in the program"
    listed = "each listed in the record" if record.changes else "none listed in the record"
    components = f"; components of machine and process at {len(record.components)} touches" if record.components else ""
    return f"{edits}, {listed}{components}"


def _um(value: float | None, factor: float = 1.0) -> str:
    return "not known" if value is None else f"{value * factor:.2f} µm"


def _table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _number(values: Mapping[str, object], key: str) -> float | None:
    value = values.get(key)
    return float(value) if isinstance(value, int | float) else None


def _count(value: object) -> int:
    return len(value) if isinstance(value, list) else 0
