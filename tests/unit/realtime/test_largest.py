"""The largest correction is what the model says there, and no place asks for more."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings

from tests.support.banks import RANGES, Asked, any_asked, bank_for, by_the_model
from tests.support.machines import chain_with_travel
from trueloop.arrays import Array
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, segments
from trueloop.realtime.image import Block, Identity, Image, RealTimeLimits, bank_of, signals_of
from trueloop.realtime.largest import extent_of

LIMITS = RealTimeLimits(((-300.0, 400.0),) * 3)
WAYS = np.array(list(product([1.0, -1.0], repeat=3)))
IDENTITY = Identity("any", "")


def corrections(at: Asked, position: Array, signals: Array) -> Array:
    """−E at one place by the model, for all ways of coming there, (8, 3)."""
    here = [axis in at.model.machine.chain.order for axis in "XYZ"]
    rows = [np.tile(part, (8, 1)) for part in (position * here, signals, np.zeros(3))]
    return -by_the_model(Asked(at.model, rows[0], WAYS * here, rows[1], at.tool, rows[2]))


@settings(max_examples=8)
@given(any_asked())
def test_the_largest_is_what_the_model_says_there(at: Asked) -> None:
    bank = bank_for(at.model, at.tool)
    there = [
        LIMITS.travel_mm[k] if axis in at.model.machine.chain.order else (0.0, 0.0) for k, axis in enumerate("XYZ")
    ]
    x, y, z = there
    extent = extent_of(Image(IDENTITY, RealTimeLimits((x, y, z)), bank))
    found = extent.model
    assert found is not None and found == extent.whole
    own = dict(zip((s.name for s in bank.signals), found.signals, strict=True))
    signals = np.array([own.get(name, low) for name, (low, _) in RANGES.items()])
    said = corrections(at, np.array(found.position_mm), signals)[:, "XYZ".index(found.axis)]
    assert np.abs(said - found.correction_mm).min() < 1e-12
    inside = np.clip(at.positions, *np.array(there).T)
    for position, values in zip(inside, at.signals, strict=True):
        assert np.abs(corrections(at, position, values)).max() <= 1.03 * abs(found.correction_mm)


def lathe(*terms: Term, coefficients: list[float]) -> MachineModel:
    machine = Machine("lathe", chain_with_travel("turning"))
    size = len(coefficients)
    return MachineModel(machine, terms, np.array(coefficients), np.eye(size), {"T1": (15.0, 30.0)})


LIMITS_OF_LATHE = RealTimeLimits(((0.0, 500.0), (-0.1, 0.1), (-300.0, 0.0)))


def test_a_jump_is_what_turning_round_changes() -> None:
    """X forward 0 to 10 µm, back 5 to 2 µm over its travel: 8 µm apart at the end."""
    term = Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 1)),), both_ways=True)
    bank = bank_of(lathe(term, coefficients=[0.0, 0.010, 0.005, 0.002]), (0.0, 0.0, 0.0), ())
    extent = extent_of(Image(IDENTITY, LIMITS_OF_LATHE, bank))
    assert extent.jump_mm == pytest.approx(0.008)
    assert extent.whole.axis == "X" and extent.whole.correction_mm == pytest.approx(-0.010)


def test_model_and_table_add_up_where_the_table_is() -> None:
    """The tool stands 3 µm and 1 µm a degree too far in Z: the table's 20 µm become 17 µm, at 15 °C 22 µm."""
    term = Term(error_name("EZZ"), (Part(CONSTANT), Part(CONSTANT, "T1", 20.0)))
    model = lathe(term, coefficients=[0.003, 0.001])
    blocks = (Block(4, np.array([[20.0, -5.0, -0.015, 0.020], [20.0, -9.0, 0.0, 0.0]])),)
    extent = extent_of(Image(IDENTITY, LIMITS_OF_LATHE, bank_of(model, (0.0, 0.0, 0.0), signals_of(model)), blocks))
    whole, alone, table = extent.whole, extent.model, extent.table
    assert alone is not None and table is not None
    assert whole.correction_mm == pytest.approx(0.022)
    assert (whole.axis, whole.position_mm, whole.signals) == ("Z", (20.0, 0.0, -5.0), (15.0,))
    assert alone.correction_mm == pytest.approx(-0.013)
    assert (alone.axis, alone.signals) == ("Z", (30.0,))
    assert (table.axis, table.correction_mm) == ("Z", 0.020)


def test_a_table_alone() -> None:
    blocks = (Block(4, np.array([[20.0, -5.0, 0.001, -0.002], [20.0, -9.0, -0.030, 0.004]])),)
    extent = extent_of(Image(IDENTITY, LIMITS_OF_LATHE, None, blocks))
    assert extent.model is None and extent.whole == extent.table
    assert (extent.whole.axis, extent.whole.correction_mm, extent.whole.position_mm) == ("X", -0.030, (20.0, 0.0, -9.0))
