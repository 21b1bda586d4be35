"""The example jobs: they parse, their touches lie on their profiles, their programs have the published coordinates."""

import math
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from scripts.nist_parts import (
    ALLOWANCE_IN,
    EXAMPLES,
    NOSE_RADIUS_IN,
    NistPart,
    example_touches,
    parameters,
    parts,
    program,
)
from tests.support.feed_moves import largest_deviation_mm
from tests.support.linuxcnc import Tool, interpret
from trueloop.errors import Severity
from trueloop.geometry.feature import Arc
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.check.check import check
from trueloop.nc.match.matching import match_contour
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program
from trueloop.statistics import rms
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop.units import MM_PER_INCH, UM_PER_MM

JOBS = sorted(EXAMPLES.glob("*/job.toml"))
PARTS = list(parts())

ROUNDING_MM = math.sqrt(2) * 0.5e-5 * MM_PER_INCH
"""Coordinates are rounded to 1e-5 in, radii and z alike: at most this along any normal."""

WORD = re.compile(r"[XZRIKF](?:-?[\d.]+|\((?:[^()]|\([^()]*\))*\))|UPD, *\d+, *TOV\([XZ]\), *[\d.]+")
"""A coordinate, a feed or a tool-offset statement of a GE 2000T program."""


def inputs_of(job_file: Path) -> Inputs:
    return read_job(job_file).inputs


def test_these_are_the_example_jobs() -> None:
    assert [job.parent.name for job in JOBS] == [
        "bush",
        "dxf",
        "facetst",
        "lens",
        "linuxcnc",
        "modbas2",
        "piecs11",
        "shaft",
    ]


@pytest.mark.parametrize("job_file", JOBS, ids=lambda path: path.parent.name)
def test_touches_lie_on_the_profile(job_file: Path) -> None:
    inputs = inputs_of(job_file)
    distance = inputs.profile.locate(inputs.touches.nominal_mm).distance_mm
    np.testing.assert_allclose(distance, 0.0, atol=5e-5)


def test_the_main_example_is_the_mean_part_of_6517_table_1() -> None:
    """Table 1: errors from −18.733 µm at the top of the dome to 94.1705 µm on the cone; z from point 11."""
    vectors = inputs_of(EXAMPLES / "modbas2" / "job.toml").touches
    assert len(vectors.point) == 32
    assert vectors.error_mm.min() * UM_PER_MM == pytest.approx(-18.733)
    assert vectors.error_mm.max() * UM_PER_MM == pytest.approx(94.1705)
    assert [vectors.point[i] for i in np.flatnonzero(vectors.at_reference)] == ["11"]


@pytest.mark.parametrize("job_file", JOBS, ids=lambda path: path.parent.name)
def test_programs_cut_the_profile_and_nothing_is_found_wrong_with_them(job_file: Path) -> None:
    inputs = inputs_of(job_file)
    for cut, allowance_mm in ((inputs.program, 0.0), (inputs.semifinish, inputs.allowance_mm)):
        if cut is None:
            continue
        assert [found for found in check(cut, inputs.parameters) if found.severity is not Severity.NOTE] == []
        path = cut.run(inputs.parameters)
        match = match_contour(feed_moves(path), inputs.profile, inputs.nose_radius_mm, allowance_mm=allowance_mm)
        assert largest_deviation_mm(match) <= ROUNDING_MM


@pytest.mark.parametrize("job_file", JOBS, ids=lambda path: path.parent.name)
def test_every_example_is_corrected(job_file: Path) -> None:
    correction = compensate(inputs_of(job_file))
    assert correction.corrected_program != correction.source_program
    assert rms(correction.prediction.after_mm) < rms(correction.prediction.before_mm) / 10


def test_the_drawing_and_the_listed_profile_give_the_same_correction() -> None:
    """Features named or not, the profile read from a drawing or listed in the job: the same prediction."""
    listed, drawn = (compensate(inputs_of(EXAMPLES / name / "job.toml")) for name in ("piecs11", "dxf"))
    np.testing.assert_allclose(drawn.prediction.after_mm, listed.prediction.after_mm, atol=1e-9)
    assert drawn.profile.names == ("face-1", "cylinder-1", "face-2", "cone-1", "arc-1")


@pytest.mark.parametrize("cut", ["semifinish", "finish"])
@pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.number}.{part.semifinish_inspection}")
def test_every_part_is_cut_by_its_programs(part: NistPart, cut: str) -> None:
    read = read_program(program(part, cut).encode(), "ge2000t")
    assert check(read, parameters(part)) == []
    path = read.run(parameters(part))
    allowance_mm = ALLOWANCE_IN * MM_PER_INCH if cut == "semifinish" else 0.0
    match = match_contour(feed_moves(path), part.profile, NOSE_RADIUS_IN * MM_PER_INCH, allowance_mm=allowance_mm)
    assert largest_deviation_mm(match) <= ROUNDING_MM


@pytest.mark.parametrize("path", example_touches(), ids=lambda path: path.parent.name)
def test_touches_files_are_those_the_script_writes(path: Path) -> None:
    assert path.read_text(encoding="utf-8") == example_touches()[path]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.number}.{part.semifinish_inspection}")
def test_every_part_of_the_tables_gives_error_vectors(part: NistPart) -> None:
    for touches in (part.semifinish, part.finish):
        vectors = error_vectors(part.profile, touches, Gauging())
        np.testing.assert_array_equal(vectors.error_mm, [touch.error_mm for touch in touches])


def words(text: str) -> Counter[str]:
    """The words of a program from its unit on, those that stand in comments too, with what scanning did mended.

    The published programs went through text recognition: words slipped behind the comments of other blocks, so their
    order is lost, and a point became a comma.
    """
    return Counter(WORD.findall(re.sub(r"(?<=\d),(?=\d)", ".", text[text.index("G70") :])))


@pytest.mark.corpus
@pytest.mark.parametrize("cut", ["semifinish", "finish"])
@pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.number}.{part.semifinish_inspection}")
def test_programs_have_the_published_coordinates(part: NistPart, cut: str, corpus: Path) -> None:
    """[6811 A.2.2–A.4.2.20]: every X, Z, R, I, K, F and UPD of the program for this part, expressions as written."""
    digits = {"FACETST": "0600", "MODBAS2": "0300", "PIECS11": f"{part.number[:2]}00"}[part.family.name]
    published = corpus / "data" / "nist" / "programs" / f"{digits}{'1' if cut == 'semifinish' else '2'}1.nc"
    assert words(program(part, cut)) == words(published.read_text(encoding="utf-8"))


def test_the_linuxcnc_example_cuts_the_same_path() -> None:
    """As LinuxCNC's own interpreter reads it, against the GE 2000T program as ours does: every feed move, in mm."""
    inputs = inputs_of(EXAMPLES / "modbas2" / "job.toml")
    ours = feed_moves(inputs.program.run(inputs.parameters))
    theirs = interpret(EXAMPLES / "linuxcnc" / "finish.ngc", tools=[Tool(1)])
    theirs = [move for move in theirs if move.kind != "rapid"]
    cutting = ours[: len(theirs)]
    np.testing.assert_allclose(
        [(move.end_mm[0], move.end_mm[2]) for move in theirs], [move.path.end_mm for move in cutting], atol=1e-9
    )
    assert [move.kind == "arc" for move in theirs] == [isinstance(move.path, Arc) for move in cutting]
