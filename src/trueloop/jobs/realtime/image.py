"""From a machine's model, a job or a stored correction to the image of the real-time corrector."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.realtime.corrected_job import CorrectedProgram, Placing, table_of_job, table_of_record
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.store.where import Choice
from trueloop.machine.model.chain import ZERO, Vector
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.validity import require_serial
from trueloop.realtime.bank import NOTHING, Stated, bank_of, signals_of
from trueloop.realtime.image import Bank, Identity, Image, RealTimeLimits
from trueloop.realtime.largest import Extent, extent_of
from trueloop.report.realtime.image_summary import where_in_words
from trueloop.units import UM_PER_MM

DEFAULT: Final = RealTimeLimits(((0.0, 0.0),) * 3)
NO_AXIS_MM: Final = (-1.0, 1.0)
"""Travel of an axis that the machine does not have: more than any correction, for nobody drives it."""

Ends = tuple[float, float]


@dataclass(frozen=True)
class ImageOptions:
    """What the source does not say. `travel_mm` by axis: where a drive may be sent, the model's own where left out.

    `model`: beside a job or a correction. `serial`: of the machine that it must be for. `standing`: rotary axes that
    stand at 0. `origin_mm`, `tip`: as `Placing`. `db`: the store of a job or of corrections.
    """

    model: Path | None = None
    serial: str | None = None
    tool_mm: Vector = ZERO
    travel_mm: Mapping[str, Ends] = field(default_factory=dict)
    limit_mm: float = DEFAULT.limit_mm
    gate_mm: float = DEFAULT.gate_mm
    stated: Stated = NOTHING
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
    known = None if model_file is None else _Model(read_model(model_file), model_file)
    _check_model(table, known)
    if known is not None:
        with in_file(known.file):
            require_serial(known.model, options.serial)
    image = _image(known, table, options)
    extent = extent_of(image)
    _check_limit(image, extent)
    files = (*((path,) if path.is_file() else ()), *(table.files if table else ()), *((known.file,) if known else ()))
    return MadeImage(image, extent, tuple(_notes(known, table, options, image)), files)


@dataclass(frozen=True)
class _Model:
    model: MachineModel
    file: Path

    @property
    def sha256(self) -> str:
        return sha256_of(self.file.read_bytes())


def _is_model(path: Path) -> bool:
    """Whether it is a model; else it is a job, a record, or the id of one."""
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


def _check_model(table: CorrectedProgram | None, known: _Model | None) -> None:
    """A correction that counts on a model needs that one. Raises RTC-TABLE."""
    if table is None or not table.model_sha256:
        return
    if known is None or known.sha256 != table.model_sha256:
        given = "none is given" if known is None else f"{known.file.name!r} has {known.sha256[:16]}…"
        raise TrueloopError(
            Code.RTC_TABLE,
            f"the correction counts on the model with sha256 {table.model_sha256[:16]}… in real time; {given}",
            hint="give the model of the job's table [machine]: --model MODEL.json",
        )


def _image(known: _Model | None, table: CorrectedProgram | None, options: ImageOptions) -> Image:
    bank: Bank | None = None
    if known is not None:
        with in_file(known.file):
            signals = signals_of(known.model, options.stated)
            bank = bank_of(known.model, options.tool_mm, signals, options.standing)
    limits = RealTimeLimits(_travel(known, options), options.limit_mm, options.gate_mm)
    machine, serial = _machine(known, table, options)
    identity = Identity(machine, serial, known.sha256 if known else "")
    if table is None:
        return Image(identity, limits, bank)
    named = Identity(
        machine, serial, identity.model_sha256, Path(table.program).name, table.program_sha256, table.record
    )
    return Image(named, limits, bank, table.blocks)


def _machine(known: _Model | None, table: CorrectedProgram | None, options: ImageOptions) -> tuple[str, str]:
    """Name and serial number: of the model, else of the correction, else the serial that is stated."""
    if known is not None:
        return known.model.machine.name, known.model.machine.serial
    name, serial = (table.machine, table.serial) if table else ("", "")
    return name, serial or options.serial or ""


def _travel(known: _Model | None, options: ImageOptions) -> tuple[Ends, Ends, Ends]:
    """Of X, Y, Z. An axis that the machine does not have stands at 0 and drives nothing: it may be asked for any.

    Raises RTC-MODEL for a travel that nobody states, or that has no end.
    """
    chain = known.model.machine.chain if known else None
    there = [a for a in "XYZ" if a in chain.order] if chain else ["X", "Z"]
    found = {a: options.travel_mm.get(a, chain.axis(a).travel if chain else (1.0, 0.0)) for a in there}
    bad = [axis for axis, (low, high) in found.items() if not -1e6 <= low < high <= 1e6]
    bad += [axis for axis in options.travel_mm if axis not in (there if chain else "XYZ")]
    if bad:
        raise TrueloopError(
            Code.RTC_MODEL,
            f"the travel of {len(bad)} axes is not known: {', '.join(bad)}",
            hint="give what MIN_LIMIT and MAX_LIMIT of the INI say, in mm, X of a lathe as a radius",
            override=" ".join(f"--travel {axis}=LOW,HIGH" for axis in bad),
            values={"axes": bad},
        )
    x, y, z = ({**options.travel_mm, **found}.get(axis, NO_AXIS_MM) for axis in "XYZ")
    return x, y, z


def _check_limit(image: Image, extent: Extent) -> None:
    largest, limit = (abs(v) * UM_PER_MM for v in (extent.whole.correction_mm, image.limits.limit_mm))
    if largest > limit:
        raise TrueloopError(
            Code.RTC_LIMIT,
            f"a correction of {largest:.1f} µm along {where_in_words(extent.whole, image)} is beyond the limit of "
            f"{limit:g} µm: the component would fault there",
            hint="narrow the travel or the ranges of signals to what is used, look at the model, or raise the limit",
            override="--limit-um",
            values={"largest_um": largest, "limit_um": limit},
        )


def _notes(known: _Model | None, table: CorrectedProgram | None, options: ImageOptions, image: Image) -> Iterator[str]:
    """What one has to know beyond what the image holds."""
    if table is not None:
        yield from table.notes
        if known is not None and not table.model_sha256:
            yield (
                f"the correction was made without a model: semi-finish cut and touches were made with "
                f"{known.file.name} in force, or the machine's error would be taken out twice"
            )
    if known is None:
        return
    for name in options.standing:
        yield f"{name} has to stand at 0 as long as the image is in use: nothing in the servo thread looks at it"
    identified = known.model.identified
    asked = {s.name: (s.low, s.high) for s in (image.bank.signals if image.bank else ())}
    asked |= dict(zip("XYZ", image.limits.travel_mm, strict=True))
    for name, (low, high) in asked.items():
        if name in identified and not identified[name][0] <= low < high <= identified[name][1]:
            ends = identified[name]
            yield f"{name} may go from {low:g} to {high:g}; the model was found from {ends[0]:g} to {ends[1]:g}"
