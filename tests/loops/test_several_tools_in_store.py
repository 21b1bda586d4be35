"""Several edges of a part in a store: each is kept, learned of and corrected as by a job of that edge alone.

A plug with a dome that an OD tool turns and a bell mouth that a boring bar turns, part after part. The judge is a
second store, in which jobs with one table [tool] correct the same program by the same touches of what that tool cuts.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.turned_by_hand import Piece, drawn
from trueloop.domain.inspection import Inspection
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.opened import store_of
from trueloop.storage.store import Store, find

OD, BAR = (1, 1), (2, 1)
NOSE_MM = {OD: 0.8, BAR: 0.4}
EDGES = {OD: Edge(Tool(1, "turning"), "CNMG", "1"), BAR: Edge(Tool(2, "bar"), "CCMT", "1")}
PROGRAM = """\
G21 G18 G7 G40 G90 G95
G97 S800 M3
T1 M6 G43 H1
G00 X32.0000 Z5.0000
G01 X32.0000 Z0.8000 F0.1
G01 X40.0000 Z0.8000
G03 X61.6000 Z-10.0000 I0.0000 K-10.8000
G01 X61.6000 Z-40.0000
G00 X80.0000 Z-40.0000
G00 X80.0000 Z20.0000
T2 M6 G43 H2
G00 X36.0000 Z5.0000
G01 X36.0000 Z0.4000 F0.08
G02 X29.2000 Z-3.0000 I0.0000 K-3.4000
G01 X29.2000 Z-40.0000
G00 X26.0000 Z-40.0000
G00 X26.0000 Z20.0000
M2
"""
PROFILE = drawn(
    (30.0, -40.0),
    ("od", (30.0, -10.0), OD),
    ("dome", (20.0, 0.0), (20.0, -10.0), OD),
    ("face", (18.0, 0.0), OD),
    ("mouth", (15.0, -3.0), (18.0, -3.0), BAR),
    ("bore", (15.0, -40.0), BAR),
)
TOUCHES = {"od": 3, "dome": 12, "face": 3, "mouth": 9, "bore": 3}
Errors = Mapping[str, Sequence[float]]


def errors_um(part: int, left: float = 1.0) -> Errors:
    """An edge's form by the angle of its normal, which stays; a level that drifts from part to part; and noise."""
    rng = np.random.default_rng([part, int(100 * left)])
    found = {}
    for piece in PROFILE:
        normals = [piece.at((k + 0.5) / TOUCHES[piece.name])[1] for k in range(TOUCHES[piece.name])]
        form = [
            12.0 * abs(n[0] * n[1]) + (8.0 + 1.5 * part) * n[0] * (1 if piece.edge == OD else -0.5) for n in normals
        ]
        found[piece.name] = (left * np.array(form) + rng.normal(0.0, 0.4, len(form))).tolist()
    return found


def rows_of(errors: Errors, pieces: Sequence[Piece]) -> str:
    rows = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for piece in pieces:
        for k, error in enumerate(errors[piece.name]):
            (x, z), _ = piece.at((k + 0.5) / len(errors[piece.name]))
            rows.append(f"{piece.name}-{k},{piece.name},{x:.9f},{z:.9f},{error:.6f}")
    return "\n".join([*rows, ""])


def place(folder: Path, pieces: Sequence[Piece]) -> Path:
    """A job of the edges that cut these pieces, beside a store: one table [tool], or two [[tools]]."""
    folder.mkdir()
    keys = list(dict.fromkeys(piece.edge for piece in pieces))
    for name in ("finish", "semifinish"):
        (folder / f"{name}.ngc").write_text(PROGRAM)
    tools = "".join(
        f"{'[[tools]]' if len(keys) > 1 else '[tool]'}\nnumber = {key[0]}\nnose_radius_mm = {NOSE_MM[key]}\n"
        f'name = "{EDGES[key].tool.name}"\ninsert = "{EDGES[key].insert}"\ncorner = "1"\n'
        for key in keys if key is not None
    )  # fmt: skip
    features = "\n".join(piece.toml for piece in pieces)
    (folder / "job.toml").write_text(
        f'[part]\nname = "plug"\nside = "around"\nstart = {list(pieces[0].start)}\nfeature = [\n{features}\n]\n{tools}'
        '[programs]\ndialect = "linuxcnc"\nfinish = "finish.ngc"\nsemifinish = "semifinish.ngc"\n'
        '[gauging]\ntouches = "touches.csv"\n[compensation]\nby = "contour"\n'
    )
    run("db", "init", folder / "trueloop.db")
    return folder / "job.toml"


def make_parts(job: Path, pieces: Sequence[Piece], parts: Sequence[int], finish: bool = True) -> str:
    """Parts touched, corrected, cut and inspected, one after the other; what correcting the last one said."""
    said = ""
    for part in parts:
        (job.parent / "touches.csv").write_text(rows_of(errors_um(part), pieces))
        said = run("compensate", job, "--serial", f"P{part}", "-o", job.parent / "out")
        if finish:
            (job.parent / "after.csv").write_text(rows_of(errors_um(part, 0.1), pieces))
            run("measure", "read", job.parent / "after.csv", "--job", job, "--after", "finish", "--serial", f"P{part}",
                "--program", job.parent / "out" / "corrected.ngc")  # fmt: skip
    return said


def store(job: Path) -> Store:
    found = store_of(job.parent, None, None)
    assert found is not None
    return found


def of_edge(key: tuple[int, int]) -> list[Piece]:
    return [piece for piece in PROFILE if piece.edge == key]


@pytest.fixture(scope="module")
def jobs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Three parts in three stores: of both edges, and of each by itself."""
    folder = tmp_path_factory.mktemp("stores")
    made = {"both": place(folder / "both", PROFILE)}
    made |= {str(key[0]): place(folder / str(key[0]), of_edge(key)) for key in EDGES}
    for name, job in made.items():
        make_parts(job, PROFILE if name == "both" else of_edge((int(name), 1)), (1, 2, 3))
    return made


@pytest.mark.parametrize("key", EDGES)
def test_an_edge_learns_what_a_job_of_it_alone_teaches(jobs: dict[str, Path], key: tuple[int, int]) -> None:
    """The same S, F and C of every part, by place."""
    both, alone = (history_of(store(jobs[name]), EDGES[key]) for name in ("both", str(key[0])))
    assert [part.serial for part in both] == ["P1", "P2", "P3"] == [part.serial for part in alone]
    for one, other in zip(both, alone, strict=True):
        assert one.finish is not None and other.finish is not None and len(one.finish.error_mm) > 5
        for mine, theirs in ((one.semifinish, other.semifinish), (one.finish, other.finish)):
            assert mine.feature == theirs.feature
            np.testing.assert_allclose(mine.contact_angle_rad, theirs.contact_angle_rad, atol=1e-9)
            np.testing.assert_allclose(mine.error_mm, theirs.error_mm, atol=1e-12)
        assert one.correction_mm is not None and other.correction_mm is not None
        np.testing.assert_allclose(one.correction_mm, other.correction_mm, atol=1e-7)
        assert one.part_type == f"plug, T{key[0]}"


@pytest.mark.parametrize("key", EDGES)
def test_the_next_part_is_corrected_alike(jobs: dict[str, Path], key: tuple[int, int]) -> None:
    """From three touches of the arc and memory: the words that a job of that edge alone writes."""
    words = []
    for name in ("both", str(key[0])):
        job = jobs[name]
        pieces = PROFILE if name == "both" else of_edge(key)
        few = {name: (e[1::4] if name in ("dome", "mouth") else e) for name, e in errors_um(4).items()}
        rows = rows_of(errors_um(4), pieces).splitlines()
        kept = [r for r in rows if r.startswith("point") or r.split(",")[0] in _points(few)]
        (job.parent / "touches.csv").write_text("\n".join([*kept, ""]))
        said = " ".join(
            run(
                "compensate", job, "--serial", "P4", "-o", job.parent / "next", "--db", job.parent / "trueloop.db"
            ).split()
        )
        assert "earlier parts" in said or "memory" in said
        record = [
            one.value.record for one in find(store(job), Correction)
            if one.value.record.inspections[0].part.serial == "P4" and one.value.record.tool is not None
            and one.value.record.tool.number == key[0]
        ][-1]  # fmt: skip
        words.append([(word.before, word.after) for word in record.changes])
    assert words[0] == words[1] and words[0]


def _points(few: Errors) -> set[str]:
    return {
        f"{name}-{k}"
        for name, errors in few.items()
        for k in (range(1, TOUCHES[name], 4) if name in ("dome", "mouth") else range(len(errors)))
    }


def test_calling_it_again_keeps_nothing_twice(jobs: dict[str, Path]) -> None:
    job = jobs["both"]
    (job.parent / "touches.csv").write_text(rows_of(errors_um(1), PROFILE))
    said = run("compensate", job, "--serial", "P1", "-o", job.parent / "again")
    assert "all of it is kept already" in said
    assert len({one.value.record.id for one in find(store(job), Correction, serial="P1")}) == 2


def test_corrected_twice_is_refused_and_nothing_is_kept(jobs: dict[str, Path], tmp_path: Path) -> None:
    job = place(tmp_path / "twice", PROFILE)
    make_parts(job, PROFILE, (1,), finish=False)
    (job.parent / "finish.ngc").write_bytes((job.parent / "out" / "corrected.ngc").read_bytes())
    before = len(find(store(job), Correction))
    assert "CMP-TWICE" in run("compensate", job, "--serial", "P2", "-o", tmp_path / "out", status=3)
    assert len(find(store(job), Correction)) == before == 2


def test_z_from_a_face_of_one_edge_is_that_of_what_the_other_keeps(tmp_path: Path) -> None:
    """By hand: a face that stands 4 µm proud is where z counts from, so that the mouth's errors fall by 4 n_z."""
    job = place(tmp_path / "z", PROFILE)
    job.write_text(job.read_text().replace("[gauging]\n", '[gauging]\nz_reference = "face-1"\n'))
    errors = {**errors_um(1), "face": [4.1, 4.0, 3.9]}
    (job.parent / "touches.csv").write_text(rows_of(errors, PROFILE))
    run("compensate", job, "--serial", "P1", "-o", tmp_path / "out")
    kept = {one.value.part.part_type.name: one.value for one in find(store(job), Inspection, serial="P1")}
    turned, bored = kept["plug, T1"], kept["plug, T2"]
    assert (turned.z_reference, bored.z_reference) == ("face-1", None)
    (mouth,) = (piece for piece in PROFILE if piece.name == "mouth")
    normals = [mouth.at((k + 0.5) / TOUCHES["mouth"])[1] for k in range(TOUCHES["mouth"])]
    expected = [e - 4.0 * n[1] for e, n in zip(errors["mouth"], normals, strict=True)]
    found = [1e3 * (touch.error_mm or 0.0) for touch in bored.touches if touch.feature == "mouth"]
    assert found == pytest.approx(expected, abs=1e-6) and max(abs(n[1]) for n in normals) > 0.9
    as_touched = [1e3 * (touch.error_mm or 0.0) for touch in turned.touches if touch.feature == "face"]
    assert as_touched == pytest.approx(errors["face"])
