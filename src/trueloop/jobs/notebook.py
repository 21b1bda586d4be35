"""A shop's records for notebooks and scripts: inspections into a store; series, charts, causes and certificates out."""

from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from trueloop.errors import Code
from trueloop.extras import install_command
from trueloop.formats.input_file import FilePath

if TYPE_CHECKING:  # each is slow to import, and a notebook rarely needs all
    from trueloop.domain.inspection import Inspection
    from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts
    from trueloop.jobs.diagnose.diagnosed import DiagnosisOptions
    from trueloop.jobs.measure.next_measurement import NextOf
    from trueloop.jobs.series import AddedFile, Adding
    from trueloop.loops.monitor.chart import ChartOptions
    from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
    from trueloop.report.monitor.certificate import CertificateShape
    from trueloop.report.monitor.chart_values import ChartsShape
    from trueloop.report.series.values import SeriesShape
    from trueloop.storage.store import Store


def read_inspections(file: FilePath, stated: "StatedFacts | None" = None) -> "MeasuredFile":
    """Reads a file of a gauge, a measuring machine or a control: its `inspections`, one for each part or run.

    `stated`: unit and mapping, where the file does not state them. Lengths are mm. Raises MSR and TCH errors.

    >>> file = trueloop.read_inspections(trueloop.example("series/first-three.csv"))
    >>> [(one.part.serial, len(one.readings)) for one in file.inspections]
    [('101', 4), ('102', 4), ('103', 4)]
    """
    from trueloop.formats.inspections.known import read_measured_file
    from trueloop.formats.inspections.measured_file import StatedFacts

    return read_measured_file(Path(file), stated or StatedFacts())


def make_store(place: FilePath) -> "Store":
    """Makes an empty store: a file, or the URL of a database. Raises STO-EXISTS where there is anything already.

    >>> trueloop.make_store("shop.db").where
    'shop.db'
    """
    from trueloop.jobs.store.opened import made

    return made(str(place))


def open_store(place: FilePath, *, read_only: bool = False) -> "Store":
    """Opens a store by its file or URL. Raises STO errors.

    >>> made = trueloop.make_store("shop.db")
    >>> trueloop.open_store("shop.db", read_only=True).where
    'shop.db'
    """
    from trueloop.jobs.store.opened import opened

    return opened(str(place), read_only=read_only)


def add_inspections(store: "Store", files: Sequence[FilePath], adding: "Adding | None" = None) -> "list[AddedFile]":
    """Keeps inspections of finished parts, each file whole or not at all. Raises MSR, SER and STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> (added,) = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> added.part_type, added.new, added.sizes
    ('SHAFT', ('101', '102', '103'), 12)
    """
    from trueloop.jobs.series import Adding, add_files

    return add_files(store, [Path(file) for file in files], adding or Adding())


def stored_inspections(store: "Store", part_type: str | None = None) -> "list[Inspection]":
    """Returns the inspections of a part type, of all types without one, in the order in which they were kept.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> [one.part.serial for one in trueloop.stored_inspections(store, "SHAFT")]
    ['101', '102', '103']
    """
    from trueloop.domain.inspection import Inspection
    from trueloop.storage.store import find

    kept = [stored.value for stored in find(store, Inspection)]
    return [inspection for inspection in kept if part_type in (None, inspection.part.part_type.name)]


def follow_series(store: "Store", part_type: str | None = None) -> "SeriesShape":
    """Returns the series of a part type, the only one without a name: each characteristic over the parts, in µm.

    Raises SER-UNKNOWN.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> journal = trueloop.follow_series(store).characteristics[0]
    >>> journal.characteristic, [part.after_um for part in journal.parts]
    ('journal', [26.0, 29.0, 27.0])
    """
    from trueloop.factory.book import only_type, read_book
    from trueloop.jobs.series import status_of
    from trueloop.loops.post_process.series import SeriesOptions

    options = SeriesOptions()
    return status_of(read_book(store, part_type or only_type(store), options), options)


def control_charts(
    store: "Store",
    part_type: str | None = None,
    characteristics: Sequence[str] = (),
    options: "ChartOptions | None" = None,
) -> "ChartsShape":
    r"""Returns the control charts of characteristics, () all: limits, alarms with likely causes, capability.

    Raises SER-UNKNOWN, MON-NONE and MON-FEW.

    >>> store = trueloop.make_store("shop.db")
    >>> rows = [f"SHAFT,{k},seat,seat,diameter,mm,30,29.98,30.02,{30.002 + 0.001 * (k * 3 % 7)}" for k in range(20)]
    >>> head = "part name,serial,characteristic,feature,quantity,unit,nominal,lower limit,upper limit,actual"
    >>> written = Path("seats.csv").write_text("\n".join([head, *rows]))
    >>> added = trueloop.add_inspections(store, ["seats.csv"])
    >>> seat = trueloop.control_charts(store, characteristics=["seat"]).characteristics[0]
    >>> len(seat.parts), seat.segments[0].centre, seat.alarms  # µm
    (20, 4.95, [])
    """
    from trueloop.jobs.monitor.charts import charts_of
    from trueloop.loops.monitor.chart import ChartOptions

    return charts_of(store, part_type, characteristics, options or ChartOptions())


def certify_part(
    store: "Store", serial: str, part_type: str | None = None, *, standard_u_um: float | None = None, who: str = ""
) -> "CertificateShape":
    """Returns the certificate of a part: values, gauges, verdicts, and the corrections in force when it was cut.

    `standard_u_um` is the standard uncertainty of readings that state none. Raises MON-NONE.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> trueloop.certify_part(store, "101", standard_u_um=1.0, who="K. Roth").outcome
    'does not conform'
    """
    from trueloop.jobs.monitor.certificate import certificate_of

    return certificate_of(store, serial, part_type, standard_u_um, who)


def series_causes(store: "Store", options: "DiagnosisOptions | None" = None) -> "list[SeriesDiagnosisShape]":
    """Returns the causes of what the parts of a type have in common, one diagnosis for each edge that cuts them.

    Raises DIA and STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> (causes,) = trueloop.series_causes(store)
    >>> causes.causes.candidates[0].name, round(causes.causes.candidates[0].probability, 2)
    ('tool offset set wrongly', 0.42)
    """
    from trueloop.jobs.diagnose.diagnosed import DiagnosisOptions, every_series

    return every_series(store, options or DiagnosisOptions())


def part_causes(store: "Store", serial: str, options: "DiagnosisOptions | None" = None) -> "list[PartDiagnosisShape]":
    """Returns the causes of one part's errors, one diagnosis for each edge that cut it. Raises DIA and STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> (causes,) = trueloop.part_causes(store, "102")
    >>> [(error.feature, error.value_um) for error in causes.part.errors["CMM"]]  # of the radius
    [('journal-24', 14.5), ('seat-30', 13.5), ('seat-36', 15.5)]
    """
    from trueloop.jobs.diagnose.diagnosed import DiagnosisOptions, parts

    return parts(store, serial, options or DiagnosisOptions())


def next_measurements(job: FilePath, count: int = 5) -> "NextOf":
    """Plans at most `count` measurements of a job's part: those that lower the doubt most a minute.

    Raises JOB, NC, GEO, TCH, MSR, TOL, STO and EDG errors.

    >>> planned = trueloop.next_measurements(trueloop.example("shaft/job.toml"), 2)
    >>> [measurement.name for measurement in planned.plan.chosen]
    ['end-face 4 (cmm)', 'cone 4 (cmm)']
    """
    from trueloop.jobs.measure.next_measurement import next_of_job

    return next_of_job(Path(job), count)


def to_frame(rows: Iterable[object]) -> Any:
    """Returns a table of rows, results or values with named fields, as a DataFrame of pandas, of polars without it.

    A field of fields becomes columns `field.name`; units are in the columns' names, as in the fields'. Raises
    OUT-FRAME where neither is installed.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> journal = trueloop.follow_series(store).characteristics[0]
    >>> trueloop.to_frame(journal.parts)[["serial", "after_um"]].values.tolist()
    [['101', 26.0], ['102', 29.0], ['103', 27.0]]
    """
    for library in ("pandas", "polars"):
        try:
            frame = import_module(library).DataFrame
        except ImportError:
            continue
        return frame([_columns(row) for row in rows])
    raise Code.OUT_FRAME.refusal(
        "a DataFrame needs a library, and neither 'pandas' nor 'polars' can be loaded", hint=install_command("notebook")
    )


def _columns(row: object, of: str = "") -> dict[str, object]:
    """Returns the named values of a row; those of a value within it with its name before theirs."""
    if isinstance(row, BaseModel):
        named: dict[str, object] = {name: getattr(row, name) for name in type(row).model_fields}
    elif is_dataclass(row) and not isinstance(row, type):
        named = {field.name: getattr(row, field.name) for field in fields(row)}
    else:
        named = dict(row) if isinstance(row, dict) else {"value": row}
    columns = dict[str, object]()
    for name, value in named.items():
        nested = isinstance(value, BaseModel) or (is_dataclass(value) and not isinstance(value, type))
        columns |= _columns(value, f"{of}{name}.") if nested else {f"{of}{name}": value}
    return columns
