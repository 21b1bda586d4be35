"""A job's table [machine], read: the model, the temperatures, where the part stands."""

from pathlib import Path
from typing import Final

from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.formats.jobs.correction_tables import MachineTable
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.sources import Sources
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.machine.model.history import check_lags_given, signals_at_end
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import require_serial

NOWHERE: Final = (0.0, 0.0, 0.0)


def read_part_on_machine(sources: Sources, job: Path, given: MachineTable, ball_radius_mm: float) -> PartOnMachine:
    """Reads the part on its machine. `ball_radius_mm` of the probe, where the table has none. Where several
    tools or set-ups cut it, what places these is stated in their own tables, and takes the place of zeros here.

    Raises MCH-FILE for what is no model, MCH-MACHINE for a model of another machine, MCH-HISTORY and MCH-SIGNAL.
    """
    file = sources.file(given.model)
    model = read_model(file)
    with in_file(file):
        require_serial(model, given.serial)
    cutting = _signals(sources, job, model, given.cutting)
    ball = ball_radius_mm if given.probe_ball_radius_mm is None else given.probe_ball_radius_mm
    return PartOnMachine(
        model=model,
        sha256=sha256_of(file.read_bytes()),
        work_zero_mm=given.work_zero_mm or NOWHERE,
        tool_mm=given.tool_mm or NOWHERE,
        probe_mm=given.probe_mm or given.tool_mm or NOWHERE,
        cutting=cutting,
        semifinish=cutting if given.semifinish is None else _signals(sources, job, model, given.semifinish),
        probing=cutting if given.probing is None else _signals(sources, job, model, given.probing),
        touched_on=given.touched_on,
        semifinish_cut=given.semifinish_cut,
        ball_radius_mm=ball,
        extrapolate=given.extrapolate,
        file=str(job),
    )


def _signals(sources: Sources, job: Path, model: MachineModel, given: dict[str, float] | Path) -> Signals:
    if isinstance(given, Path):
        log = sources.file(given)
        with in_file(log):
            return signals_at_end(read_history(log), model.lags)
    with in_file(job):
        check_lags_given(model.lags, given)
        for name in model.needs():
            if name not in given:
                raise TrueloopError(
                    Code.MCH_SIGNAL,
                    f"the model needs the signal {name!r}; the job gives {len(given)}: {', '.join(given) or 'none'}",
                    hint=f"write it into the table [machine]: cutting = {{ {name} = 21.5 }}, in the unit of the data",
                    values={"signals": [name]},
                )
        return dict(given)
