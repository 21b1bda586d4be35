"""The correction with which a surface's measured parts were cut: stated in its job, or required there."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from trueloop.domain.life import Ran
from trueloop.domain.option import latest_time
from trueloop.domain.record import CutWith, Product, Record, check_same_program, sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.record_file import read_record
from trueloop.jobs.turned.cut_with import GIVEN, folders_near, require_later
from trueloop.loops.surface.correction import SurfaceInputs, displacements_of, faces_of

HINT: Final = 'gauging.cut_with = "given", or the path to the record.json of the correction in force'


def with_cut(inputs: SurfaceInputs, job: Path, stated: str, nominal: Path) -> SurfaceInputs:
    """Returns inputs with the correction that cut the parts, as the job states it: "", "given" or a record's path.

    Raises REC errors, CMP-CUT-WITH for a record of something else or of these very parts, CMP-OTHER-PROGRAM for one of
    another program or surface, MSR-OLD for parts that were measured before it was made.
    """
    if stated in ("", GIVEN):
        return inputs
    file = job.parent / stated
    record = read_record(file)
    with in_file(job):
        _require_of_job(record, inputs, nominal)
        require_later(record, inputs.inspections, job, time_needed=False)
        own = {inspection.sha256 for inspection in record.inspections}
        for inspection in inputs.inspections:
            if inspection.sha256 in own:
                raise _refused(
                    record,
                    f"was made from part {inspection.part.serial!r}, which is stated to be cut with it",
                    "name in gauging.points the parts that were cut with it alone",
                )
        try:
            numbers = faces_of(record)
            places = [numbers.index(face.face) for face in inputs.faces] if inputs.further else [0]
            terms = [displacements_of(record, k) for k in places]
        except (LookupError, TypeError, ValueError) as error:
            raise Code.REC_FILE.refusal(
                f"{file.name!r} does not hold a surface's pattern: {type(error).__name__}: {error}",
                hint="restore the file as trueloop wrote it",
                place=Place(str(file)),
            ) from error
        ran = _program_beside(file, record)
        if ran is not None and inputs.program_sha256 is not None:
            check_same_program(ran, inputs.program_sha256)
    sha256 = inputs.program_sha256 or ("" if ran is None else sha256_of(ran))
    cut_with = CutWith(Ran.CORRECTED, record.id, sha256.lower())
    further = tuple(replace(face, in_force=own) for face, own in zip(inputs.further, terms[1:], strict=True))
    ran_with = sha256 or None
    return replace(inputs, cut_with=cut_with, in_force=terms[0], program_sha256=ran_with, further=further)


def require_stated(inputs: SurfaceInputs, job: Path, output: Path, nominal: Path) -> None:
    """Raises CMP-CUT-WITH where corrections of the surface beside the job may have cut its parts.

    Those count that are of the job's surface and program, were made before the parts were measured, as far as that is
    known, and not from all of these parts.
    """
    possible = list(_possible(inputs, job, output, nominal))
    if possible:
        raise Code.CMP_CUT_WITH.refusal(
            "what cut the measured parts is not stated: the nominal surface and program as they are, or a correction "
            f"of them: {', '.join(possible[:4])}",
            hint=f"state {HINT}",
            place=Place(str(job)),
            values={"corrections": possible},
        )


def _possible(inputs: SurfaceInputs, job: Path, output: Path, nominal: Path) -> Iterator[str]:
    today = inputs.inspections[inputs.earlier :]
    parts, own = {inspection.sha256 for inspection in today}, job.parent.resolve()
    measured_at = inputs.measured_at
    homes = dict.fromkeys([own, output.resolve()])
    for file in sorted({file for one in folders_near(list(homes)) for file in one.glob("record*.json")}):
        try:
            record = read_record(file)
            _require_of_job(record, inputs, nominal)
        except (OSError, TrueloopError):
            continue
        if parts <= {inspection.sha256 for inspection in record.inspections}:
            continue
        if measured_at is None or datetime.fromisoformat(record.made_at).astimezone(UTC) <= latest_time(measured_at):
            yield f"{named_in(own, file)} ({record.id})"


def named_in(folder: Path, file: Path) -> str:
    """Names a file as a job in a folder does: relative to it, where it lies below it."""
    return file.relative_to(folder).as_posix() if file.is_relative_to(folder) else file.as_posix()


def _require_of_job(record: Record, inputs: SurfaceInputs, nominal: Path) -> None:
    if record.product is not Product.SURFACE:
        raise _refused(record, "is not a surface's", HINT)
    surface, hashes = sha256_of(nominal.read_bytes()), set(record.inputs_sha256.values())
    if surface not in hashes:
        raise _refused(record, f"was not made from the nominal surface {nominal.name!r}", "name that in surface.file")
    corrected, named = faces_of(record), [face.face for face in inputs.faces]
    if set(corrected) != set(named) and len(corrected) + len(named) > 2:
        hint = f"surface.face = {corrected[0] if len(corrected) == 1 else corrected}, those that it corrects"
        raise _refused(record, f"corrects faces {corrected}, not {named}", hint)
    if inputs.program is None:
        return
    given = sha256_of(inputs.program.source)
    expected = "" if record.program is None else record.program.sha256
    if expected != given:
        of = f"with sha256 {expected[:16]}…" if expected else "none: it wrote the surface alone"
        raise Code.CMP_OTHER_PROGRAM.refusal(
            f"correction {record.id} is of another program ({of}); this one has {given[:16]}…",
            hint="name in program.finish the program that the correction was made from; a program that was made on the "
            'corrected surface holds it already: gauging.cut_with = "given"',
            values={"expected_sha256": expected, "found_sha256": given},
        )


def _program_beside(file: Path, record: Record) -> bytes | None:
    """Returns the corrected program beside a record, known by its mark; None where there is none."""
    for one in sorted(file.parent.glob("corrected.*")):
        content = one.read_bytes() if one.is_file() else b""
        if record.id.encode() in content and one.suffix.lower() not in (".step", ".iges"):
            return content
    return None


def _refused(record: Record, why: str, hint: str) -> TrueloopError:
    return Code.CMP_CUT_WITH.refusal(f"correction {record.id} {why}", hint=hint, values={"corrections": [record.id]})
