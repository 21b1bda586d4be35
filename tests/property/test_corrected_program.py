"""Whatever the errors: the contour moves by −w times the fitted error, and the rest of the program stays."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.standoff import feed_moves_of, standoff_mm
from trueloop.domain.option import Limits
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.options import Arcs

JOB = Path(__file__).parents[2] / "examples" / "modbas2" / "job.toml"
NO_LIMITS = Limits(correction_mm=1.0, slope=1.0, scatter_mm=1.0)


@cache
def example() -> Inputs:
    inputs = read_job(JOB).inputs
    return replace(inputs, options=replace(inputs.options, limits=NO_LIMITS))


@settings(max_examples=12)
@given(
    offset=st.floats(-0.05, 0.05),
    bend=st.floats(-0.04, 0.04),
    waves=st.floats(0.5, 4.0),
    weight=st.floats(0.3, 1.0),
    arcs=st.sampled_from(get_args(Arcs)),
    policy=st.sampled_from(TangentPolicy),
)
def test_contour_moves_by_minus_w_times_the_fitted_error(
    offset: float, bend: float, waves: float, weight: float, arcs: Arcs, policy: TangentPolicy
) -> None:
    inputs = example()
    along = np.linspace(0.0, 1.0, len(inputs.touches.point))
    touches = replace(inputs.touches, error_mm=offset + bend * np.sin(2 * np.pi * waves * along))
    options = replace(inputs.options, weight=weight, arcs=arcs, junctions=policy)
    correction = compensate(replace(inputs, touches=touches, options=options))
    fitted = correction.model.vectors.error_mm - correction.model.residual_mm
    expected = np.where(np.array(correction.by_offset)[touches.feature_index], np.nan, -weight * fitted)
    before, after = (
        feed_moves_of(read_program(source, "ge2000t").run(inputs.parameters))
        for source in (correction.source_program, correction.corrected_program)
    )
    for k in range(0, len(along), 3):
        point, normal = touches.nominal_mm[k], touches.outward_normal[k]
        moved = standoff_mm(after, point, normal, 0.79375) - standoff_mm(before, point, normal, 0.79375)
        assert np.isnan(expected[k]) or abs(moved - expected[k]) < 0.0002


@settings(max_examples=8)
@given(st.floats(-0.08, 0.08), st.floats(-0.08, 0.08))
def test_only_blocks_of_the_contour_change(cylinder: float, dome: float) -> None:
    inputs = example()
    is_dome = inputs.touches.feature_index == inputs.profile.names.index("dome")
    touches = replace(inputs.touches, error_mm=np.where(is_dome, dome, cylinder))
    correction = compensate(replace(inputs, touches=touches))
    old, new = (s.decode().splitlines() for s in (correction.source_program, correction.corrected_program))
    first = next(k for k, line in enumerate(old) if line.startswith("N0310"))
    assert new[0] == old[0]
    assert [line for line in new[1 : first + 3] if "trueloop" not in line and "sha256" not in line][1:] == old[1:first]
    last = next(k for k, line in enumerate(old) if line.startswith("N0440"))
    assert new[len(new) - (len(old) - last) :] == old[last:]
