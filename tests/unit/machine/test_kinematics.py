"""Chains against independent algebra: sympy's product of homogeneous matrices, and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from tests.support.exact_kinematics import exact_error_mm
from tests.support.machines import first_order_error_mm
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import ZERO, Axis, AxisKind, Chain, error_name
from trueloop.machine.model.kinematics import bed_to_work, influences, tool_in_work_mm
from trueloop.machine.model.term import PRESETS, PositionBasis, chain_of, mill_terms


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
            point = tool_in_work_mm(chain, chain.positions({name: 10.0}), ZERO)
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


def test_influences_are_given_of_the_errors_asked_for_alone() -> None:
    chain = chain_of("mill-gantry")
    only = {error_name("EBX"), error_name("EC0Y")}
    assert set(influences(chain, _positions(chain, 5), ZERO, only)) == only


@pytest.mark.parametrize("turn_rad", [0.0, np.pi / 2, 0.3])
def test_the_bed_s_directions_turn_back_under_a_turned_table(turn_rad: float) -> None:
    """A table that has turned the work by C shows a tool that goes along X at −C from the work's X."""
    chain, c, s = chain_of("five-axis-table-table-ac"), np.cos(turn_rad), np.sin(turn_rad)
    point = tool_in_work_mm(chain, chain.positions({"X": 10.0, "C": turn_rad}), ZERO)[0]
    rows = bed_to_work(chain, {"C": turn_rad})
    np.testing.assert_allclose(10.0 * rows[0], point, atol=1e-11)
    np.testing.assert_allclose(np.abs(rows), [[c, s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], atol=1e-12)
    assert np.linalg.det(rows) == pytest.approx(1.0) and rows[2, 2] == pytest.approx(1.0)
    np.testing.assert_allclose(bed_to_work(chain_of("turning"), {}), np.eye(3), atol=1e-12)  # its Y from X and Z


@pytest.mark.parametrize(
    ("breaks", "degree"), [((0.0, 1.0, 1.0), 1), ((0.0, 1.0, 2.0), 0), ((1.0,), 1), ((0.0, 1.0), 6)]
)
def test_segments_that_make_no_function_of_position_are_refused(breaks: tuple[float, ...], degree: int) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PositionBasis(breaks, degree)
    assert refusal.value.code is Code.MCH_BASIS


@pytest.mark.parametrize("structure", ["w X t", "b X Y Z t w", "w X b Y Z", "w X b b Y t", "w Q b X t", "w b X (X) t"])
def test_letters_that_are_no_structure_are_refused(structure: str) -> None:
    with pytest.raises(TrueloopError) as refusal:
        chain_of(structure)
    assert refusal.value.code is Code.MCH_STRUCTURE


@pytest.mark.parametrize(("datum", "zero"), [(None, 0.0), (120.0, 120.0), (900.0, 500.0), (-5.0, 0.0)])
def test_motions_are_zero_at_the_datum_and_straightness_at_both_ends(datum: float | None, zero: float) -> None:
    chain = chain_of("mill-gantry")
    chain = chain.with_axes({name: replace(chain.axis(name), travel=(0.0, 500.0)) for name in "XYZ"})
    terms = {str(term.name): term for term in mill_terms(chain, datum=datum)}
    assert len(terms) == 21
    for name, places in (("EXX", (zero,)), ("EBX", (zero,)), ("EYX", (0.0, 500.0)), ("EXZ", (0.0, 500.0))):
        assert terms[name].parts[0].basis.zero_at == places


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
