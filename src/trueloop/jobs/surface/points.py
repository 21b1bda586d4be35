"""The files of measured parts that a surface's job names: every part once, under a name of its own."""

from collections.abc import Mapping, Sequence
from glob import glob
from pathlib import Path

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.inspections.scan import is_scan, read_scan
from trueloop.formats.jobs.surface_job import SurfaceJobFile
from trueloop.formats.measurements.surface_csv import read_points
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.surface import closest
from trueloop.loops.surface.correction import SurfaceInputs
from trueloop.surface.deviations.points import MeasuredPoints, on_face, refuse_unit
from trueloop.surface.options import SurfaceOptions
from trueloop.units import MM_PER_INCH
from trueloop.wording import did_you_mean


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
            raise Code.JOB_KEY.refusal(
                f"'model.exclude' names {left_out!r}, which is not one of the {len(names)} parts",
                hint=did_you_mean(left_out, names) or f"the parts are {', '.join(names)}",
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


def read_measured(path: Path, job: SurfaceJobFile, faces: Sequence[SurfaceInputs]) -> list[MeasuredPoints]:
    """Reads a part's measured points, named as its file, for each face; of a scan, and where there are several faces,
    those on it.

    Raises SRF-FILE, for a scan SRF-UNIT and SRF-OFF too, JOB-KEY where the job does not state its frame, and SRF-GRID
    for a grid over several faces.
    """
    gauging, farthest_mm = job.gauging, options_from(SurfaceOptions, job).farthest_mm
    if not is_scan(path):
        read = read_points(path)
        of_file = (path.stem, str(path), read.lines)
        points = MeasuredPoints(read.points_mm, gauging.ball_radius_mm, read.shape, *of_file)
        if len(faces) == 1:
            return [points]
        if read.shape is not None:
            raise Code.SRF_GRID.refusal(
                f"{path.name!r} is a grid of {read.shape[0]} × {read.shape[1]} points, and surface.face names "
                f"{len(faces)} faces",
                hint="leave out row and column: points then go to the faces that they are on",
                place=Place(str(path)),
            )
        return [_on_face(face, points, None, farthest_mm) for face in faces]
    if "alignment" not in gauging.model_fields_set:
        raise Code.JOB_KEY.refusal(
            f"'gauging.alignment' is not stated, and {path.name!r} is a scan: 0 of its lines say how it was aligned",
            hint='gauging.alignment = "best-fit" where software aligned it, "datum" where it is in the part\'s datums',
            place=Place(str(path)),
            values={"key": "gauging.alignment"},
        )
    factor = None if gauging.unit is None else MM_PER_INCH if gauging.unit == "inch" else 1.0
    scan = read_scan(path, factor, gauging.columns)
    at = (path.stem, str(path), scan.lines)
    points = MeasuredPoints(scan.points_mm, gauging.ball_radius_mm, None, *at, rounding_mm=scan.rounding_mm)
    return [_on_face(face, points, scan.normal, farthest_mm) for face in faces]


def _on_face(face: SurfaceInputs, scan: MeasuredPoints, normal: Array | None, farthest_mm: float) -> MeasuredPoints:
    """Returns the points of a scan that are on the face. Raises SRF-OFF, SRF-UNIT, SRF-FILE."""
    words = "the face" if face.face is None else f"face {face.face}"
    with in_file(scan.file):
        try:
            return on_face(face.surface, scan, normal, farthest_mm, face.trim, words)
        except TrueloopError as refused:
            if refused.code is Code.SRF_OFF:
                error = closest(face.surface, scan.points_mm).distance_mm - scan.ball_radius_mm
                refuse_unit(face.surface, scan.points_mm, error, scan.ball_radius_mm, scan.name)
            raise


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
