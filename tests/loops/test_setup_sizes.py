"""A length between faces of two set-ups, as the whole length of a shaft: judged as expected, and cut so.

The model cuts both sides; in the second set-up the part stands on the front that the first one has cut.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_setups import CONTOUR, SET_OFF, WORN, by_tool, on, programs
from tests.support.cli import run
from tests.support.grooved import Cutting
from tests.support.two_sides import FRAMES, PLACES, first, job, measured_um, second, standing_um
from trueloop.arrays import Array
from trueloop.domain.characteristic import Judgement
from trueloop.jobs.turned.compensate import corrected_part
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.part import PartCorrection

ASKED = "".join(
    f'\n[[part.characteristic]]\nname = "{name}"\nquantity = "length"\nfeature = "{one}"\nother = "{other}"\n'
    'tolerance = "±0.05"\n'
    for name, one, other in (("L", "back", "front"), ("W", "step", "back-step"))
)
"""The whole length, 80 mm, and the width of the collar, 20 mm."""
HELD = {"flipped": (True, FRAMES), "taken over": (False, {**FRAMES, "second": "zero_at_z_mm = -80.0"})}
STOP_MM = 0.030


def point_of(feature: str, x_mm: float) -> str:
    return str(1 + next(k for k, p in enumerate(PLACES) if p.feature == feature and p.x_mm == x_mm))


def corrected(
    folder: Path,
    errors_um: Array,
    more: str = "",
    reference: str = point_of("front", 10.0),
    frames: Mapping[str, str] = FRAMES,
) -> PartCorrection:
    """`more`: tables of the job; z counts from the touch `reference`, "" from none."""
    counted = f'z_reference = "{reference}"\n' if reference else ""
    path = job(folder, list(errors_um), counted + more, frames=frames, part=ASKED)
    run("compensate", path, "-o", folder / "out")
    return corrected_part(JobFiles.of(path))


def lengths(done: PartCorrection) -> dict[str, Judgement]:
    return {one.characteristic.name: one.after for one in done.characteristics}


def true_mm(errors_um: Array) -> dict[str, float]:
    """By hand: both faces of each length look away from its middle, so that what is left on them makes it longer."""
    means = {name: float(np.mean(errors_um[on(name) > 0.0])) * 1e-3 for name in ("front", "back", "step", "back-step")}
    return {"L": 80.0 + means["front"] + means["back"], "W": 20.0 + means["step"] + means["back-step"]}


def place(folder: Path, turned_round: bool) -> None:
    (folder / "first.ngc").write_text(first("linuxcnc"))
    (folder / "second.ngc").write_text(second("linuxcnc", sign=1.0 if turned_round else -1.0))


def cut(folder: Path, cuttings: Mapping[int, Cutting], turned_round: bool, out: str = "") -> Array:
    """A part, which stands on its front in the second set-up."""
    return standing_um(measured_um(programs(folder, out), cuttings, turned_round=turned_round), STOP_MM)


def seen(errors_um: Array) -> Array:
    """As a device sees it that has the part's zero 4 µm too high."""
    return errors_um - 4.0 * np.array([p.normal[1] for p in PLACES])


@pytest.mark.parametrize("held", HELD)
def test_the_next_part_is_as_long_as_expected(tmp_path: Path, held: str) -> None:
    """By the contour: worn noses, tools that are set wrong, and a stop that is off by 30 µm, which the second takes."""
    turned_round, frames = HELD[held]
    place(tmp_path, turned_round)
    before = cut(tmp_path, WORN, turned_round)
    assert abs(true_mm(before)["L"] - 80.0) > 0.01
    done = corrected(tmp_path, seen(before), CONTOUR, frames=frames)
    after = true_mm(cut(tmp_path, WORN, turned_round, "out"))
    assert after == pytest.approx({"L": 80.0, "W": 20.0}, abs=2e-4)
    assert {name: one.value for name, one in lengths(done).items()} == pytest.approx(after, abs=3e-4)


@pytest.mark.parametrize("held", HELD)
def test_an_offset_takes_out_what_the_second_datum_is_off_by(tmp_path: Path, held: str) -> None:
    """By hand: T2 cuts back and back-step; its Z is off by 9 µm, and Z of the program is ∓z. The front is cut at
    −4 µm, which the second program takes for its zero, and the stop is off by 30: with o its offset, the surface lies
    at sign·o + 30 + e of the front, whose own error is nothing where z counts from it.
    """
    turned_round, frames = HELD[held]
    sign = -1.0 if turned_round else 1.0
    place(tmp_path, turned_round)
    done = corrected(tmp_path, seen(cut(tmp_path, SET_OFF, turned_round)), frames=frames)
    made = by_tool(done)
    assert made["T1"].wear.z == pytest.approx(0.0, abs=1e-4)
    assert made["T2"].wear.z == pytest.approx(-sign * (sign * 0.009 + STOP_MM), abs=2e-4)
    entered = {
        tool: Cutting((off.off_mm[0] + made[f"T{tool}"].wear.x / 2, off.off_mm[1] + made[f"T{tool}"].wear.z))
        for tool, off in SET_OFF.items()
    }
    after = true_mm(cut(tmp_path, entered, turned_round))
    assert {name: one.value for name, one in lengths(done).items()} == pytest.approx(after, abs=3e-4)
    assert after["L"] == pytest.approx(80.0, abs=2e-4)


def test_with_z_from_no_face_the_next_part_is_off_by_what_the_front_was(tmp_path: Path) -> None:
    """By hand: the front is 4 µm short; moved out by that, it takes all of the second side with it: 4 µm too short."""
    place(tmp_path, True)
    before = cut(tmp_path, SET_OFF, True)
    made = by_tool(corrected(tmp_path, before, CONTOUR, reference=""))
    assert made["T1"].decision.offset_mm[1] == pytest.approx(0.004, abs=2e-4)
    assert true_mm(cut(tmp_path, SET_OFF, True, "out"))["L"] == pytest.approx(80.0 - 0.004, abs=3e-4)


def test_half_a_correction_leaves_half_of_each_face(tmp_path: Path) -> None:
    """By hand: 4 µm on the step and 10 on the back faces of the second side, the front is where z counts from."""
    errors = 4.0 * on("step") + 10.0 * on("back", "back-step")
    errors += 10.0 * np.array([-p.normal[1] * (p.feature in ("edge", "bore-chamfer")) for p in PLACES])
    done = corrected(tmp_path, errors, f"{CONTOUR}weight = 0.5\n")
    found = {name: one.value for name, one in lengths(done).items()}
    assert found == pytest.approx({"L": 80.005, "W": 20.007}, abs=1e-4)
    assert not any("not judged" in note for note in done.notes)


def test_the_tool_of_the_zero_face_does_not_move_along_z_and_lengths_stay(tmp_path: Path) -> None:
    """By hand: z counts from the middle of a face that is 3 µm proud at its other touches, 2 in the mean. Its tool,
    which cuts both ends on its side, does not move along z for that: the face and the ends would move together. The
    lengths that the part had, 80.002 and 20, it keeps, also where the second side is cut first.
    """
    for face, middle, order in (("front", 10.0, 1), ("back", 14.0, -1)):
        folder = tmp_path / face
        folder.mkdir()
        errors = 3.0 * np.array([float(p.feature == face and p.x_mm != middle) for p in PLACES])
        path = job(folder, errors.tolist(), f'z_reference = "{point_of(face, middle)}"\n{CONTOUR}', part=ASKED)
        head, *setups = path.read_text().split("[[setups]]\n")
        setups[-1], gauging = setups[-1].split("[gauging]\n")
        path.write_text("[[setups]]\n".join([head, *setups[::order]]) + "[gauging]\n" + gauging)
        found = lengths(corrected_part(JobFiles.of(path)))
        assert {name: one.value for name, one in found.items()} == pytest.approx({"L": 80.002, "W": 20.0}, abs=1e-5)
        (one,) = [one for one in by_tool(corrected_part(JobFiles.of(path))).values() if face in one.profile.names]
        assert one.decision.offset_mm[1] == 0.0


def test_a_length_from_the_face_that_it_stands_on_is_as_sure_as_the_other_side(tmp_path: Path) -> None:
    """The front's next cut moves both ends of L; of W, which begins at the step, it moves one end alone."""
    done = corrected(tmp_path, 0.0 * on("front"), CONTOUR)
    made = by_tool(done)

    def u_mm(tool: str, feature: str) -> float:
        correction = made[tool]
        index = correction.profile.names.index(feature)
        at = np.array([0.5 * correction.profile.features[index].length_mm])
        return float(correction.next_cut(index, at).expanded_u_mm[0]) / 1.96

    touched = float(np.max(done_u(tmp_path)))
    found = lengths(done)
    assert found["L"].standard_u == pytest.approx(np.hypot(u_mm("T2", "back"), touched), rel=0.1)
    parts = (u_mm("T1", "step"), u_mm("T2", "back-step"), u_mm("T1", "front"), touched)
    assert found["W"].standard_u == pytest.approx(float(np.linalg.norm(parts)), rel=0.1)


def done_u(folder: Path) -> Array:
    """Standard uncertainties of the touches of the front."""
    from trueloop.jobs.turned.job import read_cuts

    read = read_cuts(JobFiles.of(folder / "job.toml"))
    return read.measured.vectors.standard_u_mm[on("front") > 0.0]


def test_on_what_the_part_stands_has_to_be_known(tmp_path: Path) -> None:
    """z from no face; z from a face that the later set-up cuts; a semi-finished face. Named, and not judged."""
    errors = 0.0 * on("front")
    done = corrected(tmp_path, errors, reference="")
    assert not done.characteristics
    assert (
        "L and W: sizes of no single set-up, which are not judged: z counts from no face, and on which face the part "
        "stands is not known." in done.notes
    )
    told = "L and W: sizes of no single set-up, which are not judged."
    late = corrected(tmp_path, errors, reference=point_of("back", 14.0))
    assert not late.characteristics and told in late.notes
    allowed = corrected(tmp_path, errors, "measured_allowance_mm = 0.0001\n")
    assert not allowed.characteristics and told in allowed.notes
    assert len(corrected(tmp_path, errors).characteristics) == 2


def test_it_stands_in_the_page_and_in_the_file(tmp_path: Path) -> None:
    corrected(tmp_path, 0.0 * on("front"))
    told = json.loads((tmp_path / "out" / "part.json").read_text())["characteristics"]
    assert [one["name"] for one in told] == ["L", "W"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Sizes between edges" in page and ">W<" in page
