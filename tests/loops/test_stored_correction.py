"""A whole correction is data: from a pickle and from JSON it comes back equal and writes the same programs."""

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_composed_correction import write_job
from tests.support.correction import example_inputs
from trueloop.domain.record import Correction as Envelope
from trueloop.domain.record import Product
from trueloop.jobs.turned.job import read_job
from trueloop.jobs.turned.outputs import outputs_of
from trueloop.loops.turned.commanded import commanded
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.paths import Paths
from trueloop.loops.turned.process_intermittent import compensate, writing
from trueloop.loops.turned.provenance import CODEC, enveloped
from trueloop.loops.turned.written import write_contour


def from_json(correction: Correction) -> Correction:
    return CODEC.from_json(CODEC.to_json(correction), Correction)


def from_pickle(correction: Correction) -> Correction:
    back: Correction = pickle.loads(pickle.dumps(correction))
    return back


def inputs_of(name: str, folder: Path) -> Inputs:
    if name == "in a machine":
        return read_job(write_job(folder, "G7", "machine", "uncompensated")).inputs
    inputs = example_inputs(name.split(maxsplit=1)[0])
    if name.endswith("by nose"):
        return replace(inputs, options=replace(inputs.options, errors_follow="nose"))
    return inputs


def rewritten(inputs: Inputs, correction: Correction) -> bytes:
    """The program written anew from the paths that the correction holds."""
    matched = commanded(
        inputs.program, inputs.semifinish, inputs.profile, inputs.nose_radius_mm, inputs.allowance_mm, inputs.run
    )
    paths = Paths(correction.commanded, correction.corrected, (correction.commanded, correction.corrected), None)
    return write_contour(writing(inputs, matched), correction.profile, correction.touches, paths)[0]


@pytest.mark.parametrize("copied", [from_json, from_pickle])
@pytest.mark.parametrize("name", ["modbas2", "modbas2 by nose", "piecs11", "linuxcnc", "facetst", "in a machine"])
def test_a_copy_is_equal_and_writes_the_same(
    name: str, copied: Callable[[Correction], Correction], tmp_path: Path
) -> None:
    inputs = inputs_of(name, tmp_path)
    correction = compensate(inputs)
    copy = copied(correction)
    assert copy == correction and copy is not correction
    assert dict(outputs_of(copy)) == dict(outputs_of(correction))
    if not correction.decision.by_offset:
        assert rewritten(inputs, copy) == correction.corrected_program
    for own, other in zip(correction.corrected, copy.corrected, strict=True):
        s = np.linspace(own.start_mm - 1.0, own.end_mm + 1.0, 97)
        np.testing.assert_array_equal(own.shifted.centre_mm(s), other.shifted.centre_mm(s))


def test_another_touch_makes_another_correction() -> None:
    inputs = example_inputs("modbas2")
    errors = inputs.touches.error_mm.copy()
    errors[7] += 1e-6
    other = replace(inputs, touches=replace(inputs.touches, error_mm=errors))
    assert compensate(inputs) == compensate(inputs) != compensate(other)


def test_the_envelope_shares_what_the_record_says() -> None:
    correction = compensate(example_inputs("modbas2"))
    envelope = enveloped(correction)
    assert envelope.record.product is Product.TURNED and envelope.identity == (correction.record.id,)
    assert f"source sha256 {envelope.source_sha256}".encode() in correction.corrected_program
    assert envelope.limits["correction_mm"] == correction.options.limits.correction_mm
    assert CODEC.from_json(CODEC.to_json(envelope), Envelope) == envelope
