"""What a control's table of one axis holds, and what it says of itself."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.machines import chain_with_travel
from trueloop.errors import Code, TrueloopError
from trueloop.machine.correct import axis_table
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, curves
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of
from trueloop.machine.model.validity import check_travel

CHAIN = chain_with_travel("mill-gantry")
PUSHED_BY_Z = MachineModel(
    Machine("mill", CHAIN),
    (Term(error_name("EXZ"), (Part(CONSTANT),), both_ways=True),),
    np.array([0.005, -0.005]),
    np.zeros((2, 2)),
)
"""X stands 5 µm off to the side that Z came from."""


def test_backlash_of_another_axis_is_no_part_of_the_table_but_told() -> None:
    """The table does not know how Z came: it holds the mean, which is nothing, and says that 5 µm are left."""
    table = axis_table(PUSHED_BY_Z, "X", "X", 5, {})
    np.testing.assert_array_equal([table.forward_mm, table.reverse_mm], np.zeros((2, 5)))
    assert table.deviation_mm == table.elsewhere_mm == 0.005


def test_a_term_with_backlash_has_one_value_each_way_in_micrometres_and_a_rotation_in_microradians() -> None:
    """5 µm and −5 µm over all of Z, known to 1 µm; 2 µrad of rotation, known to 0.5 µrad, either way."""
    terms = (*PUSHED_BY_Z.terms, Term(error_name("EBZ"), (Part(CONSTANT),)))
    covariance = np.diag([1e-6, 1e-6, 0.25e-12])
    pushed, turned = curves(MachineModel(PUSHED_BY_Z.machine, terms, np.array([0.005, -0.005, 2e-6]), covariance), {})
    assert (pushed.error, pushed.unit, turned.error, turned.unit) == ("EXZ", "µm", "EBZ", "µrad")
    for curve, forward, reverse, u in ((pushed, 5.0, -5.0, 1.0), (turned, 2.0, 2.0, 0.5)):
        for found, wanted in ((curve.forward, forward), (curve.reverse, reverse), (curve.u, u)):
            np.testing.assert_allclose(found, wanted, rtol=1e-12)
    assert (pushed.position[0], pushed.position[-1]) == CHAIN.axis("Z").travel


def test_backlash_of_the_axis_itself_is() -> None:
    table = axis_table(PUSHED_BY_Z, "Z", "X", 5, {})
    np.testing.assert_array_equal([table.forward_mm, table.reverse_mm], [[0.005] * 5, [-0.005] * 5])
    assert table.deviation_mm == table.elsewhere_mm == 0.0


@pytest.mark.parametrize(
    ("structure", "axis", "output", "code"),
    [
        ("mill-gantry", "X", "X", Code.MCH_TRAVEL),
        ("five-axis-table-table-ac", "X", "A", Code.MCH_AXIS),
        ("five-axis-table-table-ac", "C", "X", Code.MCH_AXIS),
        ("mill-gantry", "U", "X", Code.MCH_AXIS),
    ],
)
def test_tables_that_cannot_be(structure: str, axis: str, output: str, code: Code) -> None:
    model = replace(PUSHED_BY_Z, machine=Machine("any", chain_of(structure)))
    with pytest.raises(TrueloopError) as refusal:
        axis_table(model, axis, output, 5, {})
    assert refusal.value.code is code


def test_an_end_of_travel_in_inches_is_reached() -> None:
    """200 mm are 7.8740157 inch: 7.874016 and 7.8740 are the end as a file or a control shows it."""
    axis = replace(CHAIN.axis("Y"), travel=(-200.0, 200.0))
    for inches in (7.874016, 7.8740, 7.8740157):
        check_travel(axis, 25.4 * np.array([-inches, inches]))
    with pytest.raises(TrueloopError, match="200 mm"):
        check_travel(axis, np.array([200.01]))
