"""A machine's readings and logs, read, to a model of its errors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.arrays import Array
from trueloop.domain.record import sha256_of
from trueloop.errors import in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.model_file import model_to_json
from trueloop.machine.identify.choice import Chosen
from trueloop.machine.identify.form import fit_form
from trueloop.machine.identify.hold_out import HeldOut, hold_out
from trueloop.machine.identify.identify import Identification
from trueloop.machine.identify.observations import Observations, joined
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.history import check_lags_given, signals_at_end
from trueloop.machine.model.model import MachineModel
from trueloop.report.machine.page import machine_page


def readings_of(paths: Sequence[Path], chain: Chain, history: Path | None) -> Observations:
    """All readings as one, with what the log says of the past. Raises MCH errors that name the file."""
    past = read_history(history) if history else None
    read = [read_readings(path, chain, past) for path in paths]
    with in_file(paths[-1]):
        return joined(read)


def signals_of(
    model: MachineModel, logs: Sequence[Path], values: Mapping[str, float], until_s: float = math.inf
) -> dict[str, Array | float]:
    """Logs as they stand at their last row until then, and values, lags among them. Raises MCH-HISTORY.

    >>> fitted = trueloop.fit_machine(
    ...     trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")]
    ... )
    >>> trueloop.signals_of(fitted.found.model, [trueloop.example("machine/temperatures.csv")], {"T2": 21.0})
    {'T1': 24.5, 'T2': 21.0}
    """
    signals: dict[str, Array | float] = {}
    for log in logs:
        with in_file(log):
            signals |= signals_at_end(read_history(log).until(until_s), model.lags)
    signals |= values
    check_lags_given(model.lags, signals)
    return signals


def hashes_of(files: Sequence[Path]) -> dict[str, str]:
    """By name: what a model was made from."""
    return {path.name: sha256_of(path.read_bytes()) for path in files}


@dataclass(frozen=True, eq=False)
class FittedMachine:
    """A model found from readings, the signals that its errors took, and what it leaves of each run left out.

    >>> fitted = trueloop.fit_machine(
    ...     trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")]
    ... )
    >>> len(fitted.data), round(fitted.found.scatter, 2)
    (66, 0.88)
    """

    found: Identification
    chosen: tuple[Chosen, ...]
    held: tuple[HeldOut, ...]
    data: Observations
    files: tuple[Path, ...]

    def write(self, folder: Path) -> list[Path]:
        """Writes model.json and machine.html. Raises OUT errors."""
        model = self.found.model
        page = machine_page(self.found, self.chosen, self.data.with_lags(model.lags), self.held)
        contents = {"model.json": model_to_json(model, hashes_of(self.files)), "machine.html": page}
        return write_all(folder, [(name, text.encode()) for name, text in contents.items()], inputs=self.files)


def fit_machine(
    machine: FilePath, readings: Sequence[FilePath], history: FilePath | None = None, *, robust: bool = True
) -> FittedMachine:
    """The model of a machine from the files of readings and a log of its temperatures.

    robust: outliers count less. Raises MCH errors that name the file.

    >>> fitted = trueloop.fit_machine(
    ...     trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")]
    ... )
    >>> fitted.found.model.machine.serial, [run.run for run in fitted.held][:2]
    ('4711', ['X at 20 °C', 'Y at 20 °C'])
    >>> [file.name for file in fitted.write("machine")]
    ['model.json', 'machine.html']
    """
    machine, log, files = Path(machine), Path(history) if history else None, [Path(file) for file in readings]
    named, form = read_machine(machine)
    data = readings_of(files, named.chain, log)
    with in_file(machine):
        found, chosen = fit_form(named, form, data, robust=robust)
    anew = bool(form.choices or any(lag.between_s for lag in form.lags))
    held = hold_out(data, found, lambda others: fit_form(named, form, others, robust=robust)[0].model, anew=anew)
    return FittedMachine(found, chosen, held, data, (machine, *files, *([log] if log else ())))
