"""`trueloop mill probe`: the program run by a machine apart that knows the macros, and its print-out read back."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.mill_programs import plate
from tests.support.mill_shop import BORES, BOSSES, PLANES, Mill
from trueloop.controllers.probing.inspection_plus import MacroProbe, inspection_plus_program
from trueloop.milled.feature import MilledFeature

BALL_MM, CLEARANCE_MM = 6.0, 20.0
FACED = {"top": (60.0, 0.0), "step": (75.0, -8.0), "floor": (90.0, -15.0)}
"""Where the example's planes lie, y and z, all across the plate and 12 mm wide."""


def ground(x: float, y: float) -> float:
    """Returns how high the plate stands: 0 at y up to 66, steps beyond, −20 in bores and −10 around the bosses."""
    for bx, by, d, depth in BORES.values():
        if np.hypot(x - bx, y - by) < d / 2:
            return -depth
    for ux, uy, d, depth in BOSSES.values():
        distance = np.hypot(x - ux, y - uy)
        if d / 2 <= distance < d / 2 + 25.0 and abs(y) < 15.0:
            return -depth
    return max((z for y0, z in FACED.values() if y <= y0 + 6.0), default=-30.0)


def printed(program: str, cut: dict[str, tuple[float, ...]]) -> str:
    """Runs the program: the ball never lies in material, and each macro finds the feature that it is above or in."""
    x = y = z = float("nan")
    component, feature, lines, on = 0, 0, list[str](), False
    nominal = {**BORES, **BOSSES}
    for line in program.splitlines():
        words = {letter: float(value) for letter, value in re.findall(r"([XYZDRWFT])(-?\d+\.?\d*)", line)}
        if "P9832" in line or "P9833" in line:
            on = "P9832" in line
        elif line.startswith(("G54", "G43", "G65 P9810")):
            assert on or "P9810" not in line
            moved = (words.get("X", x), words.get("Y", y), words.get("Z", z))
            if {"X", "Y"} & words.keys() and not np.isnan(z):
                assert z == CLEARANCE_MM and moved[2] == z  # sideways at the clearance height alone
            x, y, z = moved
            assert np.isnan(z) or z > ground(x, y)
        elif line.startswith("G65 P98"):
            component, feature = (component + 1, 1) if words["W"] == 2.0 else (component, feature + 1)
            lines.append(f"   COMPONENT NO {component}                    FEATURE NO {feature}")
            if "P9811" in line:
                name = next(name for name, (at, _) in FACED.items() if at == y)
                assert words["Z"] == PLANES[name] and 0.0 < z - words["Z"] <= 5.0
                lines.append(
                    f"POSN Z{words['Z']:.4f}   ACTUAL {cut[name][0]:.4f}   DEV {cut[name][0] - words['Z']:.4f}"
                )
                continue
            name = next(name for name, (u, v, *_) in nominal.items() if (u, v) == (x, y))
            low, height = words.get("Z", z), nominal[name][3]
            assert words["D"] == nominal[name][2] and -height < low < 0.0
            assert ("Z" in words) == (name in BOSSES) == (z > 0.0)
            if name in BOSSES:  # the ball comes down at R beside the wall, on four sides
                reach = words["D"] / 2 + words["R"]
                for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                    assert low > ground(x + i * reach, y + j * reach)
            u, v, d = cut[name]
            lines.append(f"SIZE D{words['D']:.4f}   ACTUAL {d:.4f}   DEV {d - words['D']:.4f}")
            lines.append(f"POSN X{x:.4f}   ACTUAL {u:.4f}   DEV {u - x:.4f}")
            lines.append(f"POSN Y{y:.4f}   ACTUAL {v:.4f}   DEV {v - y:.4f}")
    assert not on and component == 1
    return "\n".join(lines) + "\n"


def test_a_machine_that_runs_the_program_prints_what_the_job_reads(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "plate.toml"
    program = job.with_name("probe.nc")
    told = run("mill", "probe", job, "-o", program, "--tool", "30", "--ball-mm", "6", "--clearance-mm", "20")
    mill = Mill({1: 0.012, 2: -0.02}, {1: 0.03, 2: 0.0}, scatter=3e-4)
    job.with_name("part.txt").write_text(printed(program.read_text(), mill.cut(np.random.default_rng(3))))
    names = told[told.index("[names]") : told.index("written:")]
    text = job.read_text().replace('file = "part-1.dmo"', 'file = "part.txt"\nunit = "mm"')
    job.write_text(f"{text}\n{names}")
    found = json.loads(run("mill", "entries", job, "--json"))
    changes = {(one["register"], one["of"]): one["change_um"] for one in found["entries"]}
    assert changes == {
        ("radius", "2"): pytest.approx(-20.0, abs=1.5),
        ("radius", "1"): pytest.approx(12.0, abs=1.5),
        ("length", "1"): pytest.approx(30.0, abs=1.5),
    }
    assert len(found["expected"]) == 27 and found["unused"] == []


def of(name: str, kind: str, at: tuple[float, float, float], size: float = 10.0, i: float = 1.0) -> MilledFeature:
    direction = (0.0, 0.0, 1.0) if kind in ("face", "bore", "boss") else (i, (1.0 - i * i) ** 0.5, 0.0)
    depth = 0.0 if kind == "face" else 8.0
    return MilledFeature(name, kind, at, 1, "G54", 0.0 if kind == "face" else size, direction, depth)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("features", "left_out"),
    [
        ([of("A", "bore", (0, 0, 0), 7.9)], ["A"]),  # a ball of 6 mm with 1.9 mm of room
        ([of("A", "bore", (0, 0, 0), 8.1)], []),
        ([replace(of("A", "boss", (0, 0, 0)), depth_mm=5.9)], ["A"]),  # the ball's middle is above its edge
        ([of("A", "slot", (0, 0, 0), 20.0, 0.6)], ["A"]),
        ([of("A", "boss", (0, 0, 0)), of("B", "boss", (20.9, 0, 0))], ["A", "B"]),  # 5 + 5 + 6 from the middle
        ([of("A", "boss", (0, 0, 0)), of("B", "boss", (21.1, 0, 0))], []),
        ([of("A", "rib", (0, 0, 0)), of("B", "boss", (12, 40, 0))], []),  # beside the rib's line, far along it
        ([of("A", "slot", (0, 0, 0), 30.0), of("B", "boss", (0, 0, 0))], ["A", "B"]),
        ([of("A", "slot", (0, 0, 0), 33.0), of("B", "boss", (0, 60, 0))], []),
        ([of("A", "face", (0, 0, 0)), of("B", "face", (0, 0, -5))], ["A", "B"]),
        ([of("A", "face", (0, 0, 0)), of("B", "bore", (0, 3, 0), 12.0)], ["A"]),
    ],
)  # fmt: skip
def test_features_that_a_probe_cannot_reach_are_left_out(features: list[MilledFeature], left_out: list[str]) -> None:
    always = of("Z", "bore", (200.0, 200.0, 0.0), 20.0)
    made = inspection_plus_program("part", [*features, always], MacroProbe(30, BALL_MM, CLEARANCE_MM))
    assert [one.partition(":")[0] for one in made.left_out] == left_out


def test_walls_and_inches(tmp_path: Path) -> None:
    features = [of("A", "slot", (25.4, 0.0, 0.0), 25.4, 0.0), of("B", "rib", (25.4, 100.0, 0.0), 12.7)]
    text = inspection_plus_program("part", features, MacroProbe(7, BALL_MM, CLEARANCE_MM, inch=True)).text
    assert "G20 " in text and "T7 M6" in text and "H7 Z0.7874" in text
    assert "G65 P9810 X1. Y0. F118.1102\nG65 P9810 Z-0.1575 F39.3701\nG65 P9812 Y1. W2.\n" in text
    assert "G65 P9810 Z0.1969 F39.3701\nG65 P9812 X0.5 Z-0.1575 R0.1969 W1.\n" in text


def test_a_job_of_another_control_gets_no_macros_and_nothing_is_written(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    job, output = tmp_path / "plate" / "plate.toml", tmp_path / "probe.nc"
    job.with_name("finish.nc").write_text(plate("siemens"))
    job.write_text(job.read_text().replace('dialect = "fanuc-mill"\n', ""))
    options = ("-o", output, "--tool", "30", "--ball-mm", "6", "--clearance-mm", "20")
    assert "MIL-PROBE: no probing program is written for siemens" in run("mill", "probe", job, *options, status=3)
    assert not output.exists()
