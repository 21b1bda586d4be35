"""A recorded run judged by the model file that its image was made from."""

from collections.abc import Sequence

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.realtime.samples_csv import read_samples
from trueloop.formats.tables.model_file import read_model
from trueloop.machine.model.chain import ZERO, Vector
from trueloop.realtime.judge import DrivenRun, Judged, judge
from trueloop.realtime.samples import Samples, signal_columns

FOLLOWS = (2, 3)
"""Phases in which the correction is in force, or on its way."""

OWN_PROGRAM = 1


def check_run(
    samples: FilePath, model: FilePath, image: FilePath | None = None, *, slew_mm_per_s: float = 5.0
) -> Judged:
    """Judges the run against the model; with the `image` also against its table, with its tool and gate.

    Raises RTC-SAMPLES for a run that cannot be judged, RTC-IMAGE, MCH-FILE.
    """
    recorded, known = read_samples(samples), read_model(model, offered=True)
    held = read_image(image) if image is not None else None
    bank = held.bank if held else None
    names = [(s.name, s.unit) for s in bank.signals] if bank else [(n, known.units.get(n, "")) for n in known.needs()]
    blocks, gate = (held.blocks, held.limits.gate_mm) if held else ((), 0.1)
    run = driven_run(recorded, names, bank.tool_mm if bank else ZERO, str(samples))
    return judge(run, known, blocks, slew_mm_per_s=slew_mm_per_s, gate_mm=gate)


def driven_run(samples: Samples, signals: Sequence[tuple[str, str]], tool_mm: Vector, file: str) -> DrivenRun:
    """Prepares a run to be judged. `signals`: name and unit of each; `tool_mm` while no tool offset is in force."""
    columns = signal_columns(signals)
    missing = [column for column in columns if column not in samples.signals]
    in_force = np.isin(samples.count("phase"), FOLLOWS)
    if missing:
        why = f"{len(missing)} of {len(columns)} signals of the model are not recorded: {', '.join(missing)}"
        raise _refusal(file, why, "judge it by the model that its image was made from")
    if samples.lost:
        raise _refusal(file, f"{samples.lost} periods were not recorded", "record it again with less beside it")
    if not in_force.any():
        raise _refusal(file, f"the correction is in force in 0 of {len(samples)} periods", "enable the corrector")
    return DrivenRun(
        samples.period_s,
        samples.mm("command"),
        samples.mm("drive"),
        {name: samples.columns[column] for (name, _), column in zip(signals, columns, strict=True)},
        np.where(samples.count("program") == OWN_PROGRAM, samples.count("line"), 0),
        in_force,
        np.asarray(tool_mm) - samples.mm("tool"),
    )


def _refusal(file: str, message: str, hint: str) -> TrueloopError:
    return TrueloopError(Code.RTC_SAMPLES, message, hint=hint, place=Place(file))
