"""A machine and the form of its model as TOML: structure, travels, offsets, error terms.

[machine]
name = "VMC 3"
structure = "mill-table-x"        # a preset, or letters: "w X b Y Z (S) t"

[axes.X]
travel_mm = [0, 500]              # travel_deg for rotary axes
offset_mm = [0, 0, 0]             # from the frame that carries the axis to its own
sense = "iso-841"                 # of a rotary axis; "opposite": it turns against it

[terms]
standard = "mill"                 # or "turning", "five-axis"; leave out for none
degree = 3
segments = 2
both_ways = true
datum = 0

[[term]]                          # further terms, or others in the place of standard ones
error = "EZZ"
degree = 2
segments = 3
signals = { T12 = 20.0 }          # linear in T12 − 20
expansion = { T7 = 20.0 }         # linear in T7 − 20 and in the position: a screw or a scale that grows
choose = { T1 = 20, column = 20 } # and in those of these that matter
most = 3                          # but in so many at the most

[lags.column]                     # a signal: T3 after a first-order lag
of = "T3"
constant_s = [300, 14400]         # sought between these; a single number is taken as it is
power = 1                         # 2: the square of a speed heats
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from trueloop.errors import Code
from trueloop.formats.input_file import FilePath
from trueloop.formats.toml_tables import Count, Finite, Located, Positive, Table, read_located
from trueloop.machine.identify.form import Choice, Form
from trueloop.machine.model.chain import ZERO, Axis, AxisKind, Chain, ErrorName, error_name
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import Machine
from trueloop.machine.model.term import (
    CONSTANT,
    Part,
    Term,
    chain_of,
    five_axis_terms,
    frame_terms,
    mill_terms,
    segments,
    turning_terms,
)

STANDARDS: Final = {"mill": mill_terms, "turning": turning_terms, "five-axis": five_axis_terms}

Vector = tuple[Finite, Finite, Finite]
Degree = Annotated[int, Field(ge=0, le=5, strict=True)]
Signals = dict[str, Finite]
"""Reference value by signal."""


def _ascending(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] <= ends[1]:
        raise ValueError("the first is to be the smaller one")
    return ends


Range = Annotated[tuple[Finite, Finite], AfterValidator(_ascending)]
Constant = Annotated[
    tuple[Positive, Positive],
    BeforeValidator(lambda given: given if isinstance(given, list) else [given, given]),
    AfterValidator(_ascending),
]
"""Bounds; a single number is both."""


class MachineTable(Table):
    """Which machine, and which axis carries which."""

    name: str
    """The machine's name."""
    serial: str = ""
    """Its serial number: a model of another one is refused where it is asked for."""
    structure: str
    """The chain from work to tool: `"mill-table-x"`, `"turning"` … or letters, `"w X b Y Z (S) t"`."""


class AxisTable(Table):
    """An axis of the machine."""

    travel_mm: Range | None = None
    """Lowest and highest position."""
    travel_deg: Range | None = None
    """Lowest and highest position of a rotary axis."""
    offset_mm: Vector = ZERO
    """From the frame that carries the axis to its own, at position 0."""
    sense: Literal["iso-841", "opposite"] = "iso-841"
    """Sense of a rotary axis: by ISO 841 a larger angle turns the tool right-handed *as seen from the work*, so a table
    the other way; opposite, as LinuxCNC's kinematics of trunnion tables do."""


class TermsTable(Table):
    """The usual terms of a kind of machine, all of one form."""

    standard: Literal["mill", "turning", "five-axis"] | None = None
    """The usual terms of a mill (21), of a lathe or of a machine with five axes; left out, only those of `[[term]]`."""
    degree: Degree = 3
    """Degree of their polynomials in the axis' position."""
    segments: Count | None = None
    """In how many pieces of equal length, joined smoothly; left out, as many by axis as predict left-out runs best."""
    both_ways: bool = False
    """Forward and return travel each have parameters of their own."""
    datum: Finite | None = None
    """The position at which they are zero (straightness: both ends of travel)."""


class TermTable(Table):
    """The term of one error."""

    error: str
    """The error as ISO 230-1 names it: E, direction, axis; `EXX`, `EZ0S`. It takes the place of a standard one."""
    degree: Degree = 3
    """Degree of its polynomial in the axis' position."""
    segments: Count = 1
    """In how many pieces of equal length, joined smoothly."""
    both_ways: bool = False
    """Forward and return travel each have parameters of their own."""
    zero_at: tuple[Finite, ...] = ()
    """Positions at which it is zero."""
    signals: Signals = Field(default_factory=dict)
    """Linear in each of these signals less its reference: `{ T12 = 20.0 }`."""
    expansion: Signals = Field(default_factory=dict)
    """Linear in the signal less its reference, and in the position: a screw or scale that grows."""
    choose: Signals = Field(default_factory=dict)
    """As `signals`, but only those stay whose absence is missed in data that were left out."""
    most: Count = 4
    """How many of them stay at the most."""


class LagTable(Table):
    """A signal made of another's past."""

    of: str
    """The signal whose past it follows."""
    constant_s: Constant
    """Time constant of a first order; two bounds between which it is sought, or one number."""
    power: Literal[1, 2] = 1
    """Of the signal: 2 where the square of a speed heats."""


class MachineFile(Table):
    """A whole machine file."""

    machine: MachineTable
    axes: dict[str, AxisTable] = Field(default_factory=dict)
    terms: TermsTable = TermsTable()
    term: tuple[TermTable, ...] = ()
    lags: dict[str, LagTable] = Field(default_factory=dict)


def read_machine(path: FilePath) -> tuple[Machine, Form]:
    """The machine and the form of its model.

    Raises MCH-FILE (unreadable, a key unknown or missing), MCH-STRUCTURE, MCH-AXIS, MCH-UNIT, MCH-NAME and MCH-BASIS.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> machine.chain.order, [str(term.name) for term in form.terms]
    (('X', 'Y', 'Z'), ['EXX', 'EYY', 'EZZ', 'EZ0S'])
    """
    path = Path(path)
    hint = "docs/machine.md shows every table and key of a machine file"
    file = read_located(path, MachineFile, Code.MCH_FILE, hint=hint)
    with file.at("machine", "structure"):
        chain = chain_of(file.model.machine.structure)
    changed = {}
    for name, axis in file.model.axes.items():
        with file.at("axes", name):
            changed[name] = _axis(chain.axis(name), axis)
    chain = chain.with_axes(changed)
    machine = Machine(file.model.machine.name, chain, file.model.machine.serial)
    terms = _terms(file, chain)
    frame = frame_terms(chain, terms) if file.model.terms.standard else ()
    choices = tuple(
        Choice(error_name(own.error), _signal_parts(own.choose), own.most) for own in file.model.term if own.choose
    )
    own = {term.error for term in file.model.term}
    stated = file.model.terms.standard is None or file.model.terms.segments is not None
    free = frozenset[ErrorName]() if stated else frozenset(term.name for term in terms if str(term.name) not in own)
    return machine, Form(terms, _lags(file), choices, frame, free)


def _axis(axis: Axis, table: AxisTable) -> Axis:
    rotary = axis.kind is AxisKind.ROTARY
    travel, other = (table.travel_deg, table.travel_mm) if rotary else (table.travel_mm, table.travel_deg)
    if other is not None:
        right, wrong = ("travel_deg", "travel_mm") if rotary else ("travel_mm", "travel_deg")
        raise Code.MCH_UNIT.refusal(
            f"axis {axis.name} is {axis.kind.value}: its travel cannot be {wrong} = {list(other)}", hint=f"give {right}"
        )
    low, high = travel or (-math.inf, math.inf)
    scale = math.pi / 180 if rotary else 1.0
    if table.sense == "opposite" and not rotary:
        why = f"axis {axis.name} is {axis.kind.value}: sense = {table.sense!r} is for rotary axes"
        raise Code.MCH_UNIT.refusal(why, hint="take it out: X, Y and Z are right-handed as seen from the work")
    sense = -1.0 if table.sense == "opposite" else 1.0
    return replace(axis, travel=(scale * low, scale * high), offset_mm=table.offset_mm, sense=sense)


def _terms(file: Located[MachineFile], chain: Chain) -> tuple[Term, ...]:
    table = file.model.terms
    found: dict[str, Term] = {}
    if table.standard is not None:
        with file.at("terms", "standard"):
            standard = STANDARDS[table.standard](
                chain, degree=table.degree, count=table.segments or 1, datum=table.datum, both_ways=table.both_ways
            )
        found = {str(term.name): term for term in standard}
    for k, own in enumerate(file.model.term):
        with file.at("term", k, "error"):
            error = own.error
            before = [term.error for term in file.model.term[:k]]
            if error in before:
                raise Code.MCH_FILE.refusal(
                    f"{error} has {before.count(error) + 1} tables [[term]]: the last would stand for all",
                    hint="one table an error: its signals, degree and travel belong into it together",
                )
            found[own.error] = _own_term(own, chain)
    return tuple(found.values())


def _own_term(table: TermTable, chain: Chain) -> Term:
    name = error_name(table.error)
    axis = chain.axis(name.axis)
    parts = [Part(CONSTANT)]
    if not name.place and table.degree > 0:
        parts = [Part(segments(*axis.travel, table.segments, table.degree, table.zero_at))]
    return Term(name, (*parts, *_signal_parts(table.signals), *_expansions(table, name, axis)), table.both_ways)


def _expansions(table: TermTable, name: ErrorName, axis: Axis) -> list[Part]:
    """Returns the terms that grow with the distance from the first zero of the error, or from anywhere without one."""
    if table.expansion and name.place:
        raise Code.MCH_FILE.refusal(
            f"{name} has no position that an expansion by {len(table.expansion)} signals could grow along",
            hint="signals = { … } is for what depends on a signal alone",
        )
    basis = segments(*axis.travel, 1, 1, table.zero_at[:1]) if table.expansion else CONSTANT
    return [Part(basis, signal, reference) for signal, reference in table.expansion.items()]


def _lags(file: Located[MachineFile]) -> tuple[Lag, ...]:
    found = []
    for name, table in file.model.lags.items():
        low, high = table.constant_s
        with file.at("lags", name):
            found.append(Lag(name, table.of, math.sqrt(low * high), table.power, (low, high) if low < high else None))
    return tuple(found)


def _signal_parts(table: Mapping[str, float]) -> tuple[Part, ...]:
    return tuple(Part(CONSTANT, signal, reference) for signal, reference in table.items())
