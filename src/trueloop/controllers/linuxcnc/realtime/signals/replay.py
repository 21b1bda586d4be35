"""A log of temperatures and speeds played again: to try a machine out, or to repeat what was."""

import threading
import time
from dataclasses import dataclass

import numpy as np

from trueloop.controllers.linuxcnc.realtime.signals.readings import Intake, wait
from trueloop.machine.model.history import History


@dataclass(frozen=True)
class Replay:
    """A log from `start_s` on, of its own time, at `speed` times its pace; straight between its rows.

    `began_s`: when that row was due, on the monotonic clock. `columns` are signals of the log by name here.
    """

    log: History
    columns: dict[str, str]
    began_s: float
    start_s: float
    speed: float = 1.0
    every_s: float = 0.1

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until the log ends; from then on its signals grow old."""
        while not stop.is_set():
            now_s = time.monotonic()
            row_s = self.start_s + self.speed * (now_s - self.began_s)
            for name, column in self.columns.items():
                if row_s <= self.log.time_s[-1]:
                    intake.put(name, float(np.interp(row_s, self.log.time_s, self.log.signals[column])), now_s)
                else:
                    intake.refuse(name, f"the log ended at {self.log.time_s[-1]:g} s")
            wait(stop, now_s, self.every_s)
