"""What a gauging run wrote, as LinuxCNC wrote it, corrects the part: from the ball's centres to the cut."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import pytest

from tests.server.test_uploads import PROBE, cut, hand_over
from tests.support.linuxcnc import Tool, interpret
from tests.support.service import Caller, Running, problem
from trueloop.domain.record import ProgramText
from trueloop.factory.tasks import run_task
from trueloop.jobs.factory.runners import RUNNERS
from trueloop.jobs.measure.probing import read_probing
from trueloop.storage.store import find

EXAMPLES = Path(__file__).parents[2] / "src" / "trueloop" / "examples"
FINISH = (EXAMPLES / "linuxcnc" / "finish.ngc").read_bytes()
PROBE_TOML = (
    (EXAMPLES / "loop" / "probe.toml")
    .read_text(encoding="utf-8")
    .replace("1.4946", "1.5")
    .replace("cosine_um = -0.5", "cosine_um = 0.0")
)
"""A probe without errors of its own."""
POINTS = "points = { cone = 4, main-cylinder = 4, main-face = 2, small-cylinder = 3, dome = 6 }\n"
JOB = (
    (EXAMPLES / "loop" / "modbas2.toml")
    .read_text(encoding="utf-8")
    .replace("../linuxcnc/finish.ngc", "finish.ngc")
    .replace("../modbas2/touches.csv", "touches.csv")
    .replace("[gauging]\n", f"[gauging]\n{POINTS}")
)
LEFT_ON_MM = 0.020


def order(ana: Caller, **changes: Any) -> dict[str, Any]:
    """What is planned, of programs that are released."""
    sha = {}
    for name, text in (("semifinish", PROBE.replace(b"probe", b"semi")), ("probe", PROBE), ("finish", FINISH)):
        seen = hand_over(ana, f"{name}.ngc", text)
        ana.post(f"uploads/{seen['sha256']}/program", {"dialect": "linuxcnc"})
        assert ana.post(f"programs/{seen['sha256']}/release", {"why": "ran in"}).status_code == 200
        sha[name] = seen["sha256"]
    kinds = ("semifinish", "probe", "correct", "finish", "remove")
    planned = {
        "part_type": "MODBAS2, 3.52 in, virtual lathe",
        "revision": "",
        "machine": "lathe",
        "new_machine": True,
        "serials": ["1"],
        "blocks": [{"kind": one, "program_sha256": sha.get(one, ""), "corrected": one == "finish"} for one in kinds],
        "job_toml": JOB,
        "probe_toml": PROBE_TOML,
        "conditions": {"temperature_age_s": None, "calibration_age_s": None},
    }
    return planned | changes


def logged(folder: Path) -> bytes:
    """Nine numbers a touch, X a radius: the ball's centre, pushed out along the normal by what was left on."""
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    (folder / "probe.toml").write_text(PROBE_TOML, encoding="utf-8")
    (folder / "finish.ngc").write_bytes(FINISH)
    rows = []
    for touch in read_probing(folder / "job.toml").plan.touches:
        x, z = (at + LEFT_ON_MM * way for at, way in zip(touch.contact_mm, touch.normal, strict=True))
        rows.append(f"{x:.6f} 0.000000 {z:.6f} " + " ".join(["0.000000"] * 6))
    return "\n".join([*rows, ""]).encode()


def test_material_left_on_everywhere_moves_the_finish_cut_into_the_part(service: Running, tmp_path: Path) -> None:
    ana, cell = service.signed_in("engineer"), service.cell()
    assert ana.post("orders", order(ana)).status_code == 201
    cut(service, cell)
    service.clock.turn(minutes=5)
    touches = {"run": cut(service, cell), "name": "touches.txt", "file": b64encode(logged(tmp_path)).decode()}
    assert cell.post("cell/touches", touches).status_code == 200
    task = run_task(service.store, RUNNERS, "worker", service.clock)
    assert task is not None and task.state == "done", task
    assert task.result is not None
    made = task.result["program_sha256"]
    service.clock.turn(minutes=5)
    offer = cell.post("cell/next").json()
    assert (offer["block"]["kind"], offer["run"]["program_sha256"]) == ("finish", made)
    (corrected,) = [one.value.content for one in find(service.store, ProgramText) if one.value.sha256 == made]
    before, after = (_end_of_cylinder_mm(tmp_path, text) for text in (FINISH, corrected))
    assert before == pytest.approx((1.76 + 0.03125) * 25.4, abs=1e-4)  # radius of the cylinder, and the nose's
    assert after - before == pytest.approx(-LEFT_ON_MM, abs=0.002)  # decimals of an inch


def _end_of_cylinder_mm(folder: Path, text: bytes) -> float:
    """X, a radius, as LinuxCNC reads it."""
    file = folder / "program.ngc"
    file.write_bytes(text)
    (line,) = [k for k, block in enumerate(text.splitlines(), 1) if b"(main cylinder)" in block]
    moves = interpret(file, tools=[Tool(1, 0.79375)])
    return [one for one in moves if one.line == line][-1].end_mm[0]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"probe_toml": ""}, "no probe file"),
        ({"job_toml": JOB.replace(POINTS, "")}, "0 places to touch"),
        ({"job_toml": JOB.replace('probe = "probe.toml"\n', "")}, "a probe file is given"),
        ({"job_toml": "gauging = 3"}, "no table"),
        ({"job_toml": "[part"}, "no TOML"),
    ],
)
def test_a_probe_and_a_job_that_do_not_agree_are_refused(service: Running, changes: dict[str, str], said: str) -> None:
    ana = service.signed_in("engineer")
    refused = ana.post("orders", order(ana, **changes))
    assert problem(refused) == "FAC-PLAN" and said in refused.text


def test_a_log_that_is_no_log_holds_the_part(service: Running) -> None:
    ana, cell = service.signed_in("engineer"), service.cell()
    number = ana.post("orders", order(ana)).json()["row"]["id"]
    cut(service, cell)
    service.clock.turn(minutes=5)
    touches = {"run": cut(service, cell), "name": "touches.txt", "file": b64encode(b"X1 Z2\n").decode()}
    assert cell.post("cell/touches", touches).status_code == 200
    run_task(service.store, RUNNERS, "worker", service.clock)
    (part,) = ana.get(f"orders/{number}").json()["parts"]
    assert part["state"] == "held" and "PRB-LOG" in str(part)
