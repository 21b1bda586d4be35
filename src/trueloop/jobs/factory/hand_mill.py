"""A milled part that a person measures: shown by its program, and answered with the numbers to enter at the control."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from trueloop.described import filled_from
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError
from trueloop.factory.views.by_hand import Expectation, MilledEntries, MilledFeatureShown, MilledPart, MilledSize
from trueloop.formats.toml_tables import toml_keys, toml_value
from trueloop.jobs.factory.by_hand import question_of
from trueloop.jobs.factory.hand_job import JOB, MAPPING, SHEET, AskedMilled, MilledReadings, MillJob
from trueloop.jobs.factory.job_folder import unnamed_folder, without_folder
from trueloop.jobs.factory.uploads import HandedFile, remarked, safe_name, upload_of
from trueloop.jobs.milled import RECORD, entries_for_next_part, entry_lines, proposal_notes, read_milled, record_of
from trueloop.jobs.milled_new import ProposedJob, new_milled_job
from trueloop.jobs.store.keep_facts import keep_facts, texts_of
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.milled.entries import ExpectedSize
from trueloop.milled.feature import PAIRS, ROUND, MilledFeature
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store
from trueloop.tolerances.iso2768 import Edge
from trueloop.tolerances.text import limits_of
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import wording


@dataclass(frozen=True)
class MilledAnswer:
    """The answer, the texts of the files that were made, by name, and the inspections of parts with serial numbers."""

    shown: MilledEntries
    files: Mapping[str, str]
    inspections: tuple[Inspection, ...] = ()


@contextmanager
def mill_files(
    store: Store, part: AskedMilled, measured: MilledReadings | None, by: str, say: Texts
) -> Iterator[HandedFile]:
    """Yields the program in a temporary folder, with this account's measurement and record. Raises FAC-UNKNOWN."""
    program = upload_of(store, part.program, by)
    with unnamed_folder() as folder:
        names = {"program": f"program-{safe_name(program.name)}"}
        (folder / names["program"]).write_bytes(program.content)
        for of, sha in (("file", measured.file), ("entered", measured.entered)) if measured else ():
            if sha:
                upload = upload_of(store, sha, by)
                names[of] = f"{of}-{safe_name(upload.name)}"
                (folder / names[of]).write_bytes(upload.content)
        path = names.pop("program")
        name = part.name or Path(program.name).stem or "part"
        job = MillJob(part, name, measured, **names)
        yield HandedFile(
            str(folder / path), program.name, program.sha256, mill=job, language=say.language, unit=say.unit
        )


def milled_part(handed: HandedFile) -> MilledPart:
    """Returns the features that a program mills, and what to measure of them; a refusal stands in the view."""
    job = _of(handed)
    try:
        made = _new_job(handed)
    except TrueloopError as refused:
        refused = without_folder(refused, handed.file.parent)
        question = question_of(handed.file, job.part, refused)
        return MilledPart(job.name, problem=remarked(refused, handed.say), question=question)
    sizes = [size for feature in made.features for size, _ in _sizes(feature)]
    return MilledPart(
        job.name,
        dialect=made.dialect,
        unit="inch" if made.inch else "mm",
        features=tuple(
            filled_from(MilledFeatureShown, feature, at_mm=feature.place_mm, tool=f"T{feature.tool}")
            for feature in made.features
        ),
        sizes=tuple(replace(size, number=number) for number, size in enumerate(sizes, 1)),
        notes=made.notes,
    )


def milled_entries(handed: HandedFile) -> MilledAnswer:
    """Returns the numbers to enter before the next part, as `trueloop mill entries` does, with the files of the job.

    Raises what reading and proposing refuse; SRV-REQUEST for values beside a file, MSR-FEATURE for one of no size.
    """
    job, say = _of(handed), handed.say
    made = _new_job(handed)
    measured = job.measured
    assert measured is not None
    with made.file.open("a", encoding="utf-8") as file:
        file.write(_measured_keys(handed, made, measured))
    read = read_milled(made.file)
    found = entries_for_next_part(read)
    *entries, rms = entry_lines(read, found, say)
    shown = MilledEntries(
        entries=tuple(entries),
        rms=rms,
        expected=tuple(map(_expectation, found.expected)),
        notes=tuple(proposal_notes(read, found, say)),
        anything=bool(found.proposed),
    )
    texts = {
        name: made.file.with_name(name).read_text("utf-8")
        for name in (JOB, SHEET)
        if made.file.with_name(name).exists()
    }
    named = [one for one in read.inspections if one.part.serial]
    return MilledAnswer(
        shown,
        {RECORD: record_of(read, found).decode(), **texts},
        tuple(replace(one, part=Part(PartType(job.name), one.part.serial)) for one in named),
    )


def keep_milled(
    store: Store, part: AskedMilled, measured: MilledReadings, inspections: Sequence[Inspection], by: str
) -> bool:
    """Keeps measured parts, with their cut where no number had been entered before it; returns whether there are any.

    Raises STO-OTHER-PART, and what keeping refuses.
    """
    facts: list[Any] = [*texts_of([upload_of(store, part.program, by).content])]
    for inspection in inspections:
        require_file_of_part(store, inspection)
        facts += [inspection.part, inspection]
        if not measured.entered:
            cut = Cut(inspection.part, Stage.FINISH, program_sha256=part.program)
            facts += [cut, InspectionLink(inspection.identity, cut.identity)]
    if inspections:
        keep_facts(store, facts)
    return bool(inspections)


def _of(handed: HandedFile) -> MillJob:
    assert handed.mill is not None
    return handed.mill


def _new_job(handed: HandedFile) -> ProposedJob:
    job = _of(handed)
    part, folder = job.part, handed.file.parent
    keys = ("dialect", "unit", "parameters", "accept_unknown_words")
    return new_milled_job(
        handed.file,
        folder / JOB,
        reading={key: getattr(part, key) for key in keys},
        name=job.name,
        measured=folder / (job.file or SHEET),
        radius_mm=part.cutters,
        wear=part.wear,
    )


def _measured_keys(handed: HandedFile, made: ProposedJob, measured: MilledReadings) -> str:
    """The rest of the job's last table [[measured]], and a table of names; writes the sheet of typed values."""
    job, folder = _of(handed), handed.file.parent
    if job.file and measured.values:
        raise Code.SRV_REQUEST.refusal(
            wording("values of {n} sizes are given beside a file of measurements", n=len(measured.values)),
            hint=wording("give the values or the file of measurements, not both"),
        )
    keys = dict[str, object]()
    if job.file:
        keys = {"serial": measured.serial or None, "unit": measured.file_unit}
        if measured.mapping_toml:
            (folder / MAPPING).write_text(measured.mapping_toml, encoding="utf-8")
            keys["mapping"] = MAPPING
    else:
        (folder / SHEET).write_text(_sheet(made, measured), encoding="utf-8")
    if job.entered:
        keys["entered"] = [job.entered]
    names = {toml_value(name): feature for name, feature in measured.names.items() if name and feature}
    return "\n".join([*toml_keys(keys), "", *(["[names]", *toml_keys(names), ""] if names else [])])


def _sizes(one: MilledFeature) -> Iterator[tuple[MilledSize, tuple[Quantity, str]]]:
    """The sizes and coordinates that a feature shows, each with its quantity and axis in a file of readings."""

    def size(what: str, nominal_mm: float) -> MilledSize:
        return MilledSize(0, f"{one.name} {what}", one.name, what, nominal_mm)

    if one.kind in ROUND:
        yield size("diameter", one.size_mm), (Quantity.DIAMETER, "")
    if one.kind in PAIRS:
        yield size("width", one.size_mm), (Quantity.LENGTH, "")
    for k, axis in enumerate("xyz"):
        if one.coordinate_weights(np.eye(3)[k]) is not None:
            yield size(axis, one.place_mm[k]), (Quantity.POSITION, axis)


def _sheet(made: ProposedJob, measured: MilledReadings) -> str:
    """The typed values as a file of gauge readings, lengths in the program's unit."""
    per = MM_PER_INCH if made.inch else 1.0
    out = io.StringIO()
    u_um = measured.expanded_uncertainty_um
    out.write(f"# serial: {measured.serial}\n" + ("" if u_um is None else f"# expanded_uncertainty_um: {u_um!r}\n"))
    rows = csv.writer(out, lineterminator="\n")
    head = ("characteristic", "feature", "quantity", "axis", "nominal", "lower_limit", "upper_limit")
    rows.writerow((*head, "value_in" if made.inch else "value_mm"))
    sizes = {size.name: (size, as_read) for feature in made.features for size, as_read in _sizes(feature)}
    _require_known(sizes, (*measured.values, *measured.tolerances))
    for name, (size, (quantity, axis)) in sizes.items():
        text = measured.tolerances.get(name, "").strip()
        of = Quantity.LENGTH if axis else quantity
        limits = [limit / per for limit in limits_of(text, size.nominal_mm, of, Edge(0.0), per)] if text else ["", ""]
        known = (name, size.feature, quantity.value, axis, size.nominal_mm / per, *limits)
        rows.writerows((*known, value) for value in measured.values.get(name, ()))
    return out.getvalue()


def _require_known(sizes: Mapping[str, object], names: Sequence[str]) -> None:
    other = next((name for name in names if name not in sizes), None)
    if other is not None:
        raise Code.MSR_FEATURE.refusal(
            wording("the part has no size {name!r}", name=other),
            hint=wording("its sizes are: {sizes}", sizes=", ".join(sizes)),
            values={"feature": other},
        )


def _expectation(one: ExpectedSize) -> Expectation:
    def um(value_mm: float) -> float:
        return UM_PER_MM * value_mm

    nominal = one.seen.nominal_mm
    return Expectation(
        name=one.seen.name,
        measured_um=None if one.measured_mm is None else um(one.measured_mm),
        unchanged_um=um(one.unchanged.value - nominal),
        entered_um=um(one.changed.value - nominal),
        expanded_u_um=um(2.0 * one.changed.standard_u),
        probability_in=one.changed.probability_in,
    )
