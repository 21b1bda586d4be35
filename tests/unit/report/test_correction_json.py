"""The JSON of a correction says what the page says, in the form of its schema."""

import json
from typing import Any

import numpy as np
import pytest

from scripts.key_tables import schema
from tests.support.correction import example_correction, size_error_correction
from tests.support.json_schema import mistakes
from trueloop.loops.turned.correction import Correction
from trueloop.report.turned.correction_json import correction_as_dict, json_text

SCHEMA = json.loads(schema("correction.schema.json"))


def correction(name: str) -> Correction:
    return size_error_correction() if name == "offset" else example_correction(name)


@pytest.mark.parametrize("name", ["modbas2", "piecs11", "facetst", "offset"])
def test_every_example_has_the_form_of_the_schema(name: str) -> None:
    document = json.loads(json_text(correction(name)))
    assert list(mistakes(document, SCHEMA, SCHEMA["$defs"])) == []
    assert set(document) == set(SCHEMA["properties"])


def test_every_key_of_the_schema_is_described() -> None:
    for kind in SCHEMA["$defs"].values():
        assert all(key.get("description") for key in kind["properties"].values()), kind["title"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"headline": 3}, "$.headline: 3 is no string"),
        ({"more": 1}, "$.more is not in the schema"),
        ({"touches": [{}]}, "$.touches[0].feature is missing"),
    ],
)
def test_the_oracle_finds_what_is_wrong(change: dict[str, Any], said: str) -> None:
    document = {**correction_as_dict(example_correction("modbas2")), **change}
    assert said in list(mistakes(document, SCHEMA, SCHEMA["$defs"]))


def test_errors_keep_their_sign_and_unit() -> None:
    """Point 6 of [6517] Table 1: +12.446 µm; positive is material left on. Point 32 alone is negative."""
    document: Any = correction_as_dict(example_correction("modbas2"))
    touches = {one["point"]: one for one in document["touches"]}
    assert touches["6"]["error_before_um"] == pytest.approx(12.446, abs=0.006)
    assert touches["32"]["error_before_um"] == pytest.approx(-18.733, abs=0.006)
    displaced = [one["displacement_x_um"] for one in document["junctions"]]
    expected = [1000 * one.displacement_mm[0] for one in example_correction("modbas2").model.junctions]
    assert np.allclose(displaced, expected)


def test_the_diff_rebuilds_the_corrected_program() -> None:
    """The lines that are not old, put over the source at their places, are the corrected program."""
    made = example_correction("modbas2")
    document: Any = correction_as_dict(made)
    (program,) = (one for one in document["programs"] if one["name"] == "corrected.nc")
    lines = made.source_program.decode().splitlines()
    gone = {line["number"] for hunk in program["diff"] for line in hunk if line["kind"] == "old"}
    kept = [line for k, line in enumerate(lines, 1) if k not in gone]
    for line in sorted(
        (li for hunk in program["diff"] for li in hunk if li["kind"] == "new"), key=lambda li: li["number"]
    ):
        kept.insert(line["number"] - 1, line["text"])
    assert kept == made.corrected_program.decode().splitlines()
