"""Programs that turn rotary axes in their cuts: tip and axis of the tool in the work, by a machine written apart in 4×4
matrices, with the control's own way from the tip's places to its axes.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.support.machined_path import known_machine, physical
from trueloop.arrays import Array
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.model_file import model_to_json
from trueloop.jobs.machine.mapped_program import ModelFile, compensate_program
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.machine.correct import Setup
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Term
from trueloop.nc.program.called import CutterTool

ZERO, TOOL = (30.0, -20.0, -150.0), (5.0, -8.0, -110.0)
SETUP = Setup({1: ZERO}, {-1: TOOL})
STRUCTURES = {
    "table-table AC": "five-axis-table-table-ac",
    "table-table BC": "five-axis-table-table-bc",
    "head-table BC": "five-axis-head-table-bc",
    "head-head CA": "five-axis-head-head-ca",
}


class _Control:
    """The machine of `structure` as the control takes it to be and as it is: `rotary` are its letters, in words."""

    def __init__(self, structure: str, sense: float = 1.0) -> None:
        self.model, self.truth = known_machine(structure, sense)
        self.sense, self.rotary = sense, "".join(sorted(set(structure[-2:].upper())))

    def joints(self, words: Array, tool_point: bool) -> dict[str, Array]:
        """Axis positions (mm, rad) of words (n, 5): under tool point control those that bring the tip to its place."""
        at = {name: np.radians(words[:, 3 + k]) for k, name in enumerate(self.rotary)}
        upright = np.array(ZERO) - np.array(TOOL)
        axes = words[:, :3] + upright
        at |= dict(zip("XYZ", axes.T, strict=True))
        if tool_point:
            still = dict(zip("XYZABC", [*(np.array([value]) for value in upright), *np.zeros((3, 1))], strict=True))
            wanted = self._pose(still, 0.0)[:, :3] + words[:, :3]
            for _ in range(3):
                tip = self._pose(at, 0.0)[:, :3]
                probed = [self._pose({**at, name: at[name] + 64.0}, 0.0)[:, :3] - tip for name in "XYZ"]
                moved = np.linalg.solve(np.stack(probed, axis=-1) / 64.0, (wanted - tip)[:, :, None])[:, :, 0]
                at |= {name: at[name] + moved[:, k] for k, name in enumerate("XYZ")}
        return at

    def poses(self, words: Array, tool_point: bool, share: float) -> Array:
        """Tip, mm, and axis of the tool in the work, (n, 6), with that share of the machine's errors."""
        return self._pose(self.joints(words, tool_point), share)

    def _pose(self, at: dict[str, Array], share: float) -> Array:
        own = {name: values for name, values in at.items() if name in self.truth.letters}
        frame = self.truth.pose(physical(own, self.sense), share)
        return np.hstack([(frame @ np.array([*TOOL, 1.0]))[:, :3], frame[:, :3, 2]])


def _ends(text: str, rotary: str) -> dict[int, list[tuple[Array, float]]]:
    """Places (5,) and F words of blocks by the words alone, by the number of the block that they come from: those of
    the program as it was are multiples of 100.
    """
    at, feed, number = dict.fromkeys(f"XYZ{rotary}", 0.0), math.nan, 0
    found = dict[int, list[tuple[Array, float]]]()
    for line in text.splitlines():
        own = re.match(r"N?(\d+) ", line)
        number = int(own[1]) // 100 * 100 if own else number
        words = re.findall(r"([A-Z])\s*=?\s*([-+]?[\d.]+)", re.sub(r"^N?\d+ |\(.*?\)|;.*", "", line))
        given = {letter: float(value) for letter, value in words if letter in at}
        at |= given
        feed = next((float(value) for letter, value in words if letter == "F"), feed)
        if given and "G28" not in line:
            found.setdefault(number, []).append((np.array(list(at.values())), feed))
    return found


def _off(control: _Control, before: str, after: str, tool_point: bool) -> tuple[float, float]:
    """How far from the poses of a program without the machine's errors those of another are with them, at ten places of
    every piece of every cut, at one time: tip, µm, and axis, µrad.
    """
    wanted, found = (_ends(text, control.rotary) for text in (before, after))
    numbers, places, actual = list(wanted), [], []
    for number, last in zip(numbers[numbers.index(FIRST_CUT) :], numbers[numbers.index(FIRST_CUT) - 1 :], strict=False):
        pieces, start, end = found[number], wanted[last][-1][0], wanted[number][0][0]
        nodes = [found[last][-1][0], *(place for place, _ in pieces)]
        for k, share in product(range(len(pieces)), np.linspace(0, 1, 11)):
            places.append(start + (k + share) / len(pieces) * (end - start))
            actual.append(nodes[k] + share * (nodes[k + 1] - nodes[k]))
    off = control.poses(np.array(actual), tool_point, 1.0) - control.poses(np.array(places), tool_point, 0.0)
    tip, axis = (float(np.linalg.norm(part, axis=1).max()) for part in (off[:, :3], off[:, 3:]))
    return 1e3 * tip, 1e6 * axis


def _cut(control: _Control, tool_point: bool, count: int) -> list[str]:
    """Words of a cut in `count` blocks that turns both axes: of the tip, or of the machine's axes."""
    u = np.linspace(0, 1, count + 1)
    tip = np.stack([35 * np.cos(3 * u), 30 * np.sin(3 * u), -5 + 8 * u], axis=1)
    words = np.column_stack([tip, -15 - 20 * np.sin(3 * u), -70 + 130 * u])
    if not tool_point:
        at = control.joints(words, True)
        words[:, :3] = np.stack([at[name] for name in "XYZ"], axis=1) - np.array(ZERO) + np.array(TOOL)
    return [" ".join(f"{k}{v:.4f}" for k, v in zip("XYZ" + control.rotary, row, strict=True)) for row in words]


def _compensated(
    tmp_path: Path,
    model: MachineModel,
    text: str,
    dialect: str = "fanuc-mill",
    setup: Setup = SETUP,
    options: MapOptions | None = None,
    parameters: Mapping[str, float] | None = None,
) -> tuple[str, Mapped]:
    source, file = tmp_path / "part.nc", tmp_path / "model.json"
    source.write_text(text)
    file.write_text(model_to_json(model))
    chosen = options or MapOptions(tolerance_mm=0.0001, limit_mm=1.0, decimals=6)
    done = compensate_program(
        source, tmp_path / "out.nc", ModelFile(model, file), setup, chosen, dialect=dialect, parameters=parameters
    )
    return (tmp_path / "out.nc").read_text(), done


FIRST_CUT = 600


def _program(cut: list[str], on: str, feed: str = "G1 F800.") -> str:
    """A Fanuc program of that cut: above its start with the tool upright, over it as it leans, down at rapid, cuts."""
    x, y, z, a, c = cut[0].split()
    lines = ["G21 G90 G54", f"G0 {a[0]}0. C0.", f"{on} Z60.", f"{x} {y} {a} {c}", z]
    lines += [f"{feed if k == 0 else ''} {words}" for k, words in enumerate(cut[1:])]
    lines += ["G49", "G91 G28 Z0.", "M30"]
    return "".join(f"N{100 * k} {line}\n" for k, line in enumerate(lines, 1))


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("tool_point", [True, False])
@pytest.mark.parametrize("structure", STRUCTURES.values(), ids=STRUCTURES)
def test_tip_and_axis_are_as_programmed(tmp_path: Path, structure: str, tool_point: bool, sense: float) -> None:
    """All along the way, not at the ends of blocks alone, in four long blocks: 0.3 µm and 1 µrad."""
    control = _Control(structure, sense)
    text = _program(_cut(control, tool_point, 4), "G43.4 H1" if tool_point else "G43 H1")
    written, done = _compensated(tmp_path, control.model, text)
    before, after = _off(control, text, text, tool_point), _off(control, text, written, tool_point)
    assert before[0] > 20 and before[1] > 20
    assert after[0] < 0.3 and after[1] < 1.0
    assert done.added_blocks > 0


def test_a_head_that_stands_turned_is_corrected_as_one_that_turns(tmp_path: Path) -> None:
    """3+2 with B of the head at −20°, in X, Y, Z of the machine's axes."""
    control = _Control(STRUCTURES["head-table BC"])
    cut = [f"X{20 + x}. Y{y}. Z{z}. B-20. C30." for x, y, z in ((0, 0, 0), (40, 10, -5), (10, 50, -8))]
    text = _program([cut[0], *(words.rpartition(" B")[0] for words in cut[1:])], "G43 H1")
    written, _ = _compensated(tmp_path, control.model, text)
    before, after = (_off(control, text, program, tool_point=False) for program in (text, written))
    assert before[0] > 20 and before[1] > 20
    assert after[0] < 0.3 and after[1] < 1.0


def test_tables_as_linear_words_have_them_in_every_control(tmp_path: Path) -> None:
    """The switches of each control, its own words and comments; what is no place stays as it was, byte by byte."""
    control = _Control(STRUCTURES["table-table AC"])
    cut = _cut(control, True, 4)
    first = " ".join(cut[0].split()[:2] + cut[0].split()[3:])
    signed = [re.sub(r"([A-Z])(\d)", r"\1+\2", words) for words in cut]
    rest = [f"{words}" for words in cut[2:]]
    klartext = [f"L {words} FMAX" for words in ("Z+60 A+0 C+0 R0", "X+35 Y+0 A-15 C-70", signed[0])]
    programs = {
        "haas-mill": ["G21 G90 G54", "G0 A0. C0.", "G234 H1 Z60.", first, cut[0], f"G1 {cut[1]} F800.", *rest, "G49"],
        "siemens": [
            *("G71 G90 G54", "T1 D1", "TRAORI ; on", "G0 Z60 A0 C=DC(0)", cut[0], f"G1 {cut[1]} F800", *rest),
            *("TRAFOOF", "M30"),
        ],
        "linuxcnc": [
            *("G21 G90 G54", "M428", "G0 Z60 A0 C0", first, cut[0], f"G1 {cut[1]} F800 (in)", *rest, "M429", "M2")
        ],
        "heidenhain": [
            *("TOOL CALL 1 Z S5000", "M128", *klartext, f"L {signed[1]} F800", *(f"L {words}" for words in signed[2:])),
            *("M129", "END PGM A MM"),
        ],
    }
    for dialect, lines in programs.items():
        n = "" if dialect == "heidenhain" else "N"
        text = "0 BEGIN PGM A MM\n" * (not n) + "".join(f"{n}{100 * k} {line}\n" for k, line in enumerate(lines, 1))
        written, _ = _compensated(tmp_path, control.model, text, dialect)
        after = _off(control, text, written, tool_point=True)
        assert after[0] < 0.3 and after[1] < 1.0, dialect
        kept = [line for line in text.splitlines() if not re.search(r"[XYZAC][-+=\d]", line)]
        assert set(kept) < set(written.splitlines()), dialect


def test_inverse_time_of_a_block_is_shared_by_its_pieces(tmp_path: Path) -> None:
    """The times of the pieces are those of the block, to the last digit; the block after has its own F again."""
    control = _Control(STRUCTURES["head-head CA"])
    cut = _cut(control, False, 4)
    cut[1:] = [f"{words} F{feed}" for words, feed in zip(cut[1:], ("2.5", "10.", "7", "0.125"), strict=True)]
    text = _program(cut, "G43 H1", "G93 G1")
    written, _ = _compensated(tmp_path, control.model, text)
    wanted, found = _ends(text, control.rotary), _ends(written, control.rotary)
    for number in range(FIRST_CUT, FIRST_CUT + 400, 100):
        pieces = found[number]
        assert len(pieces) > 1
        assert math.isclose(sum(1 / feed for _, feed in pieces), 1 / wanted[number][0][1], rel_tol=1e-12)
    assert re.search(r"F\d+\.(\s|$)", written)  # 10. stays a number with a point


@pytest.mark.parametrize("on", ["G43.4 H1", "G43 H1"])
def test_a_shift_of_the_zero_moves_the_words_and_nothing_else(tmp_path: Path, on: str) -> None:
    """G52 by (5, −3, 2) mm before words that are smaller by as much: one place of the machine."""
    control = _Control(STRUCTURES["table-table AC"])
    shift = {"X": 5.0, "Y": -3.0, "Z": 2.0}
    text = _program(_cut(control, on == "G43.4 H1", 4), on)
    less = re.sub(r"([XYZ])(-?[\d.]+)", lambda one: f"{one[1]}{float(one[2]) - shift[one[1]]:.4f}", text)
    shifted = less.replace("G54\n", "G54\nN150 G52 X5. Y-3. Z2.\n", 1).replace(
        "G91 G28 Z-2.0000", "G52 X0. Y0. Z0.\nG91 G28 Z0."
    )
    found = [_ends(_compensated(tmp_path, control.model, one)[0], control.rotary) for one in (text, shifted)]
    for number in range(FIRST_CUT, FIRST_CUT + 400, 100):
        plain, moved = (np.array([place for place, _ in ends[number]]) for ends in found)
        np.testing.assert_allclose(moved[:, :3] + list(shift.values()), plain[:, :3], atol=2e-6)
        np.testing.assert_allclose(moved[:, 3:], plain[:, 3:], atol=2e-6)


@pytest.mark.parametrize("feed", ["G94 G1 F31.5", "G93 G1"])
def test_a_program_in_inches_goes_where_that_in_millimetres_does(tmp_path: Path, feed: str) -> None:
    """Angles stay degrees, and feeds what they were."""
    control = _Control(STRUCTURES["head-table BC"])
    cut = _cut(control, True, 4)
    cut[1:] = [f"{words} F2.5" if feed.startswith("G93") else words for words in cut[1:]]
    text = _program(cut, "G43.4 H1", feed)
    inch = re.sub(r"([XYZ])(-?[\d.]+)", lambda one: f"{one[1]}{float(one[2]) / 25.4:.7f}", text).replace("G21", "G20")
    found = [_ends(_compensated(tmp_path, control.model, one)[0], control.rotary) for one in (text, inch)]
    assert list(found[0]) == list(found[1])
    for number in range(FIRST_CUT, FIRST_CUT + 400, 100):
        (places, feeds), (inches, same) = (map(np.array, zip(*ends[number], strict=True)) for ends in found)
        np.testing.assert_allclose(inches[:, :3] * 25.4, places[:, :3], atol=3e-5)  # their sixth decimal is 25 nm
        np.testing.assert_allclose(inches[:, 3:], places[:, 3:], atol=2e-6)
        np.testing.assert_array_equal(same, feeds)


def test_an_error_larger_than_the_limit_is_refused_with_the_one_that_would_do(tmp_path: Path) -> None:
    control = _Control(STRUCTURES["table-table AC"])
    text = _program(_cut(control, True, 4), "G43.4 H1")
    with pytest.raises(TrueloopError, match=r"the machine's error of [\d.]+ µm is larger than 20 µm") as refused:
        _compensated(tmp_path, control.model, text, options=MapOptions(limit_mm=0.02))
    assert refused.value.code is Code.CMP_SIZE
    enough_um = int(re.search(r"--limit-um (\d+)", str(refused.value))[1])  # type: ignore[index]
    assert _off(control, text, text, tool_point=True)[0] - 1 < enough_um
    _compensated(tmp_path, control.model, text, options=MapOptions(limit_mm=1e-3 * enough_um))
    with pytest.raises(TrueloopError, match="CMP-SIZE"):
        _compensated(tmp_path, control.model, text, options=MapOptions(limit_mm=1e-3 * (enough_um - 1)))


def test_an_axis_parallel_to_the_tool_stays_and_it_is_stated_what_is_left(tmp_path: Path) -> None:
    """With the tool along C nothing that C does turns it: the tip is right, the lean left is the machine's own."""
    control = _Control(STRUCTURES["table-table AC"])
    cut = [f"X{x}. Y{x}. Z5. A0. C{c}." for x, c in ((0, 20), (10, 25), (20, 30), (30, 20))]
    text = _program(cut, "G43.4 H1")
    written, done = _compensated(tmp_path, control.model, text)
    assert {float(angle) for angle in re.findall(r"C([\d.]+)", written)} == {0, 20, 25, 30}  # 25: half way back
    tip, axis = _off(control, text, written, tool_point=True)
    lean = float(re.search(r"at 5 of 5 ends of cuts the tool is within 1° .* by up to ([\d.]+) µrad", done.notes[0])[1])  # type: ignore[index]
    assert tip < 0.3
    assert 1 < lean == pytest.approx(axis, abs=0.6)


def test_an_axis_that_passes_a_full_turn_is_stated(tmp_path: Path) -> None:
    model, _ = known_machine(STRUCTURES["head-table BC"], 1.0)
    chain = model.machine.chain
    free = chain.with_axes({"C": replace(chain.axis("C"), travel=(-math.inf, math.inf))})
    endless = replace(model, machine=replace(model.machine, chain=free), identified={})
    text = _program([f"X20. Y0. Z{z}. B-20. C{c}." for z, c in ((0, 0), (1, 0), (2, 360))], "G43.4 H1")
    _, done = _compensated(tmp_path, endless, text, options=MapOptions(limit_mm=1.0, decimals=6))
    assert any("C passes a full turn by its correction" in note for note in done.notes)
    assert any("1 cuts turn an axis by more than half a turn, first line 7" in note for note in done.notes)


def test_the_tool_is_that_of_h_in_the_controls_table(tmp_path: Path) -> None:
    """By its length as by the tool point; and no word comes into a block in which the tool has just been changed."""
    control = _Control(STRUCTURES["table-table AC"])
    change = f"{ON}G1 X9. C5. F100.\nT2 M6\nG0 A-20. C10.\nG43.4 H2 X1. Y2. Z5.\nG1 X9. C5.\n"
    tables = [CutterTool(3.0, number=1, length_mm=110.0), CutterTool(3.0, number=2, length_mm=80.0)]
    by_table, _ = _compensated(tmp_path, control.model, change, setup=Setup({1: ZERO}, {}, table=tables))
    for tool, length in ((0, 110.0), (1, 80.0)):
        by_point, _ = _compensated(tmp_path, control.model, change, setup=Setup({1: ZERO}, {-1: (0.0, 0.0, -length)}))
        cuts = [[line for line in text.splitlines() if line.startswith("G1")] for text in (by_table, by_point)]
        assert cuts[0][tool] == cuts[1][tool]
    assert "\nG0 A-20. C10.\n" in by_table


def test_numbers_without_a_point_that_count_steps(tmp_path: Path) -> None:
    """A-10000 is -10° where 3401#0 is 0: corrected as A-10. is, and written with a point."""
    model, _ = known_machine(STRUCTURES["table-table AC"], 1.0)
    texts = []
    for text in (f"{ON}G1 X9. C5. F99.\n", f"{ON.replace('A-10.', 'A-10000')}G1 X9000 C5000 F99.\n"):
        written, _ = _compensated(tmp_path, model, text, parameters={"3401#0": 0.0})
        texts.append(written.splitlines()[-2:])
    assert texts[0] == texts[1] and "X9." in texts[0][1]


def test_backlash_by_the_way_by_which_an_axis_comes(tmp_path: Path) -> None:
    """X stands 5 µm further on its way forth and 3 µm less on its way back."""
    model, _ = known_machine(STRUCTURES["table-table AC"], 1.0)
    term = Term(error_name("EXX"), both_ways=True)
    loose = MachineModel(model.machine, (term,), np.array([0.005, -0.003]), np.zeros((2, 2)))
    text = "G21 G90 G54\nG0 A0. C0.\nG43.4 H1 X0. Y0. Z5.\nX10. Z4.\nG1 A-5. F99.\nX4. A-6.\nY5. A-7.\nX5. A-8.\n"
    written, _ = _compensated(tmp_path, loose, text)
    assert [float(x) for x in re.findall(r"X([\d.]+)", written)] == pytest.approx([9.995, 4.003, 4.995], abs=2e-6)


def test_an_angle_said_again_in_a_cut_turns_nothing(tmp_path: Path) -> None:
    """A 3+2 program whose cuts repeat where the tables stand keeps its arcs: X, Y, Z are corrected alone."""
    model, _ = known_machine(STRUCTURES["table-table AC"], 1.0)
    text = "G21 G90 G54\nG0 A-10. C0.\nG0 X0. Y0. Z5.\nG1 X9. A-10.0 C0. F99.\nG3 X19. I5. J0.\n"
    written, _ = _compensated(tmp_path, model, text)
    assert re.findall(r"A[-\d.]+", written) == ["A-10.", "A-10.0"] and "G3 " in written


IN = "G21 G90 G54\nG0 A-10. C0.\n"
ON = f"{IN}G43.4 H1 X0. Y0. Z5.\n"


@pytest.mark.parametrize(
    ("dialect", "text", "code", "words", "line"),
    [
        ("fanuc-mill", f"{IN}G43.5 H1 Z50.\nG1 X5. I0. K1. F100.\n", Code.NC_OPAQUE, r"G43\.5: directions", 3),
        ("fanuc-mill", f"{IN}G43.4 H1 Z50.\nG1 X5. F100.\n", Code.MCH_FRAME, "Y is at a place that is not known", 4),
        ("fanuc-mill", f"{ON}G2 X9. I4.5 J0. F100.\n", Code.NC_MAP, "is not a straight move", 4),
        ("fanuc-mill", f"{ON}G1 G91 X9. F100.\n", Code.NC_MAP, "goes by an increment", 4),
        ("fanuc-mill", f"{ON}G1 A-90. F100.\n", Code.MCH_TRAVEL, "A would go to -", 4),
        ("fanuc-mill", f"{ON}G1 B9. F100.\n", Code.NC_MAP, "which the machine has not", 4),
        (
            "fanuc-mill",
            "G21 G90 G54\nG0 C0.\nG43.4 H1 X0. Y0. Z5.\nG1 X9. F100.\n",
            Code.MCH_FRAME,
            ": A is at a place",
            4,
        ),
        ("fanuc-mill", f"{ON}G1 X90. C60. M8 F9.\n", Code.NC_EDIT, "does more than move", 4),
        ("fanuc-mill", f"{IN}G68.2 X0. Y0. Z0. I1. J2. K3.\nG43.4 H1 X0. Y0. Z5.\n", Code.NC_CODE, r"G68\.2", 3),
        (
            "linuxcnc",
            "G21 G90 G54\nG0 X0 Y0 Z5 A0 C0\nG1 A-9 F100\n",
            Code.MCH_FRAME,
            "places of the tip or of the joints",
            2,
        ),
        ("siemens", "G71 G90 G54\nTRAORI\nG0 X0 Y0 Z5 A3=0 B3=0 C3=1\n", Code.NC_OPAQUE, "A3=0: directions", 3),
        (
            "heidenhain",
            "0 BEGIN PGM A MM\n1 FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\n2 L A+5\n",
            Code.NC_OPAQUE,
            "SPAT",
            2,
        ),
    ],
)
def test_what_is_not_followed_is_refused_by_name(
    tmp_path: Path, dialect: str, text: str, code: Code, words: str, line: int
) -> None:
    model, _ = known_machine(STRUCTURES["table-table AC"], 1.0)
    with pytest.raises(TrueloopError, match=words) as refused:
        _compensated(tmp_path, model, text, dialect)
    assert refused.value.code is code and refused.value.place.line == line
    assert not (tmp_path / "out.nc").exists()
