"""A machine and the form of its model as TOML: structure, travels, offsets, error terms.

[machine]
name = "VMC 3"
structure = "mill-table-x"        # a preset, or letters: "w X b Y Z (S) t"

[axes.X]
travel_mm = [0, 500]              # travel_deg for rotary axes
offset_mm = [0, 0, 0]             # from the frame that carries the axis to its own

[terms]
standard = "mill"                 # or "turning"; leave out for none
degree = 3
segments = 2
both_ways = true
datum = 0

[[term]]                          # further terms, or others in the place of standard ones
error = "EZZ"
degree = 2
segments = 3
signals = { T12 = 20.0 }          # linear in T12 − 20
choose = { T1 = 20, column = 20 } # and in those of these that matter
most = 3                          # but in so many at the most

[lags.column]                     # a signal: T3 after a first-order lag
of = "T3"
constant_s = [300, 14400]         # sought between these; a single number is taken as it is
power = 1                         # 2: the square of a speed heats
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from trueloop.errors import Code, Place, TrueloopError
from trueloop.machine.chain import Axis, AxisKind, Chain
from trueloop.machine.choice import Choice
from trueloop.machine.form import Form
from trueloop.machine.history import Lag
from trueloop.machine.model import Machine
from trueloop.machine.names import error_name
from trueloop.machine.position_basis import CONSTANT, segments
from trueloop.machine.standard import mill_terms, turning_terms
from trueloop.machine.structure import chain_of
from trueloop.machine.term import Part, Term

STANDARDS = {"mill": mill_terms, "turning": turning_terms}
KEYS = {
    "": {"machine", "axes", "terms", "term", "lags"},
    "machine": {"name", "serial", "structure"},
    "axes": {"travel_mm", "travel_deg", "offset_mm"},
    "terms": {"standard", "degree", "segments", "both_ways", "datum"},
    "term": {"error", "degree", "segments", "both_ways", "zero_at", "signals", "choose", "most"},
    "lags": {"of", "constant_s", "power"},
}


def read_machine(path: Path) -> tuple[Machine, Form]:
    """The machine and the form of its model. Raises MCH-FILE (unreadable, a key unknown or missing) and MCH-NAME."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise _wrong(path, f"it cannot be read: {error}") from error
    try:
        _check_keys(content, path)
        chain = _chain(content)
        machine = Machine(content["machine"]["name"], chain, str(content["machine"].get("serial", "")))
        lags = tuple(_lag(name, table) for name, table in content.get("lags", {}).items())
        return machine, Form(_terms(content, chain), lags, _choices(content))
    except TrueloopError as error:
        raise error.in_file(str(path)) from error
    except (KeyError, TypeError, ValueError, AssertionError, AttributeError) as error:
        raise _wrong(path, f"{type(error).__name__} at {error}") from error


def _chain(content: Mapping[str, Any]) -> Chain:
    chain = chain_of(content["machine"]["structure"])
    changed = {name: _axis(chain.axis(name), table) for name, table in content.get("axes", {}).items()}
    return chain.with_axes(changed)


def _axis(axis: Axis, table: Mapping[str, Any]) -> Axis:
    scale = math.pi / 180 if axis.kind is AxisKind.ROTARY else 1.0
    low, high = table.get("travel_deg" if axis.kind is AxisKind.ROTARY else "travel_mm", (-math.inf, math.inf))
    x, y, z = table.get("offset_mm", (0.0, 0.0, 0.0))
    return replace(axis, travel=(scale * low, scale * high), offset_mm=(float(x), float(y), float(z)))


def _terms(content: Mapping[str, Any], chain: Chain) -> tuple[Term, ...]:
    table = content.get("terms", {})
    found: dict[str, Term] = {}
    if "standard" in table:
        make = STANDARDS[table["standard"]]
        standard = make(
            chain,
            degree=table.get("degree", 3),
            count=table.get("segments", 1),
            datum=table.get("datum"),
            both_ways=table.get("both_ways", False),
        )
        found = {str(term.name): term for term in standard}
    for own in content.get("term", []):
        term = _own_term(own, chain)
        found[str(term.name)] = term
    return tuple(found.values())


def _own_term(table: Mapping[str, Any], chain: Chain) -> Term:
    name = error_name(table["error"])
    axis = chain.axis(name.axis)
    parts = [Part(CONSTANT)]
    if not name.place and table.get("degree", 3) > 0:
        zeros = tuple(float(z) for z in table.get("zero_at", ()))
        parts = [Part(segments(*axis.travel, table.get("segments", 1), table.get("degree", 3), zeros))]
    parts += _signal_parts(table.get("signals", {}))
    return Term(name, tuple(parts), bool(table.get("both_ways", False)))


def _lag(name: str, table: Mapping[str, Any]) -> Lag:
    constant = table["constant_s"]
    low, high = constant if isinstance(constant, list) else (constant, constant)
    if not 0 < low <= high:
        raise ValueError(f"constant_s = {constant} of [lags.{name}]: two ascending numbers of seconds, or one")
    power = table.get("power", 1)
    if power not in (1, 2):
        raise ValueError(f"power = {power} of [lags.{name}] is neither 1 nor 2")
    between = (float(low), float(high)) if low < high else None
    return Lag(name, str(table["of"]), math.sqrt(low * high), power, between)


def _choices(content: Mapping[str, Any]) -> tuple[Choice, ...]:
    return tuple(
        Choice(error_name(own["error"]), _signal_parts(own["choose"]), int(own.get("most", 4)))
        for own in content.get("term", [])
        if "choose" in own
    )


def _signal_parts(table: Mapping[str, Any]) -> tuple[Part, ...]:
    return tuple(Part(CONSTANT, signal, float(reference)) for signal, reference in table.items())


def _check_keys(content: Mapping[str, Any], path: Path) -> None:
    tables = [("", content), ("machine", content.get("machine", {})), ("terms", content.get("terms", {}))]
    tables += [("axes", table) for table in content.get("axes", {}).values()]
    tables += [("term", table) for table in content.get("term", [])]
    tables += [("lags", table) for table in content.get("lags", {}).values()]
    for name, table in tables:
        for key in table:
            if key not in KEYS[name]:
                known = ", ".join(sorted(KEYS[name]))
                raise _wrong(path, f"[{name}] has no key {key!r}; it has {len(KEYS[name])}: {known}")


def _wrong(path: Path, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_FILE,
        f"{path.name!r} does not describe a machine: {why}",
        hint="[machine] with name and structure, [axes.X] with travel_mm, [terms] with standard or [[term]]",
        place=Place(str(path)),
    )
