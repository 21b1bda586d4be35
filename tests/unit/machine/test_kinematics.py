"""Chains against independent algebra: sympy's product of homogeneous matrices, and finite differences."""

import numpy as np
import pytest
import sympy as sp

from tests.support.machines import first_order_error_mm
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import ZERO, Axis, AxisKind, Chain
from trueloop.machine.model.kinematics import exact_error_mm, influences, tool_in_work_mm
from trueloop.machine.model.names import error_name
from trueloop.machine.model.structure import PRESETS, chain_of


def _positions(chain: Chain, seed: int, count: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.stack(
        [rng.uniform(-1, 1, count) if n in "ABC" else rng.uniform(-300, 300, count) for n in chain.order], -1
    )


@pytest.mark.parametrize("structure", PRESETS)
def test_a_larger_coordinate_moves_the_tool_that_way_as_seen_from_the_work(structure: str) -> None:
    chain = chain_of(structure)
    for number, name in enumerate("XYZ"):
        if name in chain.order:
            point = tool_in_work_mm(chain, chain.positions({name: 10.0}), ZERO, {})
            np.testing.assert_allclose(point, [10.0 * np.eye(3)[number]], atol=1e-14)


def test_errors_of_place_are_those_that_a_direction_a_line_and_a_spindle_have() -> None:
    """Two angles of a linear axis; of a rotary one all but the way along itself; of a spindle all six."""
    chain = chain_of("w C b X Z (S) t")
    places = {axis.name: {str(name) for name in axis.errors() if name.place} for axis in chain.axes}
    assert places["X"] == {"EB0X", "EC0X"} and places["Z"] == {"EA0Z", "EB0Z"}
    assert places["C"] == {"EX0C", "EY0C", "EA0C", "EB0C", "EC0C"}
    assert places["S"] == {f"E{c}0S" for c in "XYZABC"}
    moving = {axis.name: {str(name) for name in axis.errors() if not name.place} for axis in chain.axes}
    assert moving["C"] == {f"E{c}C" for c in "XYZABC"} and moving["S"] == set()


def test_positions_are_shown_in_millimetres_and_degrees() -> None:
    assert Axis("X", AxisKind.LINEAR, 0).shown(12.5) == "12.5 mm"
    assert Axis("C", AxisKind.ROTARY, 2).shown(np.pi / 6) == "30°"


def test_a_chain_names_each_of_its_axes_once_and_knows_no_other() -> None:
    axis = Axis("X", AxisKind.LINEAR, 0)
    for work, tool in (((), ()), ((axis,), (axis,))):
        with pytest.raises(TrueloopError) as refusal:
            Chain(work, tool)
        assert refusal.value.code is Code.MCH_STRUCTURE
    with pytest.raises(TrueloopError) as refusal:
        Chain((), (axis,)).positions({"Y": 1.0})
    assert refusal.value.code is Code.MCH_AXIS


@pytest.mark.parametrize("structure", PRESETS)
def test_influences_are_the_derivatives_of_the_exact_transforms(structure: str) -> None:
    chain = chain_of(structure)
    chain = chain.with_axes(
        {a.name: type(a)(a.name, a.kind, a.number, (30.0 + k, -20.0 * k, 70.0)) for k, a in enumerate(chain.axes)}
    )
    positions, tool = _positions(chain, 1), (11.0, -7.0, -150.0)
    columns = influences(chain, positions, tool)
    assert set(columns) == set(chain.errors())
    for name, column in columns.items():
        step = 1e-6
        plus = exact_error_mm(chain, positions, tool, {name: step})
        minus = exact_error_mm(chain, positions, tool, {name: -step})
        np.testing.assert_allclose(column.displacement, (plus - minus) / (2 * step), atol=2e-6, err_msg=str(name))


def test_first_order_leaves_second_order_only() -> None:
    chain = chain_of("five-axis-table-table-ac")
    rng = np.random.default_rng(2)
    values = {n: rng.uniform(-1, 1) * (5e-5 if n.is_rotation else 0.02) for n in chain.errors()}
    positions, tool = _positions(chain, 3), (0.0, 0.0, -200.0)
    for scale in (1.0, 0.1):
        scaled = {name: scale * value for name, value in values.items()}
        exact = exact_error_mm(chain, positions, tool, scaled)
        rest = np.abs(exact - first_order_error_mm(chain, positions, tool, scaled)).max()
        assert 0 < rest < 3e-5 * scale**2 * 5


def test_exact_error_of_a_three_axis_mill_is_the_product_of_homogeneous_matrices() -> None:
    """`w X b Y Z t` multiplied out with sympy at 50 digits: every rotation about the origin on the tool's side."""
    chain = chain_of("w X b Y Z t")
    rng = np.random.default_rng(4)
    values = {n: float(rng.uniform(-1, 1) * (1e-3 if n.is_rotation else 0.5)) for n in chain.errors()}
    q = {"X": 210.0, "Y": -140.0, "Z": 90.0}
    tool = (3.0, 5.0, -120.0)

    def number(name: str) -> sp.Float:
        return sp.Float(values.get(error_name(name), 0.0), 50)

    def rotation(vector: list[sp.Float]) -> sp.Matrix:
        cross = sp.Matrix([[0, -vector[2], vector[1]], [vector[2], 0, -vector[0]], [-vector[1], vector[0], 0]])
        return sum((cross**k / sp.factorial(k) for k in range(1, 9)), sp.eye(3))

    def homogeneous(turn: sp.Matrix, shift: sp.Matrix) -> sp.Matrix:
        return sp.Matrix(sp.BlockMatrix([[turn, shift], [sp.zeros(1, 3), sp.eye(1)]]))

    def joint(axis: str, k: int) -> sp.Matrix:
        place = rotation([number(f"E{c}0{axis}") for c in "ABC"])
        move = homogeneous(sp.eye(3), place[:, k] * q[axis])
        motion = [number(f"E{c}{axis}") for c in "XYZABC"]
        return move * homogeneous(rotation(motion[3:]), sp.Matrix(motion[:3]))

    actual = joint("X", 0) * joint("Y", 1) * joint("Z", 2) * sp.Matrix([*tool, 1])
    nominal = sp.Matrix([q["X"] + tool[0], q["Y"] + tool[1], q["Z"] + tool[2]])
    expected = np.array((actual[:3, :] - nominal).evalf(30), dtype=float).ravel()
    error = exact_error_mm(chain, chain.positions(q), tool, values)[0]
    np.testing.assert_allclose(error, expected, atol=1e-12)
