"""`trueloop mill new`: features of programs that a generator apart writes, and the numbers that they lead to."""

import json
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.mill_programs import CONTROLS, RADIUS, Control, Writer, plate
from tests.support.mill_shop import BORES, BOSSES

ROUND = {
    *(("bore", x, y, 0.0, d, t, 2, "control", "climb") for x, y, d, t in BORES.values()),
    *(("boss", x, y, 0.0, d, t, 1, "control", "climb") for x, y, d, t in BOSSES.values()),
}
HOLE = ("bore", 80.0, 40.0, 0.0, 6.0, 20.0, 6, "program", "")
POCKET = {
    ("slot", 75.0, 0.0, 0.0, 30.0, 12.0, 2, "control", "conventional"),
    ("slot", 75.0, 0.0, 0.0, 20.0, 12.0, 2, "control", "conventional"),
}
FACES = {
    ("face", x, y, z, 0.0, 0.0, tool, "program", "")
    for x, y, z, tool in [(0, 60, 0, 1), (0, 75, -8, 1), (0, 90, -15, 1), (0, -45, -5, 3)]
}


def proposed(program: Path, *options: object) -> tuple[set[tuple[object, ...]], list[str]]:
    """Returns what `mill new` finds, and its notes; the job is beside the program."""
    found = json.loads(run("mill", "new", program, "-o", program.with_suffix(".toml"), "--json", *options))
    features = {
        (one["kind"], *(round(value, 4) + 0.0 for value in (*one["at_mm"], one["size_mm"], one["depth_mm"])),
         one["tool"], one["radius"], one["side"])
        for one in found["features"]
    }  # fmt: skip
    assert len(features) == len(found["features"])
    return features, found["notes"]


@pytest.mark.parametrize("control", CONTROLS)
def test_features_of_a_program_are_those_that_its_writer_cut(tmp_path: Path, control: Control) -> None:
    program = tmp_path / "own.nc"
    program.write_text(plate(control))
    features, notes = proposed(program, "-d", control, "--tool", "6=R3")
    assert features == ROUND | {HOLE} | POCKET | FACES and notes == []


def test_a_proposed_job_leads_to_the_numbers_of_the_one_written_by_hand(tmp_path: Path) -> None:
    run("examples", "plate", "-o", tmp_path)
    job = tmp_path / "plate" / "new.toml"
    run("mill", "new", job.with_name("finish.nc"), "-o", job, "-d", "fanuc-mill", "--name", "plate", "-t", "6=R3")
    names = {f"B{k}": f"bore{k + 1}" for k in range(6)} | {
        "S0": "boss1",
        "S1": "boss2",
        "top": "face1",
        "floor": "face4",
    }
    names["step"] = "face3"
    listed = "\n".join(f'{own} = "{proposed}"' for own, proposed in names.items())
    text = job.read_text().replace('unit = "mm"', 'unit = "mm"\nmeasuring_u_um = 0.8')
    job.write_text(f"{text}\n[names]\n{listed}\n")

    def numbers(name: str) -> list[dict[str, object]]:
        found = json.loads(run("mill", "entries", job.with_name(name), "--json", "-o", tmp_path / name))
        return list(found["entries"])

    by_hand, by_program = numbers("plate.toml"), numbers("new.toml")
    assert len(by_hand) == 6 and by_program == by_hand


def test_paths_of_the_centre_need_the_cutters_radius(tmp_path: Path) -> None:
    """D holds wear alone in the first; a bore and a boss by G40, and a hole, in the second."""
    program = tmp_path / "own.nc"
    program.write_text(plate("fanuc-mill", lambda writer: writer.wear_of.update({1: 10.0, 2: 4.0})))
    radii = [f"--tool={tool}=R{radius}" for tool, radius in RADIUS.items()]
    assert proposed(program, "-d", "fanuc-mill", "--wear", *radii)[0] == ROUND | {HOLE} | POCKET | FACES
    program = tmp_path / "centre.nc"
    program.write_text(
        "G21 G17 G90 G40 G49\nT4 M6\nG54 G0 X0. Y0. S3000 M3\nG43 H4 Z20.\n"
        "G1 Z-5. F100.\nX7.\nG3 I-7.\nG1 X0.\nG0 Z20.\nX80. Y0.\nG1 Z-6.\nX64.\nG2 I-14.\nG1 X80.\nG0 Z20.\nM30\n"
    )
    assert "line 7: a circle about x 0.000, y 0.000 mm by tool 4: state its radius" in run(
        "mill", "new", program, "-o", tmp_path / "none.toml", "-d", "haas-mill", status=3
    )
    assert not (tmp_path / "none.toml").exists()
    found, _ = proposed(program, "-d", "haas-mill", "--tool", "4=R5", "--name", "c")
    assert found == {
        ("bore", 0.0, 0.0, 0.0, 24.0, 5.0, 4, "program", "climb"),
        ("boss", 50.0, 0.0, 0.0, 18.0, 6.0, 4, "program", "climb"),
    }


def test_a_drill_through_a_finished_bore_is_asked_for(tmp_path: Path) -> None:
    """Tool 7 drills through the bore at x −50, y −30 mm, which tool 2 has finished: by its radius it cuts it last."""
    x, y, program = -50.0, -30.0, tmp_path / "own.nc"
    late = Writer("fanuc-mill")
    late.change(7, 0)
    late.drill(x, y, -25.0)
    program.write_text(plate("fanuc-mill").replace("M30", "\n".join(late.lines) + "\nM30"))
    options = ("-d", "fanuc-mill", "--tool", "6=R3")
    features, [note] = proposed(program, *options)
    assert ROUND - features == {one for one in ROUND if one[1:3] == (x, y)}
    assert "--tool 7=R…" in note
    program.with_suffix(".toml").unlink()
    assert proposed(program, *options, "--tool", "7=R4")[0] >= ROUND


def test_walls_that_passes_of_their_own_cut_are_a_slot_or_are_noted(tmp_path: Path) -> None:
    """A slot 14 mm wide about y 30, each wall roughed 0.3 mm short and finished by G41 and G40, at z −3 and −6; and the
    wall at y −40 of a step, which has none opposite.
    """

    def wall(y: float, begin: float, end: float, z: float) -> str:
        lead = 10.0 if end > begin else -10.0
        middle = 30.0 if y > 0.0 else y - 10.0
        return (
            f"G0 X{begin - lead} Y{middle}\nG1 Z{z} F200.\nG41 D3 X{begin} Y{y}\nX{end}\n"
            f"G40 X{end + lead} Y{middle}\nG0 Z20.\n"
        )

    slot = "".join(
        wall(23.0 + short, -55.0, -15.0, z) + wall(37.0 - short, -15.0, -55.0, z)
        for z in (-3.0, -6.0)
        for short in (0.3, 0.0)
    )
    program = tmp_path / "own.nc"
    program.write_text(
        "G21 G17 G90 G40 G49\nT3 M6\nG54 G0 X-65. Y30. S3000 M3\nG43 H3 Z20.\n"
        f"{slot}{wall(-40.0, 50.0, 10.0, -5.0)}M30\n"
    )
    found, [note] = proposed(program, "-d", "fanuc-mill", "--tool", "3=R5")
    assert found == {("slot", -35.0, 30.0, 0.0, 14.0, 6.0, 3, "control", "climb")}
    line = program.read_text().splitlines().index("G41 D3 X50.0 Y-40.0") + 2
    assert note.startswith(f"line {line}: a straight wall at x 30.000, y -40.000 mm without one opposite")
    assert "direction = [0, -1, 0.0]" in note


def test_an_inch_program_gives_a_job_in_inches(tmp_path: Path) -> None:
    program = tmp_path / "inch.nc"
    program.write_text(
        "G20 G17 G90 G40 G49\nT4 M6\nG55 G0 X1. Y0. S3000 M3\nG43 H4 Z1.\n"
        "G1 Z-.5 F10.\nG42 D4 X1.25\nG2 I-.25\nG40 G1 X1.\nG0 Z1.\nM30\n"
    )
    found, _ = proposed(program, "-d", "haas-mill")
    assert found == {("bore", 25.4, 0.0, 0.0, 12.7, 12.7, 4, "control", "conventional")}
    text = (tmp_path / "inch.toml").read_text()
    assert 'unit = "inch"' in text and "at = [1.0, 0.0, 0.0]\nsize = 0.5\ndepth = 0.5" in text and "G55" in text
