"""LinuxCNC with sensors that change while it cuts: every period judged with the values that were in use in it."""

import numpy as np

from tests.support.cut_thrice import TOOL_OFFSET, image, lathe_model
from trueloop.controllers.linuxcnc.realtime.warming_run import Sensors, warming_run
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.judge import judge
from trueloop.realtime.samples import signal_columns

PROGRAM = f"""G18 G21 G8 G90 G94 G40 G64 P0.0001 Q0
G43.1 X{TOOL_OFFSET[0]} Z{TOOL_OFFSET[1]}
G0 X40 Z5
G1 Z-60 F3000
G2 X60 Z-80 I0 K-20
G1 Z-20
G4 P0.3
G1 X90 Z-60
G49
M2
"""


def test_a_warming_machine_is_corrected_in_every_period() -> None:
    held, model = image(tables=False), lathe_model()
    time_s = np.arange(0.0, 60.0, 1e-3)
    warmer = np.floor(time_s / 0.1) * 0.1
    sensors = Sensors(time_s, {"T1": 20.0 + 0.6 * warmer % 15.0, "T2": 38.0 - 0.2 * warmer})
    ran = warming_run(image_to_bytes(held), held, PROGRAM, sensors, corrected=True)
    assert not ran.messages and not ran.samples.count("fault").any()
    assert np.allclose(np.diff(ran.clock_s), 1e-3, atol=1e-9)
    felt = ran.samples.columns[signal_columns([("T1", "°C")])[0]]
    assert np.ptp(felt) > 1.0 and np.abs(felt - np.interp(ran.clock_s, time_s, sensors.values["T1"])).max() < 0.1
    found = judge(ran.driven, model)
    print(f"{found.judged.sum()} periods, {found.rms_nm:.5f} nm RMS, {found.worst_nm:.5f} at most")
    assert found.judged.sum() > 3000 and found.uncorrected_um > 5.0
    assert found.rms_nm < 0.05 and found.within(0.05)
