"""A length between faces that are not cut together corrects the one of them that the other readings do not place."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import trueloop
from tests.support.cli import invoke, run
from tests.support.two_sides import PLACES, job

PROGRAM = """O1
G21 G40 G99
G97 S1500 M3
T0303
G0 X40. Z2.
G0 X0
G42 G1 Z0. F0.1
X30. ,C1.
Z-20.
G40 X42.
G0 X100. Z100.
T0505
G0 X28. Z-18.
G42 G1 X30. Z-20. F0.1
X36.
Z-50.
G40 X42.
G0 X100. Z100.
M30
"""
DIAMETERS = ("seat,-5,,30.000,,", "seat,-15,,30.000,,", "collar,-25,,36.000,,", "collar,-45,,36.000,,")


DRAWN = '[[part.characteristic]]\nname = "{}"\nquantity = "{}"\nfeature = "{}"\n{}tolerance = "±0.01"\n'


def certified(job: Path, serial: str, device: str = "MIC 2") -> dict[str, tuple[float | None, str | None]]:
    """Correct a finished part, measure what was cut then, and certify it: value and verdict of each characteristic."""
    run("compensate", job, "-o", job.parent / "o", "--serial", serial)
    after = job.parent / "after.csv"
    after.write_text(f"# instrument: {device}\n" + (job.parent / "r.csv").read_text())
    run("measure", "read", after, "--job", job, "--after", "finish", "--serial", serial)
    db = job.parent / "trueloop.db"
    invoke("monitor", "certify", serial, "--db", db, "-o", job.parent / "c")
    shown = json.loads((job.parent / "c" / f"certificate-{serial}.json").read_text())
    return {one["characteristic"]: (one["actual"], one["verdict"]) for one in shown["characteristics"]}


def two_tools(folder: Path, *lengths: str) -> Path:
    (folder / "f.nc").write_text(PROGRAM)
    rows = ["feature,z_mm,from,diameter_mm,length_mm,uncertainty_um", *(f"{row}1" for row in DIAMETERS), *lengths]
    (folder / "r.csv").write_text("\n".join(rows) + "\n")
    features = (("front", 15, 0), ("seat", 15, -20), ("shoulder", 18, -20), ("collar", 18, -50))
    order = [(18, -50), *[(x, z) for _, x, z in reversed(features)][1:], (0, 0)]
    names = [name for name, _, _ in reversed(features)]
    drawn = "".join(
        f'[[part.feature]]\nname = "{name}"\nto = [{x}, {z}]\n' for name, (x, z) in zip(names, order[1:], strict=True)
    )
    path = folder / "job.toml"
    path.write_text(
        f'[part]\nname = "s"\nstart = [18, -50]\n{drawn}'
        "[[tools]]\nnumber = 3\nnose_radius_mm = 0.2\n[[tools]]\nnumber = 5\nnose_radius_mm = 0.2\n"
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "f.nc"\ncut_with = "given"\n'
        '[gauging]\nreadings = "r.csv"\n[compensation]\nby = "offset"\n[output]\nfolder = "o"\n'
    )
    return path


def wear_z_mm(said: str, tool: str) -> float:
    found = re.search(tool + r" wear X .*?, Z ([−+][\d.]+)", said)
    assert found, said
    return float(found[1].replace("−", "-"))


@pytest.mark.parametrize("off_mm", [0.040, -0.040])
def test_shoulders_that_are_set_off_bend_no_seat_beside_them(tmp_path: Path, off_mm: float) -> None:
    """68 mm between the shoulders of `examples/shaft`, 40 µm off: diameters of seats and journal stay within 2 µm."""
    example = trueloop.example("shaft/job.toml").parent
    for name in ("job.toml", "finish.nc"):
        (tmp_path / name).write_text((example / name).read_text())
    written = (example / "readings.csv").read_text().splitlines()
    at = written.index("feature,z_mm,diameter_mm")

    def curves(*lengths: str) -> dict[str, np.ndarray]:
        rows = [*written[:at], f"{written[at]},from,length_mm", *(f"{row},," for row in written[at + 1 :]), *lengths]
        (tmp_path / "readings.csv").write_text("\n".join(rows) + "\n")
        model = trueloop.compensate(trueloop.read_job(tmp_path / "job.toml").inputs).model
        return {one.feature: 1e3 * one.value_mm(np.linspace(0.0, one.length_mm, 25)) for one in model.curves}

    without, found = curves(), curves(f"shoulder-1,,,shoulder-2,{68 + off_mm}")
    for seat in ("seat-44", "seat-36", "seat-30", "journal-24"):
        assert 2 * found[seat] == pytest.approx(2 * without[seat], abs=2.0)
    moved = found["shoulder-1"].mean() - found["shoulder-2"].mean()
    assert moved == pytest.approx(1e3 * off_mm, abs=2.0)


def test_a_length_from_the_datum_moves_the_tool_of_its_other_face(tmp_path: Path) -> None:
    """20.012 mm from the front (T3) to the shoulder (T5): 12 µm were left on less there, and T5 gets them in Z.

    The shoulder looks to z+, the length runs from it towards z−: it is long where the shoulder was cut too deep.
    """
    said = run("compensate", two_tools(tmp_path, "shoulder,,front,,20.012,1"), "-o", tmp_path / "o")
    assert wear_z_mm(said, "T5") == pytest.approx(0.012, abs=0.0015)
    assert "T3 wear" not in said or abs(wear_z_mm(said, "T3")) < 0.001
    assert "taken as the error of shoulder, counted from front" in " ".join(said.split())


def test_the_second_set_up_takes_the_whole_length(tmp_path: Path) -> None:
    """80.016 mm from the front (first set-up) to the back (second): 16 µm are left on at the back, which the second
    set-up takes off: its tools come closer to the chuck, Z −0.016.
    """
    path = job(tmp_path, [0.0] * len(PLACES))
    (tmp_path / "r.csv").write_text(
        "feature,z_mm,from,diameter_mm,length_mm,uncertainty_um\n"
        "seat,-10,,36.000,,1\nseat,-20,,36.000,,1\nback-seat,-60,,38.000,,1\nback-seat,-70,,38.000,,1\n"
        "back,,front,,80.016,1\n"
    )
    path.write_text(path.read_text().replace('touches = "touches.csv"', 'readings = "r.csv"'))
    said = run("compensate", path, "-o", tmp_path / "o")
    assert wear_z_mm(said, "T2") == pytest.approx(-0.016, abs=0.002)
    assert "taken as the error of back, counted from front" in " ".join(said.split())


def test_an_angle_alone_of_what_an_edge_cuts_corrects_nothing_and_a_note_states_it(tmp_path: Path) -> None:
    path = two_tools(tmp_path)
    path.write_text(path.read_text().replace("start = [18, -50]", "start = [18.5, -50]"))
    (tmp_path / "f.nc").write_text(PROGRAM.replace("Z-50.", "X37. Z-50."))
    rows = ("seat,-5,30.010,", "seat,-15,30.010,", "collar,,,0.96")
    (tmp_path / "r.csv").write_text("feature,z_mm,diameter_mm,angle_deg\n" + "\n".join(rows) + "\n")
    said = run("compensate", path)
    assert "collar angle: corrects nothing, as no diameter, length or touch states where the surface is" in said
    assert "T5 wear" not in said


@pytest.mark.parametrize(("read_mm", "verdict"), [(20.002, "in"), (20.012, "out")])
def test_a_length_of_two_tools_is_judged_as_measured_and_in_the_certificate(
    tmp_path: Path, read_mm: float, verdict: str
) -> None:
    path = two_tools(tmp_path, f"shoulder,,front,,{read_mm},1")
    path.write_text(path.read_text() + DRAWN.format("L20", "length", "shoulder", 'other = "front"\n'))
    assert certified(path, "7") == {"L20": (read_mm, verdict)}
    (size,) = json.loads((tmp_path / "o" / "part.json").read_text())["characteristics"]
    assert size["before"]["value"] == pytest.approx(read_mm) and size["before"]["verdict"] == verdict
    assert size["before"]["standard_u"] == pytest.approx(0.001)


def test_sizes_of_two_set_ups_are_in_the_certificate(tmp_path: Path) -> None:
    """A length between faces of both, one from the part's zero, and a diameter at a place that the second has turned
    round.
    """
    path = job(tmp_path, [0.0] * len(PLACES))
    (tmp_path / "r.csv").write_text(
        "feature,z_mm,from,diameter_mm,length_mm,uncertainty_um\n"
        "seat,-10,,36.000,,1\nback-seat,-60,,38.006,,1\nback-seat,-70,,38.000,,1\n"
        "back,,front,,80.007,1\nback-step,,,,50.012,1\n"
    )
    drawn = DRAWN.format("L80", "length", "back", 'other = "front"\n') + DRAWN.format("L50", "length", "back-step", "")
    drawn += DRAWN.format("D38", "diameter", "back-seat", "at_z_mm = -60\n")
    path.write_text(path.read_text().replace('touches = "touches.csv"', 'readings = "r.csv"') + drawn)
    sizes = {"L80": (80.007, "in"), "L50": (50.012, "out"), "D38": (38.006, "in")}
    assert certified(path, "7") == sizes
    said = json.loads((tmp_path / "o" / "part.json").read_text())
    assert {one["name"]: one["before"]["verdict"] for one in said["characteristics"]} == {"L80": "in"}
    assert not any("z counts from no face" in note for note in said["notes"])
