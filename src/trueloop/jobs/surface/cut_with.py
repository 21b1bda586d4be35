"""The correction with which a surface's measured parts were cut: stated in its job, or asked for."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from difflib import get_close_matches
from glob import glob
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Ran
from trueloop.domain.option import latest_time
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import CutWith, Product, Record, check_same_program, sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.inspections.scan import is_scan, read_scan
from trueloop.formats.jobs.surface_job import SurfaceJobFile
from trueloop.formats.measurements.surface_csv import read_points
from trueloop.formats.record_file import read_record
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.surface import Surface, closest
from trueloop.jobs.turned.cut_with import GIVEN, folders_near, require_later
from trueloop.loops.surface.correction import SurfaceInputs, displacements_of, faces_of
from trueloop.surface.deviations.plausibility import refuse_unit
from trueloop.surface.deviations.points import MeasuredPoints, on_face
from trueloop.surface.on_face import Trim
from trueloop.surface.options import SurfaceOptions
from trueloop.units import MM_PER_INCH

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
            yield f"{_shown(file, own)} ({record.id})"


def _shown(file: Path, folder: Path) -> str:
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


def point_files(path: Path, job: SurfaceJobFile) -> list[Path]:
    """Returns the files named, patterns like parts/*.csv filled in, in the order of their names.

    Raises SRF-FILE for a pattern that no file is like, SRF-TWICE for two files of one name: parts go by it.
    """
    found: list[Path] = []
    for name in map(str, job.gauging.points):
        # Not `Path.glob`, which takes no absolute pattern.
        matching = sorted(glob(name, root_dir=path.parent, recursive=True)) if "*" in name else [name]  # noqa: PTH207
        if not matching:
            raise Code.SRF_FILE.refusal(
                f"no file is like {name!r}",
                hint="gauging.points names the files of the measured parts, relative to the job",
                place=Place(str(path)),
            )
        found += [path.parent / file for file in matching]
    by_name: dict[str, Path] = {}
    for file in found:
        if file.stem in by_name:
            raise Code.SRF_TWICE.refusal(
                f"two of {len(found)} parts are called {file.stem!r}: {str(by_name[file.stem])!r} and {str(file)!r}",
                hint="name every part's file once in gauging.points, and no two alike: results go by their names",
                place=Place(str(path)),
            )
        by_name[file.stem] = file
    # Raises JOB-KEY for a part to leave out that is not there: mistyped, it would be left in
    names = [file.stem for file in found]
    for left_out in options_from(SurfaceOptions, job).exclude:
        if left_out not in names:
            near = get_close_matches(left_out, names, n=1)
            raise Code.JOB_KEY.refusal(
                f"'model.exclude' names {left_out!r}, which is not one of the {len(names)} parts",
                hint=f"did you mean {near[0]!r}?" if near else f"the parts are {', '.join(names)}",
                place=Place(str(path)),
                values={"key": "model.exclude"},
            )
    return found


def require_measured_once(files: Sequence[Path], hashes: Mapping[Path, str]) -> None:
    """Raises SRF-TWICE for a copy under another name: it would count as a further part, and agree to the last digit."""
    by_hash: dict[str, Path] = {}
    for file in files:
        first = by_hash.setdefault(hashes[file], file)
        if first is not file:
            raise Code.SRF_TWICE.refusal(
                f"two of {len(files)} parts are one: {first.name!r} and {file.name!r} have the same bytes",
                hint="leave the copy out of gauging.points",
                place=Place(str(file)),
            )


@dataclass(frozen=True, eq=False)
class MeasuredFace:
    """A face on which parts were measured: its surface, which places are cut away, its number beside others."""

    surface: Surface
    trim: Trim | None
    number: int | None = None

    def measured(self, scan: MeasuredPoints, normal: Array | None, farthest_mm: float) -> MeasuredPoints:
        """Returns the points of a scan that are on the face. Raises SRF-OFF, SRF-UNIT, SRF-FILE."""
        words = "the face" if self.number is None else f"face {self.number}"
        with in_file(scan.file):
            try:
                return on_face(self.surface, scan, normal, farthest_mm, self.trim, words)
            except TrueloopError as refused:
                if refused.code is Code.SRF_OFF:
                    error = closest(self.surface, scan.points_mm).distance_mm - scan.ball_radius_mm
                    refuse_unit(self.surface, scan.points_mm, error, scan.ball_radius_mm, scan.name)
                raise


def read_measured(path: Path, job: SurfaceJobFile, faces: Sequence[MeasuredFace]) -> list[MeasuredPoints]:
    """Reads a part's measured points, named as its file, for each face; of a scan, and where there are several faces,
    those on it.

    Raises SRF-FILE, for a scan SRF-UNIT and SRF-OFF too, JOB-KEY where the job does not state its frame, and SRF-GRID
    for a grid over several faces.
    """
    gauging, farthest_mm = job.gauging, options_from(SurfaceOptions, job).farthest_mm
    if not is_scan(path):
        read = read_points(path)
        points = MeasuredPoints(
            points_mm=read.points_mm,
            ball_radius_mm=gauging.ball_radius_mm,
            shape=read.shape,
            name=path.stem,
            file=str(path),
            lines=read.lines,
        )
        if len(faces) == 1:
            return [points]
        if read.shape is not None:
            raise Code.SRF_GRID.refusal(
                f"{path.name!r} is a grid of {read.shape[0]} × {read.shape[1]} points, and surface.face names "
                f"{len(faces)} faces",
                hint="leave out row and column: points then go to the faces that they are on",
                place=Place(str(path)),
            )
        return [face.measured(points, None, farthest_mm) for face in faces]
    if "alignment" not in gauging.model_fields_set:
        raise Code.JOB_KEY.refusal(
            f"'gauging.alignment' is not stated, and {path.name!r} is a scan: 0 of its lines say how it was aligned",
            hint='gauging.alignment = "best-fit" where software aligned it, "datum" where it is in the part\'s datums',
            place=Place(str(path)),
            values={"key": "gauging.alignment"},
        )
    factor = None if gauging.unit is None else MM_PER_INCH if gauging.unit == "inch" else 1.0
    scan = read_scan(path, factor, gauging.columns)
    ball_radius_mm, at = gauging.ball_radius_mm, (path.stem, str(path), scan.lines)
    points = MeasuredPoints(scan.points_mm, ball_radius_mm, None, *at, rounding_mm=scan.rounding_mm)
    return [face.measured(points, scan.normal, farthest_mm) for face in faces]


def inspection_of(job: SurfaceJobFile, measured: Sequence[MeasuredPoints], sha256: str) -> Inspection:
    """Makes the inspection of a part measured on faces; its points stay in the file of that hash."""
    return Inspection(
        part=Part(PartType(job.name), measured[0].name),
        measured="CMM points",
        sha256=sha256,
        count=sum(int(np.isfinite(of_face.points_mm).all(axis=1).sum()) for of_face in measured),
        frame="part" if job.gauging.alignment == "datum" else "device",
        measured_at=job.gauging.measured_at,
        ball_radius_mm=measured[0].ball_radius_mm,
    )
