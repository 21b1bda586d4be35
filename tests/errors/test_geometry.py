"""Every way in which a profile or its offset is refused."""

import math
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import ezdxf.filemanagement
import pytest

from tests.support.profiles import polyline
from tests.support.solids import written
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.dxf import read_dxf
from trueloop.formats.cad.step_profile import read_step_profile
from trueloop.geometry.curve_kinds import b_spline, curve_through, power_series
from trueloop.geometry.feature import Arc, Line, Point
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.geometry.validate import checked_profile
from trueloop.probing.probe_plan import Spacing, equally_spaced

A, B, C, D = (10.0, 0.0), (10.0, 5.0), (8.0, 5.0), (8.0, 9.0)


def _vee(included_deg: float, convex: bool) -> Profile:
    rise = 10 / math.tan(math.radians(included_deg) / 2) * (1 if convex else -1)
    return checked_profile(polyline([(200.0, 0.0), (200.0 + rise, 10.0), (200.0, 20.0)]))


def _read_drawing(units: int, polylines: list[list[Point]]) -> object:
    document = ezdxf.filemanagement.new(units=units)
    for points in polylines:
        document.modelspace().add_lwpolyline(points)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "part.dxf"
        document.saveas(path)
        return read_dxf(path)


def _section_of_a_box() -> object:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    with TemporaryDirectory() as folder:
        return read_step_profile(written(BRepPrimAPI_MakeBox(5.0, 6.0, 7.0).Shape(), Path(folder) / "box.step"))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.GEO_EMPTY: lambda: checked_profile([]),
    Code.GEO_VALUE: lambda: checked_profile([Line("cylinder", A, (math.nan, 5.0))]),
    Code.GEO_NAME: lambda: checked_profile([Line("cylinder", A, B), Line("cylinder", B, C)]),
    Code.GEO_LENGTH: lambda: checked_profile([Line("cylinder", A, B), Line("face", B, B), Line("face 2", B, C)]),
    Code.GEO_ARC: lambda: checked_profile([Arc("dome", A, (0.0, 10.1), (0.0, 0.0), math.pi / 2)]),
    Code.GEO_CURVE: lambda: b_spline("edge", [A, B, C], [0, 0, 1, 2, 2], 1),
    Code.GEO_CURVE_END: lambda: power_series("cone", (A, D), (10.0, -0.2)),
    Code.GEO_CURVE_FIT: lambda: curve_through("edge", [(10.0 + k % 2, float(k)) for k in range(20)], 0.01),
    Code.GEO_AXIS: lambda: checked_profile([Line("face", A, (-0.4, 0.0))]),
    Code.GEO_GAP: lambda: checked_profile([Line("cylinder", A, B), Line("face", (10.2, 5.0), C)]),
    Code.GEO_ORDER: lambda: checked_profile(polyline([D, C, B, A])),
    Code.GEO_CROSSING: lambda: checked_profile(polyline([A, B, (4.0, 5.0), (4.0, 3.0), (12.0, 3.0)])),
    Code.GEO_JUNCTION: lambda: checked_profile(polyline([A, B, C]), {("f0", "f1"): JunctionKind.TANGENT}),
    Code.GEO_NOSE: lambda: nose_centre_path(
        checked_profile([Arc("fillet", A, (10.0, 6.0), (10.0, 3.0), -math.pi)]), 3.0
    ),
    Code.GEO_NARROW: lambda: nose_centre_path(
        checked_profile(polyline([(9.0, 0.0), (5.0, 0.0), (5.0, 1.0), (9.0, 1.0)])), 0.6
    ),
    Code.GEO_SHARP: lambda: nose_centre_path(_vee(8.0, convex=True), 0.4),
    Code.GEO_DXF: lambda: _read_drawing(4, []),
    Code.GEO_DXF_UNIT: lambda: _read_drawing(0, [[(0, 10), (5, 10)]]),
    Code.GEO_STEP: _section_of_a_box,
    Code.GEO_DXF_CHOICE: lambda: _read_drawing(4, [[(0, 10), (5, 10)], [(20, 10), (25, 10)]]),
    Code.TCH_PLAN: lambda: equally_spaced(checked_profile(polyline([A, B])), {"f0": Spacing(3)}),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert any(character.isdigit() for character in refusal.value.message)
    assert refusal.value.hint
