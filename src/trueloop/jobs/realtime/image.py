"""From a machine's model, a job or a stored correction to the image of the real-time corrector.

A job, or a correction kept in a store, as the table by program line that the real-time corrector applies.

`record.json` alone does not do: it says what was changed, not where everything between goes. A job is corrected anew,
as `trueloop compensate` does it, and nothing is written; a store holds every correction whole.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.domain.record import Correction as Kept
from trueloop.domain.record import Product, sha256_of
from trueloop.errors import Code, in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.db.found import named_row
from trueloop.jobs.machine.mapped_program import ModelFile
from trueloop.jobs.store.opened import Choice, Keeping, open_store
from trueloop.jobs.turned.compensate import correct_job
from trueloop.loops.realtime.process_table import PlacedCorrection, machine_of, process_table
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Correction
from trueloop.machine.model.chain import ZERO, Vector
from trueloop.machine.model.validity import require_serial
from trueloop.nc.program.program import Program, read_program
from trueloop.realtime.image import (
    NOTHING,
    TRAVEL_TOLERANCE_MM,
    Bank,
    Block,
    Identity,
    Image,
    RealTimeLimits,
    SignalLimits,
    bank_of,
    signals_of,
)
from trueloop.realtime.largest import Extent, extent_of
from trueloop.report.realtime.image_summary import where_in_words
from trueloop.storage.kinds import joined
from trueloop.storage.store import find
from trueloop.units import UM_PER_MM

SAME_MM: Final = 1e-6


@dataclass(frozen=True)
class Placing:
    """The program's position as called for, as `Placed`; `origin_mm` None: `work_zero_mm` less `tool_mm` of the job."""

    origin_mm: tuple[float, float] | None = None
    tip: int = 0
    gate_mm: float = 0.1


@dataclass(frozen=True)
class CorrectedProgram:
    """The table of a correction, and whose it is.

    `program` and `program_sha256` are of the *given* finish program, which is to be run; `record` is the id that the
    corrected program bears. `limit_mm`: the largest correction that the job allows, along the normal. `model_sha256`
    is that of the model file that must act in real time besides, as the correction counts on it, `machine` and `serial`
    its machine's; "" where the correction takes nothing from a model. `files` must not be written over.
    """

    blocks: tuple[Block, ...]
    program: str
    program_sha256: str
    record: str
    limit_mm: float
    model_sha256: str = ""
    machine: str = ""
    serial: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def table_of_job(job: FilePath, placing: Placing, keeping: Keeping | None = None) -> CorrectedProgram:
    """Makes the table of a job's correction, as `trueloop compensate` makes it. Nothing is written or kept.

    Raises what reading and correcting refuse, RTC-TABLE where the program's place is not stated, RTC-LINE,
    RTC-PATH-MODE, CTL-DIALECT.
    """
    made = correct_job(job, keeping or Keeping())
    with in_file(str(job)):
        return _image_table(made.inputs.program, made.inputs.run, made.correction, placing, made.read.files)


def table_of_record(record: str, placing: Placing, db: Choice = None) -> CorrectedProgram:
    """Makes the table of a correction kept in a store (`db`, else `trueloop.db` in the present folder), by record id.

    Raises STO errors, STO-UNKNOWN for a record that is not there, RTC-TABLE for one that corrects no turned part, and
    what `table_of_job` raises of tables.
    """
    store = open_store(db, read_only=True)
    found: list[Any] = find(store, Kept, identity=joined((record,)))
    kept: Kept[Correction] = found[-1].value if found else named_row(store, record).kept.value
    if kept.record.product is not Product.TURNED:
        raise Code.RTC_TABLE.refusal(
            f"record {record} corrects no turned part: its product is {str(kept.record.product)!r}",
            hint="a table is made of what `trueloop compensate` corrects",
        )
    correction = kept.payload
    with in_file(correction.source_name):
        return _image_table(_program(correction), _run(correction), correction, placing, (Path(store.where),))


def _image_table(
    program: Program, run: Run, correction: Correction, placing: Placing, files: tuple[Path, ...]
) -> CorrectedProgram:
    part = machine_of(correction)
    table = process_table(program, run, correction, _placed(correction, placing))
    assert correction.record.program is not None  # every turned part's record has one
    return CorrectedProgram(
        blocks=table.blocks,
        program=correction.source_name,
        program_sha256=correction.record.program.sha256,
        record=correction.record.id,
        limit_mm=correction.options.limits.correction_mm,
        model_sha256="" if part is None else part.sha256,
        machine="" if part is None else part.machine.name,
        serial="" if part is None else part.machine.serial,
        notes=table.notes,
        files=files,
    )


def _placed(correction: Correction, placing: Placing) -> PlacedCorrection:
    """Where the program stands. Raises RTC-TABLE where nobody says it, or the job and the caller say two things."""
    part, said = machine_of(correction), placing.origin_mm
    if part is not None:
        x, _, z = np.subtract(part.work_zero_mm, part.tool_mm).tolist()
        if said is not None and max(abs(said[0] - x), abs(said[1] - z)) > SAME_MM:
            raise Code.RTC_TABLE.refusal(
                f"the program's zero is at x {x:g} mm (radius), z {z:g} mm by [machine] of the job, and was given as "
                f"x {said[0]:g} mm, z {said[1]:g} mm",
                hint="leave the origin out: the job says it",
            )
        said = x, z
    if said is None:
        raise Code.RTC_TABLE.refusal(
            "where the program stands in the machine is not known: 0 of 2 coordinates of its zero are given",
            hint="give the machine coordinates of the program's zero, X as a radius: work offset plus tool offset",
        )
    return PlacedCorrection(said, placing.tip, placing.gate_mm)


def _program(correction: Correction) -> Program:
    """The given finish program as it was read then."""
    stated = correction.record.program
    unit = None if stated is None else stated.unit
    return read_program(correction.source_program, correction.dialect, correction.source_name, unit)


def _run(correction: Correction) -> Run:
    """How it was run, as far as the record says it: `process_table` refuses where it was run otherwise."""
    given = correction.record.options.get("parameters")
    return Run({str(name): float(value) for name, value in given.items()} if isinstance(given, dict) else {})


DEFAULT: Final = RealTimeLimits(((0.0, 0.0),) * 3)
NO_AXIS_MM: Final = (-1.0, 1.0)
"""Travel of an axis that the machine does not have: more than any correction, for nobody drives it."""

Ends = tuple[float, float]


@dataclass(frozen=True)
class ImageOptions:
    """Options that the source does not contain. `travel_mm` by axis: where a drive may be sent, the model's own where
    left out.

    `model`: beside a job or a correction. `serial`: of the machine that it must be for. `standing`: rotary axes that
    stand at 0. `origin_mm`, `tip`: as `Placing`. `db`: the store of a job or of corrections.
    """

    model: Path | None = None
    serial: str | None = None
    tool_mm: Vector = ZERO
    travel_mm: Mapping[str, Ends] = field(default_factory=dict)
    limit_mm: float = DEFAULT.limit_mm
    gate_mm: float = DEFAULT.gate_mm
    stated: SignalLimits = NOTHING
    standing: Collection[str] = ()
    origin_mm: Ends | None = None
    tip: int = 0
    db: Choice = None


@dataclass(frozen=True)
class MadeImage:
    """An image, what it asks for at most, what to know of it, and the files it was made from."""

    image: Image
    extent: Extent
    notes: tuple[str, ...]
    files: tuple[Path, ...]

    def write(self, path: Path) -> bytes:
        """Writes the file and gives its content. Raises RTC-IMAGE for names that are too long, and OUT errors."""
        content = image_to_bytes(self.image)
        write_all(path.parent, [(path.name, content)], inputs=self.files)
        return content


def make_image(source: FilePath, options: ImageOptions | None = None) -> MadeImage:
    """Makes the image of a model (JSON), of a job (TOML), or of a kept correction (record.json, or its record's id).

    Raises what reading and correcting refuse, MCH-MACHINE for another machine, RTC-MODEL, RTC-SIGNAL, RTC-TABLE, and
    RTC-LIMIT where somewhere in travel and ranges more would be requested than the limit allows.
    """
    options, path = options or ImageOptions(), Path(source)
    table = None if _is_model(path) else _table(path, options)
    model_file = path if table is None else options.model or _model_of(table)
    known = None if model_file is None else ModelFile(read_model(model_file), model_file)
    _check_model(table, known)
    _require_used(known, table, options)
    if known is not None:
        with in_file(known.file):
            require_serial(known.model, options.serial)
    image = _image(known, table, options)
    extent = extent_of(image)
    largest, limit = (abs(v) * UM_PER_MM for v in (extent.whole.correction_mm, image.limits.limit_mm))
    if largest > limit:
        raise Code.RTC_LIMIT.refusal(
            f"a correction of {largest:.1f} µm along {where_in_words(extent.whole, image)} is beyond the limit of "
            f"{limit:g} µm: the component would fault there",
            hint="narrow the travel or the ranges of signals to what is used, look at the model, or raise the limit",
            override="--limit-um",
            values={"largest_um": largest, "limit_um": limit},
        )
    _require_reachable(image)
    files = (*((path,) if path.is_file() else ()), *(table.files if table else ()), *((known.file,) if known else ()))
    return MadeImage(image, extent, tuple(_notes(known, table, options, image)), files)


def _require_reachable(image: Image) -> None:
    """Raises RTC-TABLE for a table with rows that the drives cannot be sent to."""
    if not image.blocks:
        return
    lines = np.concatenate([np.full(len(block.rows), block.line) for block in image.blocks])
    rows = np.concatenate([block.rows for block in image.blocks])
    drive = rows[:, :2] + rows[:, 2:]
    low, high = np.array([image.limits.travel_mm[0], image.limits.travel_mm[2]]).T
    beyond = np.maximum(low - drive, drive - high)
    outside = int(np.count_nonzero(np.any(beyond > TRAVEL_TOLERANCE_MM, axis=1)))
    if outside:
        row, axis = np.unravel_index(int(beyond.argmax()), beyond.shape)
        raise Code.RTC_TABLE.refusal(
            f"{outside} of {len(rows)} rows of the table are outside of the drives' travel: in line {lines[row]} of "
            f"the program {'XZ'[axis]} goes to {drive[row, axis]:.3f} mm, its travel is {low[axis]:g} to "
            f"{high[axis]:g} mm",
            hint="correct the program's zero (--origin, X as a radius, or [machine] of the job) or --travel",
        )


def _is_model(path: Path) -> bool:
    """Returns True for a model; else it is a job, a record, or the id of one."""
    return path.suffix.lower() == ".json" and not path.name.endswith("record.json")


def _table(path: Path, options: ImageOptions) -> CorrectedProgram:
    placing = Placing(options.origin_mm, options.tip, options.gate_mm)
    if path.suffix.lower() == ".toml":
        return table_of_job(path, placing, Keeping(options.db))
    record = read_record(path).id if path.is_file() else str(path)
    return table_of_record(record, placing, options.db)


def _model_of(table: CorrectedProgram) -> Path | None:
    """The model that the job names, among its files."""
    if not table.model_sha256:
        return None
    return next((f for f in table.files if f.is_file() and sha256_of(f.read_bytes()) == table.model_sha256), None)


def _check_model(table: CorrectedProgram | None, model: ModelFile | None) -> None:
    """A correction that counts on a model needs that one. Raises RTC-TABLE."""
    if table is None or not table.model_sha256:
        return
    if model is None or model.sha256 != table.model_sha256:
        given = "none is given" if model is None else f"{model.file.name!r} has {model.sha256[:16]}…"
        raise Code.RTC_TABLE.refusal(
            f"the correction counts on the model with sha256 {table.model_sha256[:16]}… in real time; {given}",
            hint="give the model of the job's table [machine]: --model MODEL.json",
        )


def _require_used(model: ModelFile | None, table: CorrectedProgram | None, options: ImageOptions) -> None:
    """Raises RTC-SIGNAL and RTC-TABLE for options that the image would not hold."""
    stated = sorted({*options.stated.ranges, *options.stated.steps})
    if model is None and stated:
        raise Code.RTC_SIGNAL.refusal(
            f"a range or a step is stated for {', '.join(stated)}; the image holds a table alone, which needs none",
            hint="leave --range and --step out, or give the model: --model MODEL.json",
            values={"signals": stated},
        )
    of_model = {"--tool": options.tool_mm != ZERO, "--standing": bool(options.standing)}
    of_table = {"--origin": options.origin_mm is not None, "--tip": options.tip != 0}
    for there, given, other, given_by in (
        (model, of_model, "table", "give the model: --model MODEL.json"),
        (table, of_table, "model", "make the image of a job or a record, with --model MODEL.json"),
    ):
        names = " and ".join(name for name, stated in given.items() if stated)
        if there is None and names:
            raise Code.RTC_TABLE.refusal(
                f"{names} is stated; the image holds a {other} alone, which does not depend on it",
                hint=f"leave {names} out, or {given_by}",
            )


def _image(model: ModelFile | None, table: CorrectedProgram | None, options: ImageOptions) -> Image:
    bank: Bank | None = None
    if model is not None:
        with in_file(model.file):
            signals = signals_of(model.model, options.stated)
            bank = bank_of(model.model, options.tool_mm, signals, options.standing)
    limits = RealTimeLimits(_travel(model, options), options.limit_mm, options.gate_mm)
    machine, serial = _machine(model, table, options)
    identity = Identity(machine, serial, model.sha256 if model else "")
    if table is None:
        return Image(identity, limits, bank)
    named = Identity(
        machine=machine,
        serial=serial,
        model_sha256=identity.model_sha256,
        program=Path(table.program).name,
        program_sha256=table.program_sha256,
        record=table.record,
    )
    return Image(named, limits, bank, table.blocks)


def _machine(model: ModelFile | None, table: CorrectedProgram | None, options: ImageOptions) -> tuple[str, str]:
    """Name and serial number: of the model, else of the correction, else the serial that is stated."""
    if model is not None:
        return model.model.machine.name, model.model.machine.serial
    name, serial = (table.machine, table.serial) if table else ("", "")
    return name, serial or options.serial or ""


def _travel(model: ModelFile | None, options: ImageOptions) -> tuple[Ends, Ends, Ends]:
    """Returns the travel of X, Y, Z; 0 for a missing axis. Raises RTC-MODEL: a travel not stated or without end."""
    chain = model.model.machine.chain if model else None
    there = [a for a in "XYZ" if a in chain.order] if chain else ["X", "Z"]
    found = {a: options.travel_mm.get(a, chain.axis(a).travel if chain else (1.0, 0.0)) for a in there}
    bad = [axis for axis, (low, high) in found.items() if not -1e6 <= low < high <= 1e6]
    bad += [axis for axis in options.travel_mm if axis not in (there if chain else "XYZ")]
    if bad:
        raise Code.RTC_MODEL.refusal(
            f"the travel of {len(bad)} axes is not known: {', '.join(bad)}",
            hint="give what MIN_LIMIT and MAX_LIMIT of the INI say, in mm, X of a lathe as a radius",
            override=" ".join(f"--travel {axis}=LOW,HIGH" for axis in bad),
            values={"axes": bad},
        )
    x, y, z = ({**options.travel_mm, **found}.get(axis, NO_AXIS_MM) for axis in "XYZ")
    return x, y, z


def _notes(
    model: ModelFile | None, table: CorrectedProgram | None, options: ImageOptions, image: Image
) -> Iterator[str]:
    """Returns notes on the run that the image itself does not hold."""
    if table is not None:
        yield from table.notes
        if model is not None and not table.model_sha256:
            yield (
                f"the correction was made without a model: semi-finish cut and touches were made with "
                f"{model.file.name} in force, or the machine's error would be taken out twice"
            )
    if model is None:
        return
    for name in options.standing:
        yield f"{name} has to stand at 0 as long as the image is in use: nothing in the servo thread looks at it"
    identified = model.model.identified
    asked = {s.name: (s.low, s.high) for s in (image.bank.signals if image.bank else ())}
    asked |= dict(zip("XYZ", image.limits.travel_mm, strict=True))
    for name, (low, high) in asked.items():
        if name in identified and not identified[name][0] <= low < high <= identified[name][1]:
            ends = identified[name]
            yield f"{name} may go from {low:g} to {high:g}; the model was found from {ends[0]:g} to {ends[1]:g}"
