"""The corrector in a LinuxCNC that runs: what it adds, and when it adds nothing."""

import numpy as np
import pytest

from tests.support.realtime_lathe import LATHE, RECORD, SLEW_MM, LinearLathe, added, commanded, stood
from trueloop_lab.linuxcnc.realtime.session import (
    Driven,
    Setup,
    Step,
    drive,
    get,
    home,
    mdi,
    note,
    on,
    put,
    record,
    run,
    sleep,
    wait,
)

PROGRAM = b"G21 G18 G8 G90 G94\nG64 P0.0001\nG0 X310 Z90\nG1 X280 Z70 F3000\nG2 X260 Z90 I-20\nM2\n"
IN_FORCE: tuple[Step, ...] = (put("rtec.enable", 1), wait("rtec.phase", 3))
OFF: tuple[Step, ...] = (put("rtec.enable", 0), wait("rtec.phase", 0), wait("rtec.active", 0))
SECOND_ORDER_MM = 1e-8
"""What two steps towards the fixed point leave of 40 µm with slopes of 2e-4."""


def steps_of(driven: Driven) -> float:
    """The largest change of the correction in a period."""
    return float(np.abs(np.diff(added(driven), axis=0)).max())


def test_a_program_is_cut_where_it_is_commanded_and_motion_sees_nothing_of_it() -> None:
    setup = Setup(LATHE.image, {"p.ngc": PROGRAM}, RECORD)
    driven = drive(setup, [on(), home(), *IN_FORCE, record(), run("p.ngc"), record(False)])
    assert not driven.messages
    at = commanded(driven)
    assert np.ptp(at, axis=0).min() > 29.0
    np.testing.assert_allclose(stood(driven) - at, LATHE.added_mm(at), atol=SECOND_ORDER_MM)
    assert np.abs(LATHE.added_mm(at)).max() > 0.03
    # the drive is a wire, seen one period later: motion sees its own last command
    for joint, axis in ((0, 0), (1, 2)):
        np.testing.assert_allclose(driven[f"rtec.fb-{axis}"][1:], driven[f"rtec.cmd-{axis}"][:-1], atol=1e-12)
        assert np.abs(driven[f"joint.{joint}.f-error"]).max() < 1e-9
    assert set(driven["rtec.phase"]) <= {2.0, 3.0}


def test_switched_on_and_off_it_comes_and_goes_within_the_slew() -> None:
    driven = drive(
        Setup(LATHE.image, record=RECORD), [on(), home(), record(), *IN_FORCE, sleep(0.05), *OFF, sleep(0.05)]
    )
    assert steps_of(driven) <= SLEW_MM + 1e-12
    c = added(driven)
    assert np.abs(c[-1]).max() == 0.0
    np.testing.assert_allclose(
        c[np.argmax(np.abs(c[:, 0]))], LATHE.added_mm(commanded(driven))[0], atol=SECOND_ORDER_MM
    )


def test_where_homing_left_an_offset_the_error_is_asked_in_machine_coordinates() -> None:
    # homed in place at motor 0: X 300 is the drive's 0, so that a question at the motor's place would find no error
    driven = drive(Setup(LATHE.image, record=RECORD), [on(), home(), *IN_FORCE, record(), sleep(0.05), record(False)])
    assert np.abs(driven["joint.0.motor-offset"]).min() > 100.0
    np.testing.assert_allclose(added(driven), LATHE.added_mm(commanded(driven)), atol=SECOND_ORDER_MM)


SWITCHES = """loadrt comp count=2
addf comp.0 servo-thread
addf comp.1 servo-thread
setp comp.0.in0 5.3456
setp comp.1.in0 3.25
setp comp.0.hyst 0
setp comp.1.hyst 0
net x-drive => comp.0.in1
net z-drive => comp.1.in1
net x-switch comp.0.out => joint.0.home-sw-in
net z-switch comp.1.out => joint.1.home-sw-in
"""
"""Home switches that stand at places of the drives."""
SEARCHED = tuple(
    (section, key, value)
    for section in ("JOINT_0", "JOINT_1")
    for key, value in (("HOME_SEARCH_VEL", "20"), ("HOME_LATCH_VEL", "0.5"))
)
FREE = "unlinkp motion.homing-inhibit\n"


def test_homing_with_the_corrector_asked_for_leaves_the_home_where_it_was() -> None:
    setup = Setup(LATHE.image, record=RECORD, hal=SWITCHES + FREE, ini=SEARCHED)
    offsets = ("joint.0.motor-offset", "joint.1.motor-offset")
    steps = [on(), home(), get("off", *offsets), *IN_FORCE, record(), home(0), home(), record(False)]
    driven = drive(setup, [*steps, get("on", *offsets), wait("rtec.phase", 3)])
    # the place is latched once a period: half a micrometre at the latch velocity; the same way, the same place
    np.testing.assert_allclose(driven.got["on"], driven.got["off"], atol=1e-4)
    assert steps_of(driven) <= SLEW_MM + 1e-12
    homing = driven["motion.is-all-homed"] == 0.0
    assert homing.sum() > 100
    late = np.convolve(homing, np.ones(20), "full")[: len(homing)] >= 20  # it ramps down within some periods
    assert np.abs(added(driven)[late]).max() == 0.0
    assert np.abs(added(driven)[~homing]).max() > 0.01


def test_homing_is_denied_while_something_is_added() -> None:
    steps = [on(), home(), *IN_FORCE, get("before", "joint.0.motor-offset"), ("start_home", 0), sleep(0.5)]
    driven = drive(Setup(LATHE.image), [*steps, get("after", "joint.0.motor-offset"), *OFF, home(0)])
    assert "homing-inhibit" in driven.messages[0]
    assert driven.got["before"] == driven.got["after"]


@pytest.mark.parametrize(("word", "end_mm"), [("X", 305.0), ("Z", 60.0)])
def test_no_drive_leaves_the_travel_and_the_program_is_paused(word: str, end_mm: float) -> None:
    lathe = LinearLathe(
        -np.abs(LATHE.slopes) if word == "X" else np.abs(LATHE.slopes), ((-500, 305), (-1, 1), (60, 2000))
    )
    program = f"G21 G18 G8 G90 G94\nG1 {word}{end_mm} F3000\nM2\n".encode()
    setup = Setup(lathe.image, {"p.ngc": program}, RECORD, hal="net rtec-pause rtec.pause\n")
    steps = [on(), home(), *IN_FORCE, record(), run("p.ngc"), sleep(0.1), record(False)]
    driven = drive(setup, [*steps, get("said", "rtec.fault", "rtec.fault-code", "rtec.pause")])
    x, z = stood(driven).T
    assert x.max() <= 305.0 + 1e-12
    assert z.min() >= 60.0 - 1e-12
    assert driven.got["said"] == [True, 3, True]
    assert np.abs(added(driven)[-1]).max() == 0.0
    assert steps_of(driven) <= SLEW_MM + 1e-12


def test_a_tool_offset_and_another_work_coordinate_system_change_no_machine_coordinate() -> None:
    steps = [
        mdi("G10 L1 P1 X1.5 Z-12"),
        mdi("T1 M6 G43"),
        mdi("G10 L2 P1 X3 Z7"),
        mdi("G90 G21 G8"),
        mdi("G0 X290 Z80"),
    ]
    setup = Setup(LATHE.image, record=(*RECORD, "rtec.tool-0", "rtec.tool-2"))
    driven = drive(setup, [on(), home(), *IN_FORCE, record(), *steps, sleep(0.05), record(False)])
    assert (driven["rtec.tool-0"][-1], driven["rtec.tool-2"][-1]) == (1.5, -12.0)
    np.testing.assert_allclose(commanded(driven)[-1], [290 + 3 + 1.5, 80 + 7 - 12], atol=1e-9)
    np.testing.assert_allclose(added(driven), LATHE.added_mm(commanded(driven)), atol=SECOND_ORDER_MM)


def test_an_abort_in_a_move_and_an_emergency_stop_leave_no_step() -> None:
    move = ("start_mdi", "G1 X200 Z20 F6000")
    steps = [
        on(),
        home(),
        *IN_FORCE,
        record(),
        mdi("G8 G90 G21"),
        move,
        sleep(0.3),
        ("abort",),
        sleep(0.3),
        note("stop"),
    ]
    stop = [
        ("start_mdi", "G1 X100 Z10 F6000"),
        sleep(0.3),
        ("estop",),
        sleep(0.2),
        get("off", "rtec.phase", "rtec.active"),
    ]
    again = [on(), wait("rtec.phase", 3), sleep(0.05), record(False)]
    driven = drive(Setup(LATHE.image, record=RECORD), [*steps, *stop, *again])
    at = commanded(driven)
    aborted = driven.got["stop"]
    assert at[0, 0] > at[aborted - 1, 0] > 200.0
    np.testing.assert_allclose(added(driven)[:aborted], LATHE.added_mm(at[:aborted]), atol=SECOND_ORDER_MM)
    assert driven.got["off"] == [1, False]
    assert steps_of(driven) <= SLEW_MM + 1e-12
    np.testing.assert_allclose(added(driven)[-1], LATHE.added_mm(at)[-1], atol=SECOND_ORDER_MM)
    assert max(np.abs(driven[f"joint.{joint}.f-error"]).max() for joint in (0, 1)) < 1e-9


INCH = (
    ("TRAJ", "LINEAR_UNITS", "inch"),
    *(
        (f"{part}_{name}", key, value)
        for part, name in (("AXIS", "X"), ("JOINT", "0"), ("AXIS", "Z"), ("JOINT", "1"))
        for key, value in (("MIN_LIMIT", "-20"), ("MAX_LIMIT", "20"))
    ),
    *(("JOINT_0", key, "12") for key in ("HOME", "HOME_OFFSET")),
    *(("JOINT_1", key, "4") for key in ("HOME", "HOME_OFFSET")),
)


def test_a_machine_in_inches_is_corrected_by_the_same_millimetres() -> None:
    program = b"G20 G18 G8 G90 G94\nG64 P0.000001\nG0 X12.5 Z3.5\nG1 X11 Z3 F100\nM2\n"
    setup = Setup(LATHE.image, {"p.ngc": program}, RECORD, hal="setp rtec.mm-per-unit 25.4\n", ini=INCH)
    driven = drive(setup, [on(), home(), *IN_FORCE, record(), run("p.ngc"), record(False)])
    assert not driven.messages
    at_mm, stood_mm = 25.4 * commanded(driven), 25.4 * stood(driven)
    assert at_mm[:, 0].max() == pytest.approx(12.5 * 25.4, abs=0.1)
    np.testing.assert_allclose(stood_mm - at_mm, LATHE.added_mm(at_mm), atol=SECOND_ORDER_MM)
    np.testing.assert_allclose(added(driven), LATHE.added_mm(at_mm), atol=SECOND_ORDER_MM)
    assert max(np.abs(driven[f"joint.{joint}.f-error"]).max() for joint in (0, 1)) < 1e-9


PROBE = """loadrt comp names=touching
addf touching servo-thread
setp touching.in0 250.0
setp touching.hyst 0
loadrt sum2 names=x-machine
addf x-machine servo-thread
setp x-machine.gain1 -1
net x-drive => x-machine.in0
net x-offset joint.0.motor-offset => x-machine.in1
net x-true x-machine.out => touching.in1
loadrt not names=closed
addf closed servo-thread
net beyond touching.out => closed.in
net contact closed.out => motion.probe-input rtec.touch
"""
"""A surface at drive position 250 of X, met from above."""
LATE_MM = 2.5e-3
"""Two periods at 60 mm/min, and the place of the touch within one."""


@pytest.mark.parametrize("corrected", [False, True])
def test_probed_places_are_where_the_drive_was_without_and_where_the_tool_was_with_it(corrected: bool) -> None:
    setup = Setup(LATHE.image, hal=f"{PROBE}setp rtec.probe-corrected {int(corrected)}\n")
    probing = [mdi("G8 G90 G21 G94"), mdi("G0 X252 Z80"), mdi("G38.2 X248 F60"), ("probed", "touch")]
    driven = drive(setup, [on(), home(), *IN_FORCE, *probing, get("latch", "rtec.latch-0", "rtec.latch-2")])
    tripped, x, _, z = driven.got["touch"]
    assert tripped
    # [6876 §3.3]: COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG; with the correction in force the control's are actual
    comp = LATHE.added_mm(np.array([[250.0, 80.0]]))[0]
    actual = np.array([250.0, 80.0]) - (comp if not corrected else [comp[0], 0.0])
    np.testing.assert_allclose([x, z], actual if corrected else [250.0, 80.0], atol=LATE_MM)
    np.testing.assert_allclose(driven.got["latch"], actual, atol=LATE_MM)
    assert np.abs(comp).min() > 5 * LATE_MM
