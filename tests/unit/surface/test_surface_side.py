"""The side of a surface that a program's tool runs on: it decides what `flip` has to be."""

import numpy as np
import pytest

from tests.support.refusals import refused
from tests.support.surfaces import sphere, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.nc.program.program import Program, read_program
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.placed import require_outer_side
from trueloop.surface.compensation.shift import SurfaceJob
from trueloop.surface.on_face import FIGURES, LIMITS, MAPS, SUPPORT, WHOLE, on_face

AT = np.linspace(0.1, 0.9, 9)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))


def plane(tilt: float = 0.0) -> Surface:
    x, y = np.meshgrid(np.linspace(0, 40, 9), np.linspace(0, 40, 9), indexing="ij")
    return fit_grid(np.stack([x, y, tilt * x], axis=2)).surface


def through(tips_mm: Array) -> Program:
    text = "G21 G90 G94 F300\nG0 Z100\n" + "".join(f"G1 X{x:.5f} Y{y:.5f} Z{z:.5f}\n" for x, y, z in tips_mm)
    return read_program((text + "M2\n").encode(), "linuxcnc")


def tips(surface: Surface, cutter: Cutter, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Array:
    """The tip where the cutter touches, by hand: contact, out along n by the corner, aside by the ring, down again."""
    a, n = np.array(axis), surface.normal(U, V)
    across = n - (n @ a)[:, None] * a
    long = np.linalg.norm(across, axis=1, keepdims=True)
    aside = np.where(long > 1e-9, across / np.maximum(long, 1e-9), 0.0)
    return np.asarray(surface.point_mm(U, V) + cutter.corner_mm * (n - a) + cutter.ring_mm * aside)


@pytest.mark.parametrize("cutter", [Cutter(3.0, 3.0), Cutter(5.0, 1.0), Cutter(5.0, 0.0)], ids=["ball", "bull", "flat"])
@pytest.mark.parametrize("surface", [wavy_surface(), plane(), plane(0.3)], ids=["wavy", "level", "sloping"])
def test_a_tool_on_the_inner_side_is_refused_and_on_the_outer_one_not(cutter: Cutter, surface: Surface) -> None:
    program, job = through(tips(surface, cutter)), SurfaceJob(cutter)
    require_outer_side(program, surface, job)
    refusal = refused(require_outer_side, program, surface.turned_over(), job)
    assert refusal.code is Code.SRF_SIGN
    assert "surface.flip" in refusal.hint


def test_a_ball_that_undercuts_is_on_the_outer_side_although_its_shank_leans_inwards() -> None:
    ball, cutter, down = sphere(), Cutter(3.0, 3.0), (0.0, 0.0, -1.0)
    job = SurfaceJob(cutter, down)
    require_outer_side(through(tips(ball, cutter, down)), ball, job)
    assert refused(require_outer_side, through(tips(ball, cutter, down)), ball.turned_over(), job).code is Code.SRF_SIGN


def test_a_program_that_cuts_elsewhere_is_for_others_to_refuse() -> None:
    far = tips(plane(), Cutter(3.0, 3.0)) + np.array([0.0, 0.0, 30.0])
    for surface in (plane(), plane().turned_over()):
        require_outer_side(through(far), surface, SurfaceJob(Cutter(3.0, 3.0)))


def test_the_face_is_what_trimming_leaves_in_the_surface_s_own_parameters() -> None:
    """u from 2 to 6 and v from −1 to 1, of which what is above u = 5 and below v = 0 is cut away: 3/4 by half stay."""
    corners = np.array([[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]], [[4.0, 0.0, 0.0], [4.0, 2.0, 0.0]]])
    sheet = Surface((1, 1), np.array([2.0, 2.0, 6.0, 6.0]), np.array([-1.0, -1.0, 1.0, 1.0]), corners)
    face = on_face(sheet, lambda u, v: (u > 5.0) | (v < 0.0))
    for count in (MAPS, LIMITS, FIGURES, SUPPORT):
        along, across = np.meshgrid(np.linspace(0, 1, count), np.linspace(0, 1, count), indexing="ij")
        np.testing.assert_array_equal(face.square(count), (along <= 0.75) & (across >= 0.5))
    assert on_face(sheet, None).square(MAPS).all() and WHOLE.square(3).shape == (3, 3)
