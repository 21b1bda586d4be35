"""The edges of a part's set-ups in a store: each is kept, learned of and corrected as by a job of that edge alone.

A shaft that is turned at both sides, part after part. The judge is a second store, in which a job of one table [tool],
with the back side drawn by hand in the frame of its program, corrects the same program by the same touches.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.two_sides import FRAMES, PLACES, SECOND, Place, job, second
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.domain.life import Cut, Stage
from trueloop.domain.record import Correction, sha256_of
from trueloop.domain.tool import Edge, Tool
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.opened import store_of
from trueloop.loops.turned.share import reading_in
from trueloop.storage.store import Store, find

NAMES = {"first, T1": "left-hand", "second, T2": "right-hand", "second, T4": "bar"}
EDGE = Edge(Tool(SECOND, NAMES["second, T2"]))
CONTOUR = '[compensation]\nby = "contour"\n[memory]\nunseen_deg = 16.0\n'


@dataclass(frozen=True)
class Way:
    """How the part is held for its second side: Z of its program is `sign` (z + 80)."""

    frame: str
    sign: float
    start: tuple[float, float]
    features: Sequence[tuple[str, tuple[float, float], bool]]
    """What T2 cuts in the program's frame, material on the right: name, end, whether it is the edge of R 2."""

    def z_mm(self, part_z_mm: float) -> float:
        return self.sign * (part_z_mm + 80.0)


FLIPPED = Way(FRAMES["second"], -1.0, (26.0, -30.0), (
    ("back-step", (19.0, -30.0), False), ("back-seat", (19.0, -2.0), False), ("edge", (17.0, 0.0), True),
    ("back", (11.0, 0.0), False),
))  # fmt: skip
TAKEN_OVER = Way("zero_at_z_mm = -80.0", 1.0, (11.0, 0.0), (
    ("back", (17.0, 0.0), False), ("edge", (19.0, 2.0), True), ("back-seat", (19.0, 30.0), False),
    ("back-step", (26.0, 30.0), False),
))  # fmt: skip
WAYS = {"flipped": FLIPPED, "taken over": TAKEN_OVER}


def errors_um(part: int, left: float = 1.0) -> list[float]:
    """By the angle of the normal, which stays; a level that drifts from part to part; and noise."""
    rng = np.random.default_rng([part, int(100 * left)])
    form = [
        8.0 * abs(p.normal[0] * p.normal[1]) + (3.0 + 1.0 * part) * abs(p.normal[0]) + 3.0 * abs(p.normal[1])
        for p in PLACES
    ]
    return [left * one + float(rng.normal(0.0, 0.4)) for one in form]


def with_names(path: Path, names: Mapping[str, str] = NAMES) -> Path:
    """The job beside a store, its tools named, its programs those of the semi-finish cuts too."""
    text = path.read_text()
    for of, name in names.items():
        number = of.rpartition("T")[2]
        text = text.replace(f"number = {number}\n", f'number = {number}\nname = "{name}"\n')
    for name in ("first", "second"):
        text = text.replace(f'finish = "{name}.ngc"\n', f'finish = "{name}.ngc"\nsemifinish = "semi-{name}.ngc"\n')
        (path.parent / f"semi-{name}.ngc").write_bytes((path.parent / f"{name}.ngc").read_bytes())
    path.write_text(text)
    if not (path.parent / "trueloop.db").exists():
        run("db", "init", path.parent / "trueloop.db")
    return path


def placed(folder: Path, way: Way = FLIPPED, part: int = 1, names: Mapping[str, str] = NAMES, more: str = "") -> Path:
    """A job of both sides, touched."""
    folder.mkdir(exist_ok=True)
    (folder / "second.ngc").write_text(second("linuxcnc", sign=-way.sign))
    frames = {**FRAMES, "second": way.frame}
    return with_names(job(folder, errors_um(part), more + CONTOUR, frames=frames), names)


def alone(folder: Path, way: Way) -> Path:
    """A job of T2 alone, all of it in the frame of its program."""
    folder.mkdir()
    for name in ("second", "semi"):
        (folder / f"{name}.ngc").write_text(second("linuxcnc", sign=-way.sign))
    features = ",\n".join(
        f'{{ name = "{name}", to = {list(to)}{", radius = 2.0" if edge else ""} }}' for name, to, edge in way.features
    )
    (folder / "job.toml").write_text(
        f'[part]\nname = "back side"\nside = "around"\nstart = {list(way.start)}\nfeature = [\n{features}\n]\n'
        f'[tool]\nnumber = {SECOND}\nnose_radius_mm = 0.8\nname = "{EDGE.tool.name}"\n'
        '[programs]\ndialect = "linuxcnc"\nfinish = "second.ngc"\nsemifinish = "semi.ngc"\n'
        f'[gauging]\ntouches = "touches.csv"\n{CONTOUR}'
    )
    run("db", "init", folder / "trueloop.db")
    return folder / "job.toml"


def touches(errors: Sequence[float], way: Way | None, keep: Sequence[Place] = PLACES) -> str:
    """Rows of these places; `way`: of T2 alone, in its program's frame, else of all, in the part's."""
    rows = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for k, (p, error) in list(enumerate(zip(PLACES, errors, strict=True), 1))[:: 1 if way is None else int(way.sign)]:
        if p in keep and (way is None or p.tool == SECOND):
            rows.append(f"{k},{p.feature},{p.x_mm:.9f},{p.z_mm if way is None else way.z_mm(p.z_mm):.9f},{error:.6f}")
    return "\n".join([*rows, ""])


def make_parts(
    path: Path, way: Way | None, parts: Sequence[int], errors: Callable[..., list[float]] = errors_um
) -> None:
    """Parts touched, corrected, cut and inspected, one after the other."""
    ran = "corrected-second.ngc" if way is None else "corrected.ngc"
    for part in parts:
        (path.parent / "touches.csv").write_text(touches(errors(part), way))
        run("compensate", path, "--serial", f"P{part}", "-o", path.parent / "out")
        (path.parent / "after.csv").write_text(touches(errors(part, 0.1), way))
        run("measure", "read", path.parent / "after.csv", "--job", path, "--after", "finish", "--serial", f"P{part}",
            "--program", path.parent / "out" / ran)  # fmt: skip


def store(path: Path) -> Store:
    found = store_of(path.parent, None, None)
    assert found is not None
    return found


@pytest.fixture(scope="module", params=WAYS)
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Way, Path, Path]:
    """Three parts in two stores: of both set-ups, and of T2 by itself."""
    folder, way = tmp_path_factory.mktemp("stores"), WAYS[request.param]
    whole, single = placed(folder / "whole", way), alone(folder / "single", way)
    make_parts(whole, None, (1, 2, 3))
    make_parts(single, way, (1, 2, 3))
    return way, whole, single


def test_an_edge_learns_what_a_job_of_it_alone_teaches(both: tuple[Way, Path, Path]) -> None:
    """The same S, F and C of every part, by contact angle as its own machine has it."""
    _, whole, single = both
    mine, theirs = history_of(store(whole), EDGE), history_of(store(single), EDGE)
    assert [part.serial for part in mine] == ["P1", "P2", "P3"] == [part.serial for part in theirs]
    for one, other in zip(mine, theirs, strict=True):
        assert one.part_type == "two sides, second, T2"
        assert one.finish is not None and other.finish is not None and len(one.finish.error_mm) == 15
        for a, b in ((one.semifinish, other.semifinish), (one.finish, other.finish)):
            assert (a.feature, a.point) == (b.feature, b.point)
            np.testing.assert_allclose(a.contact_angle_rad, b.contact_angle_rad, atol=1e-7)
            np.testing.assert_allclose(a.error_mm, b.error_mm, atol=1e-12)
        assert one.correction_mm is not None and other.correction_mm is not None
        np.testing.assert_allclose(one.correction_mm, other.correction_mm, atol=1e-7)
        assert np.max(np.abs(one.correction_mm)) > 0.005


def test_the_next_part_is_corrected_alike(both: tuple[Way, Path, Path], capfd: pytest.CaptureFixture[str]) -> None:
    """From two touches of the arc and memory: the words that a job of that edge alone writes. T1 cuts no arc: memory of
    it holds nothing, which no library complains of.
    """
    words = []
    seen = [p for p in PLACES if p.feature != "edge" or p in [q for q in PLACES if q.feature == "edge"][1::2]]
    for path, way in ((both[1], None), (both[2], both[0])):
        (path.parent / "touches.csv").write_text(touches(errors_um(4), way, seen))
        said = run("compensate", path, "--serial", "P4", "-o", path.parent / "next", "--supersede")
        assert "earlier parts" in said or "memory" in said
        (record,) = [
            one.value.record for one in find(store(path), Correction, serial="P4")
            if one.value.record.tool is not None and one.value.record.tool.number == SECOND
        ]  # fmt: skip
        words.append([(word.before, word.after) for word in record.changes])
        (path.parent / "touches.csv").write_text(touches(errors_um(4), way, seen))
        without = path.parent / "without"
        run("compensate", path, "--serial", "P4", "-o", without, "--no-store")
        name = "corrected-second.ngc" if way is None else "corrected.ngc"
        assert _moves(without / name) != _moves(path.parent / "next" / name)
    assert words[0] == words[1] and words[0]
    assert capfd.readouterr() == ("", "")


def _moves(file: Path) -> list[str]:
    return [line for line in file.read_text().splitlines() if line.startswith("G0")]


def test_every_share_is_in_the_frame_of_its_program(both: tuple[Way, Path, Path]) -> None:
    """By hand: the back face, z −80, is Z 0; the front face stays at 0, the seat at z −26 at Z −26."""
    way, whole, _ = both
    found = {}
    for serial in ("P1", "P2", "P3"):
        for one in find(store(whole), Inspection, serial=serial):
            points = [touch for touch in one.value.values if isinstance(touch, Touch)]
            found[one.value.part.part_type.name] = {touch.point: touch for touch in points}
    assert set(found) == {f"two sides, {name}" for name in NAMES}
    assert sum(map(len, found.values())) == len(PLACES)
    for k, p in enumerate(PLACES, 1):
        setup = "first" if p.tool == 1 else "second"
        touch = found[f"two sides, {setup}, T{p.tool}"][str(k)]
        z = p.z_mm if p.tool == 1 else way.z_mm(p.z_mm)
        assert touch.nominal_mm == pytest.approx((p.x_mm, z), abs=1e-6) and touch.feature == p.feature


def test_the_views_of_the_store_have_each_edge_by_its_set_up(both: tuple[Way, Path, Path]) -> None:
    db = both[1].parent / "trueloop.db"
    listed = run("db", "find", "part", "--db", db)
    assert all(f"two sides, {name}" in listed for name in NAMES)
    life = run("db", "show", "two sides, second, T2/P2", "--db", db)
    assert "edge right-hand" in life and "inspected: 15 touches" in life
    several = run("db", "show", "P2", "--db", db, status=3)
    assert "STO-SEVERAL" in several and "two sides, first, T1/P2" in several


def test_a_program_is_of_its_own_set_up(tmp_path: Path) -> None:
    """The second one ran as it was given, which is said by its text; the first then as corrected, which it says."""
    path = placed(tmp_path)
    run("compensate", path, "--serial", "P1", "-o", tmp_path / "out")
    (tmp_path / "after.csv").write_text(touches(errors_um(1, 0.9), None))
    call = ("measure", "read", tmp_path / "after.csv", "--job", path, "--after", "finish", "--serial", "P1")
    (tmp_path / "none.ngc").write_text("G21\nM2\n")
    assert "STO-LINK" in run(*call, "--program", tmp_path / "none.ngc", status=3)
    run(*call, "--program", tmp_path / "second.ngc")
    for name in NAMES:
        of = f"two sides, {name}"
        (made,) = find(store(path), Correction, part_type=of)
        (cut,) = find(store(path), Cut, part_type=of, stage=Stage.FINISH)
        given = tmp_path / ("out/corrected-first.ngc" if name == "first, T1" else "second.ngc")
        assert cut.value.program_sha256 == sha256_of(given.read_bytes())
        assert cut.value.correction == (made.value.record.id if name == "first, T1" else "")


def test_a_record_is_of_its_own_edge(tmp_path: Path) -> None:
    path = placed(tmp_path)
    run("compensate", path, "--serial", "P1", "-o", tmp_path / "out")
    (tmp_path / "after.csv").write_text(touches(errors_um(1, 0.1), None))
    record = find(store(path), Correction, part_type="two sides, second, T2")[0].value.record.id
    call = ("measure", "read", tmp_path / "after.csv", "--job", path, "--after", "finish", "--serial", "P1")
    assert "STO-LINK" in run(*call, "--record", "0000", status=3)
    run(*call, "--record", record)
    assert len(history_of(store(path), Edge(Tool(4, "bar")))) == len(history_of(store(path), EDGE)) == 1


def test_calling_it_again_keeps_nothing_twice(tmp_path: Path) -> None:
    path = placed(tmp_path)
    run("compensate", path, "--serial", "P1", "-o", tmp_path / "out")
    said = run("compensate", path, "--serial", "P1", "-o", tmp_path / "again")
    assert "all of it is kept already" in said
    assert len(find(store(path), Correction)) == 3


@pytest.mark.parametrize("why", ["too much", "first", "second", "no serial"])
def test_where_one_set_up_is_refused_nothing_of_any_is_kept(tmp_path: Path, why: str) -> None:
    """One bore 400 µm out; a program that is corrected already; a part without a serial number."""
    path = placed(tmp_path)
    if why in ("first", "second"):
        run("compensate", path, "--no-store", "-o", tmp_path / "out")
        (tmp_path / f"{why}.ngc").write_bytes((tmp_path / "out" / f"corrected-{why}.ngc").read_bytes())
    if why == "too much":
        wrong = [e + 400.0 * (p.feature == "bore") for e, p in zip(errors_um(1), PLACES, strict=True)]
        (tmp_path / "touches.csv").write_text(touches(wrong, None))
    chosen = ["--db", tmp_path / "trueloop.db"] if why == "no serial" else ["--serial", "P1"]
    said = run("compensate", path, *chosen, "-o", tmp_path / "now", status=3)
    assert {"first": "CMP-TWICE", "second": "CMP-TWICE", "no serial": "STO-PART"}.get(why, "") in said
    assert not (tmp_path / "now").exists()
    assert not find(store(path), Correction) and not find(store(path), Inspection)


def test_the_whole_part_is_answered_for_by_its_serial_number(tmp_path: Path) -> None:
    """Sheet and plan are of the whole part, one certificate of what all edges cut; each edge's share is diagnosed."""
    path = placed(tmp_path)
    make_parts(path, None, (1, 2))
    sizes = {"seat": 36.0, "back-seat": 38.0, "bore": 20.0}
    rows = "".join(f"D {of},{of},{d + 0.004},{d},{d - 0.05},{d + 0.05}\n" for of, d in sizes.items())
    header = "characteristic,feature,diameter_mm,nominal,lower_limit,upper_limit\n"
    (tmp_path / "sizes.csv").write_text(f"# uncertainty_um: 1\n# instrument: micrometer 4\n{header}{rows}")
    run("measure", "read", tmp_path / "sizes.csv", "--job", path, "--after", "finish", "--serial", "P2")
    assert all(f"{of}," in run("measure", "sheet", path) for of in sizes)
    assert all(of in run("measure", "plan", path) for of in sizes)
    db = ("--db", tmp_path / "trueloop.db")
    certificate = json.loads(run("monitor", "certify", "P2", "-o", tmp_path / "c", "--json", *db))
    assert certificate["part_type"] == "two sides"
    assert {one["characteristic"]: one["verdict"] for one in certificate["characteristics"]} == {
        f"D {of}": "in" for of in sizes
    }
    edges = {one["identity"] for one in certificate["in_force"] if one["what"] == "edge"}
    assert {name for name in NAMES.values() if any(name in edge for edge in edges)} == {*NAMES.values()}
    types = {f"two sides, {of}" for of in NAMES}
    of_part, of_series = (json.loads(run("diagnose", *what, "--json", *db)) for what in (("part", "P2"), ("series",)))
    assert {one["part_type"] for one in of_part["shares"]} == types == {one["part_type"] for one in of_series["shares"]}
    of_one = json.loads(run("diagnose", "part", "P2", "--type", "two sides, second, T4", "--json", *db))
    assert of_one["part_type"] == "two sides, second, T4"
    with_job = json.loads(run("diagnose", "part", "P2", "--job", path, "--json", *db))
    assert {one["part_type"] for one in with_job["shares"]} == types


def from_front_um(part: int, left: float = 1.0) -> list[float]:
    """The errors as seen from the last touch, which is of the front: by hand, n_z times its error less."""
    found = errors_um(part, left)
    return [error - p.normal[1] * found[-1] for error, p in zip(found, PLACES, strict=True)]


def test_z_from_a_face_of_the_first_set_up_is_that_of_what_the_second_keeps(tmp_path: Path) -> None:
    """What is kept of T2 is as seen from the front, which T1 cuts: touches before and after the finish cut."""
    whole = placed(tmp_path / "whole", more=f'z_reference = "{len(PLACES)}"\n')
    single = alone(tmp_path / "single", FLIPPED)
    make_parts(whole, None, (1, 2))
    make_parts(single, FLIPPED, (1, 2), from_front_um)
    mine, theirs = history_of(store(whole), EDGE), history_of(store(single), EDGE)
    assert len(mine) == 2 and abs(errors_um(1)[-1]) > 2.0
    for one, other in zip(mine, theirs, strict=True):
        assert one.finish is not None and other.finish is not None
        for own, expected in ((one.semifinish, other.semifinish), (one.finish, other.finish)):
            np.testing.assert_allclose(own.error_mm, expected.error_mm, atol=2e-9)


def one_tool(folder: Path, names: Sequence[str], mounted: bool = False) -> Path:
    """T1 cuts both sides, in each table with this name; "" none."""
    folder.mkdir()
    (folder / "second.ngc").write_text(second("linuxcnc", tool=1))
    path = job(folder, errors_um(1), CONTOUR)
    head, middle, tail = path.read_text().replace(f"number = {SECOND}\n", "number = 1\n").split("number = 1\n")
    named = ['number = 1\ninsert = "CNMG"\ncorner = "1"\n' + (f'name = "{name}"\n' if name else "") for name in names]
    bare = ["number = 1\n"] * 2
    one, other = bare if mounted else named
    path.write_text(head + one + middle + other + tail)
    return with_names(path, {})


def test_a_number_alone_does_not_say_that_two_set_ups_have_one_edge(tmp_path: Path) -> None:
    """Named alike it is one edge; named otherwise two; named in one table only, or in none, it is asked for."""
    for k, (names, edges) in enumerate(((("", ""), None), (("a", ""), 2), (("a", "a"), 1), (("a", "b"), 2))):
        path = one_tool(tmp_path / str(k), names)
        status = 3 if edges is None else 0
        said = run("compensate", path, "--serial", "P1", "-o", path.parent / "out", status=status)
        kept = [one.value.record for one in find(store(path), Correction)]
        if edges is None:
            assert "SET-EDGE" in said and "T1" in said and not kept and not (path.parent / "out").exists()
            run("compensate", path, "--no-store", "-o", path.parent / "out")
        else:
            found = {one.edge.identity for one in kept if one.edge is not None and one.edge.insert}
            assert len(found) == edges


def test_a_mounted_tool_is_not_that_of_both_set_ups_by_its_number(tmp_path: Path) -> None:
    path = one_tool(tmp_path / "mounted", ("", ""), mounted=True)
    run("tool", "mount", "1", "--holder", "turning", "--insert", "CNMG", "--corner", "1", "--nose-radius-mm", "0.8",
        "--db", path.parent / "trueloop.db")  # fmt: skip
    assert "SET-EDGE" in run("compensate", path, "--serial", "P1", "-o", path.parent / "out", status=3)
    bare = path.read_text()
    path.write_text(bare.replace("number = 1\n", 'number = 1\nname = "turning"\n', 1))
    assert "SET-EDGE" in run("compensate", path, "--serial", "P1", "-o", path.parent / "out", status=3)
    path.write_text(bare.replace("number = 1\n", 'number = 1\nname = "turning"\n'))
    run("compensate", path, "--serial", "P1", "-o", path.parent / "out")


def test_readings_of_gauges_are_kept_where_the_program_has_them(tmp_path: Path) -> None:
    """By hand: Ø38 at z −64 is at Z −16; 30 from back to back-step is a length of the second side, which has the
    one from side to side, too, for the part's certificate. The next part is corrected beside it.
    """
    path = placed(tmp_path)
    (tmp_path / "readings.csv").write_text("feature,z_mm,diameter_mm\nback-seat,-64,38.004\nback-seat,-70,38.005\n")
    (tmp_path / "lengths.csv").write_text(
        "characteristic,feature,from,length_mm\nL1,back,back-step,30.003\nL2,back,front,80.004\n"
    )
    named = 'touches = "touches.csv"\nreadings = ["readings.csv", "lengths.csv"]\nreadings_u_um = 1.0\n'
    path.write_text(path.read_text().replace('touches = "touches.csv"\n', named))
    run("compensate", path, "--serial", "P1", "-o", tmp_path / "out")
    kept = {
        (kept.value.part.part_type.name, one.feature, one.other, one.actual, one.place_mm)
        for kept in find(store(path), Inspection) for one in kept.value.values if isinstance(one, Reading)
    }  # fmt: skip
    of = "two sides, second, T2"
    assert kept == {
        (of, "back", "back-step", 30.003, ()),
        (of, "back", "front", 80.004, ()),
        (of, "back-seat", "", 38.004, (-16.0,)),
        (of, "back-seat", "", 38.005, (-10.0,)),
    }
    for name in ("touches.csv", "readings.csv", "lengths.csv"):
        (tmp_path / name).write_text((tmp_path / name).read_text() + "\n")  # files of their own
    run("compensate", path, "--serial", "P2", "-o", tmp_path / "next")


def test_a_length_from_the_parts_zero_is_of_a_program_that_has_the_same_zero() -> None:
    read = Reading("L", Quantity.LENGTH, 50.002, place_mm=(-50.0,))
    far, near = SetupFrame("far", -80.0, flipped=True), SetupFrame("near", flipped=True)
    assert reading_in(far, read, "") is None and reading_in(far, read, "back") == replace(read, place_mm=(-30.0,))
    assert reading_in(near, read, "") == replace(read, place_mm=(50.0,))
    diameter = replace(read, quantity=Quantity.DIAMETER, place_mm=(19.0, -50.0))
    assert reading_in(far, diameter, "") == replace(diameter, place_mm=(19.0, -30.0))
