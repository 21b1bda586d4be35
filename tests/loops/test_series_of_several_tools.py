"""Sizes of ten finished parts that three edges cut: each edge gets the offset that its own sizes ask for.

LinuxCNC's interpreter says where the program sends each edge, the model of `grooved` what edges that are set wrong
leave, and the sizes follow by hand: a diameter grows by 2 e, a length from z = 0 by −e on a face that looks to z+.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.loops import test_setups
from tests.loops.test_several_tools import SET_OFF, touched
from tests.support import two_sides
from tests.support.cli import run
from tests.support.grooved import LEFT, OD, PLACES, RIGHT, Control, Cutting, job
from trueloop.arrays import Array
from trueloop.domain.proposal import Proposal, ToolOffset
from trueloop.jobs.store.opened import store_of
from trueloop.storage.store import find

SIZES = {
    "seat": ("diameter", 36.0, 2.0), "mid": ("diameter", 50.0, 2.0), "step": ("length", 20.0, -1.0),
    "floor-left": ("diameter", 40.0, 2.0), "left-wall": ("length", 40.0, -1.0),
    "floor-right": ("diameter", 40.0, 2.0), "right-wall": ("length", 34.0, 1.0),
}  # fmt: skip
"""By feature: quantity, nominal, and by how much it grows with an error along the normal."""
EDGE_OF = {place.feature: place.edge for place in PLACES}


def rows(errors_um: Array, serial: int, rng: np.random.Generator) -> list[str]:
    """Sizes of one part, one of them between faces of two edges."""
    error_mm = {name: 1e-3 * np.mean([e for e, p in zip(errors_um, PLACES, strict=True) if p.feature == name])
                for name in SIZES}  # fmt: skip
    found = [
        f"grooved,{serial},{name},{name},{quantity},mm,{nominal},"
        f"{nominal + gain * error_mm[name] + rng.normal(0.0, 0.0006):.5f}"
        for name, (quantity, nominal, gain) in SIZES.items()
    ]
    between = 20.0 + error_mm["step"] - error_mm["left-wall"]
    return [*found, f"grooved,{serial},land,,length,mm,20.0,{between:.5f}"]


def inspected(folder: Path, cuttings: Mapping[int, Cutting], serials: range) -> Path:
    errors_um, rng = touched(folder, cuttings), np.random.default_rng(serials.start)
    head = "part name,serial,characteristic,feature,quantity,unit,nominal,actual"
    lines = [line for serial in serials for line in rows(errors_um, serial, rng)]
    file = folder / f"from-{serials.start}.csv"
    file.write_text("\n".join([head, *lines, ""]))
    return file


LAND = (
    '[[part.characteristic]]\nname = "land"\nquantity = "length"\nfeature = "step"\nother = "left-wall"\n'
    'tolerance = "±0.05"\n'
)
"""Which no single edge can mend."""


def proposals(folder: Path, control: Control = "linuxcnc") -> list[Proposal]:
    """What is proposed with the job of all three edges, by tool and edge."""
    path = job(folder, [0.0] * len(PLACES), control, LAND)
    (folder / "touches.csv").unlink()  # they need not exist
    run("series", "propose", "--job", path, "--db", folder / "x.db")
    store = store_of(folder, str(folder / "x.db"), None)
    assert store is not None
    found = [kept.value for kept in find(store, Proposal) if kept.value.tool_offset is not None]
    return sorted(found, key=called)


def called(one: Proposal) -> tuple[int, int]:
    """The tool and its edge."""
    assert one.tool_offset is not None
    return one.tool_offset.tool, one.tool_offset.held.edge


def ten_parts(folder: Path) -> None:
    run("db", "init", folder / "x.db")
    run("series", "add", inspected(folder, SET_OFF, range(101, 111)), "--db", folder / "x.db")


def test_each_edge_gets_what_its_own_sizes_ask_for(tmp_path: Path) -> None:
    """About two thirds of −o at first, as no part confirms a correction yet; entered, a third of the error is left."""
    ten_parts(tmp_path)
    entered = {}
    for one, tool in zip(proposals(tmp_path), (OD, LEFT, RIGHT), strict=True):
        offset = one.tool_offset
        assert offset is not None and offset.tool == tool
        assert {EDGE_OF[name] for name in one.characteristics} == {tool}, "of its own features alone"
        (off_x, off_z) = SET_OFF[tool].off_mm
        assert 0.55 < -offset.x_radius_mm / off_x < 0.8 and 0.5 < -offset.z_mm / off_z < 0.85
        entered[tool] = Cutting((off_x + offset.x_radius_mm, off_z + offset.z_mm))
        run("series", "accept", one.id, "--who", "K. Roth", "--why", "ten parts agree", "--db", tmp_path / "x.db")
    before, after = (np.abs(touched(tmp_path, cuttings)) for cuttings in (SET_OFF, entered))
    large = before > 2.0
    assert np.all(after[large] < 0.5 * before[large])


def test_two_edges_of_one_tool_number_are_two_offsets(tmp_path: Path) -> None:
    """On a Sinumerik both corners are T5, D1 and D2."""
    ten_parts(tmp_path)
    found = {called(one): one for one in proposals(tmp_path, "siemens")}
    assert set(found) == {(OD, 1), (LEFT, 1), (LEFT, 2)}
    for key, tool in {(LEFT, 1): LEFT, (LEFT, 2): RIGHT}.items():
        assert {EDGE_OF[name] for name in found[key].characteristics} == {tool}
        offset = found[key].tool_offset
        assert offset is not None and offset.x_radius_mm * SET_OFF[tool].off_mm[0] < 0.0
        assert offset.z_mm * SET_OFF[tool].off_mm[1] < 0.0


def test_moves_of_another_edge_are_none_of_an_edges_own(tmp_path: Path) -> None:
    """The right corner passes over the left half of the floor too, which the job decides to be the left one's."""
    ten_parts(tmp_path)
    path = job(tmp_path, [0.0] * len(PLACES), "linuxcnc", LAND + f"[feature.floor-left]\ntool = {LEFT}\n")
    before, after = (tmp_path / "finish.ngc").read_text().rsplit("G01 X40.4000 Z-37.0000", 1)
    (tmp_path / "finish.ngc").write_text(f"{before}G01 X40.4000 Z-39.8000{after}")
    said = run("series", "propose", "--job", path, "--db", tmp_path / "x.db")
    left = said[: said.index("tool 5: wear")].rpartition("\n\n")[2]
    assert "floor-left: size" in left and "left-wall: size" in left and "right" not in left


OF_SIDES = {
    "seat": ("diameter", 36.0, 2.0), "collar": ("diameter", 52.0, 2.0), "step": ("length", 30.0, -1.0),
    "back-seat": ("diameter", 38.0, 2.0), "back-step": ("length", 50.0, 1.0), "back": ("length", 80.0, 1.0),
    "bore": ("diameter", 20.0, -2.0),
}  # fmt: skip
"""Of the shaft of two set-ups, as `SIZES`: what the second cuts looks to z− of the part."""


def of_sides(folder: Path, cuttings: Mapping[int, Cutting]) -> None:
    """Ten finished parts in a store."""
    errors_um, rng = test_setups.touched(folder, cuttings), np.random.default_rng(5)
    lines = ["part name,serial,characteristic,feature,quantity,unit,nominal,actual"]
    for serial in range(101, 111):
        for name, (quantity, nominal, gain) in OF_SIDES.items():
            error_mm = 1e-3 * np.mean(
                [e for e, p in zip(errors_um, two_sides.PLACES, strict=True) if p.feature == name]
            )
            actual = nominal + gain * error_mm + rng.normal(0.0, 0.0006)
            lines.append(f"two sides,{serial},{name},{name},{quantity},mm,{nominal},{actual:.5f}")
    (folder / "sides.csv").write_text("\n".join([*lines, ""]))
    run("db", "init", folder / "x.db")
    run("series", "add", folder / "sides.csv", "--db", folder / "x.db")


def offsets_of_sides(folder: Path, path: Path) -> dict[int, ToolOffset]:
    run("series", "propose", "--job", path, "--db", folder / "x.db")
    store = store_of(folder, str(folder / "x.db"), None)
    assert store is not None
    found = [kept.value.tool_offset for kept in find(store, Proposal)]
    return {one.tool: one for one in found if one is not None}


def test_each_tool_of_two_set_ups_gets_what_its_sizes_ask_for(tmp_path: Path) -> None:
    """About two thirds of −o, Z as the program of the set-up has it, of a part that is turned round there.

    The first tool cuts the face at z = 0 as well, from which its only length counts: no offset of it changes that.
    """
    of_sides(tmp_path, test_setups.SET_OFF)
    found = offsets_of_sides(tmp_path, two_sides.job(tmp_path, [0.0] * len(two_sides.PLACES)))
    assert set(found) == {two_sides.FIRST, two_sides.SECOND, two_sides.BORE}
    for tool, offset in found.items():
        off_x, off_z = test_setups.SET_OFF[tool].off_mm
        assert 0.55 < -offset.x_radius_mm / off_x < 0.8
        assert offset.z_mm == 0.0 if tool != two_sides.SECOND else 0.5 < -offset.z_mm / off_z < 0.85


def test_one_offset_of_one_machine_is_proposed_from_the_sizes_of_both_set_ups(tmp_path: Path) -> None:
    """T1 cuts both sides, off by the same on both: one offset, by hand −o; on two machines there are two."""
    off = Cutting((0.010, 0.006))
    of_sides(tmp_path, {**test_setups.SET_OFF, two_sides.FIRST: off, two_sides.SECOND: off})
    (tmp_path / "second.ngc").write_text(two_sides.second("linuxcnc", tool=1))
    path = two_sides.job(tmp_path, [0.0] * len(two_sides.PLACES))
    text = path.read_text().replace(f"number = {two_sides.SECOND}\n", "number = 1\n")
    path.write_text(text)
    said = run("series", "propose", "--job", path, "--db", tmp_path / "x.db")
    assert said.count("tool 1: wear") == 1
    offset = offsets_of_sides(tmp_path, path)[1]
    assert 0.55 < -offset.x_radius_mm / 0.010 < 0.8 and 0.5 < -offset.z_mm / 0.006 < 0.85
    for name in ("first", "second"):
        text = text.replace(f'finish = "{name}.ngc"', f'finish = "{name}.ngc"\nmachine = "{name}"')
    path.write_text(text)
    said = run("series", "propose", "--job", path, "--db", tmp_path / "x.db")
    assert said.count("tool 1: wear") == 2
    path.write_text(path.read_text().replace("flipped = true", "mirrored_z = true"))
    assert "SET-" in run("series", "propose", "--job", path, "--db", tmp_path / "x.db", status=3)
