"""[NISTIR 4773] Eqs 1–2 (p. 9) derived from the homogeneous transforms, and the preset checked against them.

P is work point − tool point, so it is COMP_MTG = −E: what is added to the command.
"""

import numpy as np
import sympy as sp

from tests.support.exact_kinematics import exact_error_mm
from tests.support.machines import first_order_error_mm
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.term import chain_of

ISO = {
    "dx_x": "EXX", "dz_x": "EZX", "ey_x": "EBX",
    "dx_z": "EXZ", "dz_z": "EZZ", "ey_z": "EBZ",
    "dx_s": "EX0C", "dz_s": "EZ0C", "ey_s": "EB0C",
}  # fmt: skip
x, z, XT, ZT, xw, zw, small = sp.symbols("x z X_T Z_T x_w z_w small")
E = {name: sp.Symbol(name) for name in ISO}


def _published() -> tuple[sp.Expr, sp.Expr]:
    yaw = E["ey_z"] + E["ey_x"]
    p_x = E["ey_s"] * zw + E["dx_s"] - yaw * ZT - E["dx_x"] - E["dx_z"]
    p_z = -E["ey_s"] * xw + E["dz_s"] + yaw * XT + E["ey_z"] * x - E["dz_x"] - E["dz_z"]
    return p_x, p_z


def _transform(turn: sp.Expr, shift_x: sp.Expr, shift_z: sp.Expr) -> sp.Matrix:
    """Homogeneous transform in (x, z), rotation about y."""
    return sp.Matrix([[sp.cos(turn), sp.sin(turn), shift_x], [-sp.sin(turn), sp.cos(turn), shift_z], [0, 0, 1]])


def test_equations_1_and_2_follow_from_the_transforms() -> None:
    scaled = {name: small * symbol for name, symbol in E.items()}
    spindle = _transform(scaled["ey_s"], scaled["dx_s"], scaled["dz_s"])
    carriage = _transform(0, 0, z) * _transform(scaled["ey_z"], scaled["dx_z"], scaled["dz_z"])
    cross_slide = _transform(0, x, 0) * _transform(scaled["ey_x"], scaled["dx_x"], scaled["dz_x"])
    work = spindle * sp.Matrix([xw, zw, 1])
    tool = carriage * cross_slide * sp.Matrix([XT, ZT, 1])
    first_order = (work - tool).diff(small).subs(small, 0)
    for derived, published in zip(first_order[:2, 0], _published(), strict=True):
        assert sp.expand(derived - published) == 0


def test_the_preset_is_those_equations_term_by_term() -> None:
    """Each of the nine errors alone, at a random position and tool: −E equals Eqs 1–2, exact and to first order."""
    chain, rng = chain_of("turning"), np.random.default_rng(5)
    at = {x: 83.0, z: -212.0, XT: 60.0, ZT: 35.0}
    at |= {xw: at[x] + at[XT], zw: at[z] + at[ZT]}
    positions, tool = chain.positions({"X": at[x], "Z": at[z]}), (at[XT], 0.0, at[ZT])
    for name, iso in ISO.items():
        value = float(rng.uniform(1e-6, 3e-6))
        numbers = at | {symbol: value if other == name else 0.0 for other, symbol in E.items()}
        p_x, p_z = (float(p.subs(numbers)) for p in _published())
        for evaluate in (first_order_error_mm, exact_error_mm):
            error = evaluate(chain, positions, tool, {error_name(iso): value})[0]
            np.testing.assert_allclose(-error[[0, 2]], [p_x, p_z], rtol=1e-5, atol=1e-12, err_msg=iso)
