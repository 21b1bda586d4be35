"""LinuxCNC cuts one path three times at 50 mm/s with model and table in force: what is left, by two judges.

The first is `realtime/judge.py`, by the model's splines; the second knows nothing of trueloop: the image's bytes by
`struct` and plain sums, the table by a search over all segments.
"""

from functools import cache

import numpy as np

from tests.support import image_reference
from tests.support.cut_thrice import PROGRAM, TOOL_OFFSET, blocks, image, lathe_model
from trueloop.arrays import Array, Flags
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.judge import DrivenRun, RunJudgement, judge
from trueloop_lab.linuxcnc.realtime.session import QUIET, Driven, Setup, drive, home, on, put, record, run, wait

SIGNALS = {"T1": 27.5, "T2": 33.25}
RAMPING, IN_FORCE = 2, 3
LEFT_NM = 0.05
"""Far below the goal of 2 nm: drives are a wire here, and a model asked off by the table's 8 µm would leave 1 nm."""

PINS = (
    *("joint.0.pos-cmd", "joint.1.pos-cmd", "rtec.out-0", "rtec.out-2"),
    *("joint.0.motor-offset", "joint.1.motor-offset", "joint.0.f-error", "joint.1.f-error"),
    *("joint.0.motor-pos-cmd", "joint.1.motor-pos-cmd", "rtec.corr-0", "rtec.corr-2"),
    *("rtec.line", "rtec.phase", "rtec.fault-code", "rtec.tool-0", "rtec.tool-2", "rtec.on-path"),
)


@cache
def session(*, corrected: bool) -> Driven:
    names = [signal.name for signal in image().bank.signals]  # type: ignore[union-attr]
    signals = [put(f"rtec.signal-{k}", SIGNALS[name]) for k, name in enumerate(names)]
    enabled = [put("rtec.program", 1), put("rtec.enable", 1), wait("rtec.phase", IN_FORCE)] if corrected else []
    steps = [put("rtec.heartbeat", 1), *signals, on(), home(), *enabled, record(), run("thrice.ngc"), record(on=False)]
    files = {"thrice.ngc": PROGRAM.encode()}
    return drive(Setup(image_to_bytes(image()), files, PINS, hal=QUIET), steps)


def run_of(driven: Driven) -> DrivenRun:
    """What the judge asks for: positions without homing offsets."""
    nothing = np.zeros(len(driven.samples))
    command = np.column_stack([driven["joint.0.pos-cmd"], nothing, driven["joint.1.pos-cmd"]])
    x, z = (driven[f"rtec.out-{k}"] - driven[f"joint.{j}.motor-offset"] for k, j in ((0, 0), (2, 1)))
    tool = np.array([1.5, 0.0, -2.5]) - np.column_stack([driven["rtec.tool-0"], nothing, driven["rtec.tool-2"]])
    return DrivenRun(
        1e-3,
        command,
        np.column_stack([x, nothing, z]),
        SIGNALS,
        driven["rtec.line"].astype(np.intp),
        np.isin(driven["rtec.phase"], (RAMPING, IN_FORCE)),
        tool,
    )


def cutting(driven: Driven) -> Flags:
    """Periods on the lines of the table."""
    return np.isin(driven["rtec.line"], [block.line for block in blocks()])


def judged() -> RunJudgement:
    return judge(run_of(session(corrected=True)), lathe_model(), blocks())


def test_the_run_was_one() -> None:
    driven = session(corrected=True)
    assert not driven.messages and not driven["rtec.fault-code"].any()
    assert run_of(driven).in_force.all()
    speed = np.hypot(*np.diff(run_of(driven).command_mm[:, ::2], axis=0).T) / 1e-3
    cut = cutting(driven)[1:]
    assert np.median(speed[cut]) > 49.9 and cut.sum() > 5000
    assert driven["rtec.on-path"][cutting(driven)].mean() > 0.99


def test_what_is_left_is_within_two_nanometres() -> None:
    found, driven = judged(), session(corrected=True)
    cut = found.judged & cutting(driven)
    left = 1e6 * np.linalg.norm(found.residual_mm[cut], axis=1)
    print(f"{cut.sum()} periods in the cut: {np.sqrt(np.mean(left**2)):.5f} nm RMS, {left.max():.5f} nm at most")
    print(f"of {found.uncorrected_um:.1f} um; all periods {found.rms_nm:.2f} nm RMS, {found.worst_nm:.2f} at most")
    print(
        f"{found.reversals} reversals, {found.longest_limited_s * 1e3:.0f} ms at most, behind {found.behind_nm:.2f} nm"
    )
    assert found.uncorrected_um > 10.0
    assert np.sqrt(np.mean(left**2)) < LEFT_NM


def test_reversals_stay_within_the_slew() -> None:
    found = judged()
    assert found.reversals >= 6 and 0.001 < found.longest_limited_s < 0.02
    assert found.step_um <= found.most_step_um * (1 + 1e-9)
    assert found.behind_nm < LEFT_NM


def test_motion_sees_nothing_of_it() -> None:
    """The following error is what it is without the corrector: the feedback is last period's command."""
    with_it, without = session(corrected=True), session(corrected=False)
    for joint in (0, 1):
        assert np.abs(with_it[f"joint.{joint}.f-error"]).max() <= np.abs(without[f"joint.{joint}.f-error"]).max() + 1e-9


def test_without_the_corrector_the_errors_are_there() -> None:
    driven = session(corrected=False)
    assert not driven["rtec.corr-0"].any() and not driven["rtec.corr-2"].any()
    run = run_of(driven)
    bare = DrivenRun(1e-3, run.command_mm, run.drive_mm, SIGNALS, run.line, np.ones(len(run.line), bool), run.tool_mm)
    found = judge(bare, lathe_model(), blocks())
    cut = cutting(driven)
    assert 1e3 * np.sqrt(np.mean(np.sum(found.residual_mm[cut] ** 2, axis=1))) > 10.0


def test_a_judge_that_knows_nothing_of_trueloop_finds_the_same() -> None:
    """By the bytes: E where the drives stand, every fifth period; the table by all segments of the line's block."""
    driven, read = session(corrected=True), image_reference.read(image_to_bytes(image()))
    command = np.column_stack([driven["joint.0.pos-cmd"], driven["joint.1.pos-cmd"]])
    x, z = (driven[f"rtec.out-{k}"] - driven[f"joint.{j}.motor-offset"] for k, j in ((0, 0), (2, 1)))
    signals = [SIGNALS[name] for name in read.head["signals"] if name]
    way, seen, left = np.zeros(2), command[0].copy(), []
    settled = 0
    table = dict(read.words["blocks"])
    for k in range(len(command)):
        moved = np.abs(command[k] - seen) > 1e-9
        turned = np.where(moved, np.sign(command[k] - seen), way)
        line = int(driven["rtec.line"][k])
        settled = 0 if (turned != way).any() or (k and line != int(driven["rtec.line"][k - 1])) else settled + 1
        way, seen = turned, np.where(moved, command[k], seen)
        if k % 5 or settled < 20 or line not in table or not way.all():
            continue
        offset = [TOOL_OFFSET[0], 0.0, TOOL_OFFSET[1]]
        error = image_reference.error_mm(read, [x[k], 0.0, z[k]], [way[0], 0.0, way[1]], signals, offset)
        added, off = nearest(np.array(table[line]), command[k])
        if off < 0.05:
            left.append([x[k] + error[0] - command[k, 0] - added[0], z[k] + error[2] - command[k, 1] - added[1]])
    residual = 1e6 * np.hypot(*np.array(left).T)
    print(f"{len(residual)} periods: {np.sqrt(np.mean(residual**2)):.5f} nm RMS, {residual.max():.5f} nm at most")
    assert len(residual) > 700 and np.sqrt(np.mean(residual**2)) < LEFT_NM


def nearest(rows: Array, at: Array) -> tuple[Array, float]:
    """What a table says at the foot of the perpendicular on its nearest segment, and how far away that is."""
    a, b = rows[:-1], rows[1:]
    u = b[:, :2] - a[:, :2]
    share = np.clip(np.sum((at - a[:, :2]) * u, axis=1) / np.sum(u * u, axis=1), 0.0, 1.0)
    off = np.hypot(*(at - a[:, :2] - share[:, None] * u).T)
    k = int(np.argmin(off))
    return a[k, 2:] + share[k] * (b[k, 2:] - a[k, 2:]), float(off[k])
