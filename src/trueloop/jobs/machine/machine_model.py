"""A machine's readings and logs, read, to a model of its errors."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from trueloop.arrays import Array
from trueloop.described import filled_from
from trueloop.diagnosis.components import Inspections
from trueloop.domain.inspection import BothInspections, CmmPoint, Inspection, MachineStood, Vector
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import sha256_of
from trueloop.domain.tool import Machine
from trueloop.errors import Code, in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.measurements.instruments_toml import SUFFIX, files_of, read_instruments, refuse_alone
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.model_file import accepted_text, model_to_json, read_model
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.jobs.store.opened import Choice, Keeping, store_of
from trueloop.jobs.user import user_name
from trueloop.loops.diagnosis.left_on_parts import BothSeen
from trueloop.machine.identify.form import Chosen, fit_form, with_segments
from trueloop.machine.identify.identify import Identification
from trueloop.machine.identify.judge_fit import HeldOut, hold_out, require_agreement, with_lack_of_fit
from trueloop.machine.identify.observations import Observations, joined
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.history import check_lags_given, signals_at_end
from trueloop.machine.model.model import Acceptance, MachineModel, State, Version
from trueloop.machine.model.term import means
from trueloop.machine.refine.refine import Refined, require_better
from trueloop.report.machine.page import machine_page


def keep_both(
    of: BothSeen, path: Path, model: MachineModel, model_sha256: str, zero_mm: Vector, *, keeping: Keeping
) -> KeptFacts:
    """Keeps a part with both devices' inspections, read from a file, and how its machine stood.

    `zero_mm` are machine coordinates of the part's zero; `model_sha256` is that of the model's file.

    Raises STO-OTHER-PART for a file that is kept as another part's, and what keeping refuses.
    """
    store = store_of(path.parent, keeping.db, None, "made")
    assert store is not None  # made where there is none
    part = Part(PartType(of.part_type), of.serial)
    on_machine, on_cmm = _inspections(of, path, part)
    for inspection in (on_machine, on_cmm):
        require_file_of_part(store, inspection)
    seen, named = of.seen, model.machine
    comp_proc_mm = np.atleast_1d(np.asarray(seen.comp_proc_mm, dtype=np.float64))
    both = filled_from(
        BothInspections,
        of,
        part=part,
        machine=Machine(named.name, named.serial),
        on_machine=on_machine.identity,
        on_cmm=on_cmm.identity,
        cutting=_stood(zero_mm, of.cutting),
        probing=_stood(zero_mm, of.probing),
        model_sha256=model_sha256,
        touch_u_mm=seen.touch_u_mm,
        cmm_u_mm=seen.cmm_u_mm,
        comp_proc_mm=tuple(comp_proc_mm.tolist()) if comp_proc_mm.any() else (),
    )
    return keep_facts(store, (part, on_machine, on_cmm, both), supersede=keeping.supersede)


def _inspections(of: BothSeen, path: Path, part: Part) -> Iterator[Inspection]:
    """One inspection a device. What tells them apart is the hash: of the file, and of which of its columns it is."""
    sha256 = sha256_of(path.read_bytes())
    for device, measured_mm in (("machine's probe", of.seen.controller_mm), ("measuring machine", of.seen.cmm_mm)):
        values = tuple(_points(of.points, of.seen, measured_mm))
        own = sha256_of(f"{sha256} {device}".encode())
        yield Inspection(part=part, measured="CMM points", sha256=own, count=len(values), values=values, device=device)


def _stood(zero_mm: Vector, state: State) -> MachineStood:
    tools = np.atleast_2d(np.asarray(state.tool_mm, dtype=np.float64))
    same = len(tools) > 0 and bool(np.all(tools == tools[0]))
    return MachineStood(zero_mm, tuple(_vector(one) for one in (tools[:1] if same else tools)), means(state.signals))


def _points(points: Sequence[str], inspections: Inspections, measured_mm: Array) -> Iterator[CmmPoint]:
    for k, name in enumerate(points):
        measured, nominal, normal = (_vector(of[k]) for of in (measured_mm, inspections.nominal_mm, inspections.normal))
        yield CmmPoint(measured, nominal, normal, name)


def _vector(of: Array) -> Vector:
    x, y, z = of.tolist()
    return x, y, z


def offer_model(
    parent: Path, refined: Refined, out: Path, *, db: str | None = None, accept: Sequence[Code] = ()
) -> tuple[Path, KeptFacts | None]:
    """Writes the refined model to `out` as a version that is offered, and keeps it; None: there is no store.

    `parent` is the file that it was refined from. Raises DIA-WORSE for one that is no better on parts left out, unless
    that is among `accept`, OUT errors (the parent is never overwritten), and what keeping refuses.
    """
    require_better(refined, accept)
    known, content = read_model(parent), parent.read_bytes()
    version = Version(
        number=1 if known.version is None else known.version.number + 1,
        parent_sha256=sha256_of(content),
        errors=tuple(dict.fromkeys(str(guilty.error) for guilty in refined.guilty)),
        reason=str(refined.reason),
        judged=str(refined.judged.words),
        made_at=_now(),
        made_by=user_name(),
    )
    model = replace(refined.model, version=version)
    text = model_to_json(model, {parent.name: version.parent_sha256})
    (written,) = write_all(out.parent, [(out.name, text.encode())], inputs=(parent,))
    return written, _kept(written, (_value(model, version, text),), db)


def accept_model(
    offered: Path, out: Path, *, why: str = "", who: str = "", db: Choice = None
) -> tuple[Path, KeptFacts | None]:
    """Writes the offered model to `out` as accepted, by the user unless `who` is named, and keeps the decision.

    Raises MCH-FILE for a model that is not offered or was accepted before, OUT errors (the offered file is never
    overwritten), and STO-DIFFERS where the store holds another decision on it.
    """
    before = read_model(offered, offered=True)
    text, content = offered.read_text(encoding="utf-8"), offered.read_bytes()
    acceptance = Acceptance(who or user_name(), _now(), why)
    accepted = accepted_text(offered, acceptance)
    (written,) = write_all(out.parent, [(out.name, accepted.encode())], inputs=(offered,))
    at = datetime.fromisoformat(acceptance.at)
    decision = ModelDecision(sha256_of(content), "accepted", acceptance.who, at, why)
    now = read_model(written)
    assert before.version is not None and now.version is not None
    values = (_value(before, before.version, text), decision, _value(now, now.version, accepted))
    return written, _kept(written, values, db)


def _value(model: MachineModel, version: Version, text: str) -> ModelVersion:
    """As the store has it."""
    return filled_from(
        ModelVersion,
        version,
        machine=Machine(model.machine.name, model.machine.serial),
        sha256=sha256_of(text.encode()),
        text=text,
        made_at=datetime.fromisoformat(version.made_at),
    )


def _kept(file: Path, values: tuple[ModelVersion | ModelDecision, ...], db: Choice) -> KeptFacts | None:
    store = store_of(file.parent, db, None)
    return None if store is None else keep_facts(store, values)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def readings_of(paths: Sequence[Path], chain: Chain, history: Path | None) -> Observations:
    """Joins all readings, each with the log's past: CSV, or the instruments' files of a `.toml`. Raises MCH errors."""
    past = read_history(history) if history else None
    for path in paths:
        refuse_alone(path)
    read = [
        read_instruments(path, chain) if path.suffix == SUFFIX else read_readings(path, chain, past) for path in paths
    ]
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
    """Returns the files' hashes by name: what a model was made from."""
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
    machine: FilePath,
    readings: Sequence[FilePath],
    history: FilePath | None = None,
    *,
    robust: bool = True,
    accept: Sequence[str] = (),
) -> FittedMachine:
    """Returns the model of a machine from the files of readings and a log of its temperatures.

    robust: outliers count less. Raises MCH errors that name the file; MCH-RUN for a run that contradicts the others and
    MCH-SCATTER for readings in another unit are not raised where they are among `accept`.

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
    anew = bool(form.choices or any(lag.between_s for lag in form.lags))
    with in_file(machine):
        form, notes = with_segments(named, form, data)

    def fit(some: Observations) -> MachineModel:
        return fit_form(named, form, some, robust=robust)[0].model

    def judged(some: Observations) -> tuple[Identification, tuple[HeldOut, ...]]:
        alone, _ = fit_form(named, form, some, robust=robust)
        return alone, hold_out(some, alone, fit, anew=anew)

    with in_file(machine):
        found, chosen = fit_form(named, form, data, robust=robust)
    held = hold_out(data, found, fit, anew=anew)
    with in_file(files[0] if len(files) == 1 else machine):
        warnings = require_agreement((found, held), data, judged, accept)
    found = with_lack_of_fit(replace(found, findings=(*warnings, *notes, *found.findings)), data, held)
    sources = (machine, *(source for file in files for source in files_of(file)), *([log] if log else ()))
    return FittedMachine(found, chosen, held, data, sources)
