"""From simulated parts in files, through the store, to the cause that was written down before."""

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from studies.diagnosed.part_types import SLIM
from studies.diagnosed.shop import Shop, cut_series
from studies.diagnosed.truth import Fault, Truth, Wrong
from tests.support.cli import output_of
from tests.support.diagnosed_files import both_file, decompose, model_file
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Quarantine, Stage
from trueloop.storage.store import find, keep, open_store

BENT = Truth((Wrong(Fault.PART_DEFLECTION, 0.020),))
AT = datetime(2026, 3, 2, 6, 0, tzinfo=UTC)


@pytest.fixture
def shop(tmp_path: Path) -> tuple[Path, str]:
    """Eight parts that bend away from the tool by 20 µm at their free end."""
    model, db = model_file(tmp_path), str(tmp_path / "trueloop.db")
    output_of("db", "init", db)
    series = cut_series(BENT, Shop(SLIM, parts=8, set_anew=()), 1)
    for k, made in enumerate(series.made):
        file = both_file(series, made, tmp_path / f"{k}.csv")
        output_of(*decompose(series, made, file, model, db, type="slim shaft", serial=f"S{k:02d}"))
    return model, db


def diagnosed(shop: tuple[Path, str], *more: str) -> dict[str, object]:
    found: dict[str, object] = json.loads(output_of("diagnose", *more, "--db", shop[1], "-m", shop[0], "--json"))
    return found


def codes(found: dict[str, object]) -> set[str]:
    findings = found["findings"]
    assert isinstance(findings, list)
    return {one["code"] for one in findings}


def test_the_cause_is_named(shop: tuple[Path, str]) -> None:
    found = json.loads(json.dumps(diagnosed(shop, "series")))
    assert len(found["parts"]) == 8
    best = max(found["causes"]["hypotheses"], key=lambda one: one["probability"])
    (cause,) = best["causes"]
    assert "deflect" in next(one["name"] for one in found["causes"]["candidates"] if one["key"] == cause)
    assert best["probability"] > 0.9
    taper = next(
        one for one in found["means"] if (one["feature"], one["kind"]) == ("shaft of 24.00 mm", "taper of a shaft")
    )
    assert taper["machine"]["mean_um"] == pytest.approx(taper["cmm"]["mean_um"], abs=2.0)
    assert taper["cmm"]["mean_um"] > 8.0


def test_one_part_has_its_components_and_pages_are_written(shop: tuple[Path, str], tmp_path: Path) -> None:
    found = json.loads(json.dumps(diagnosed(shop, "part", "S03", "-o", str(tmp_path / "out"))))
    for one in found["points"]:
        both = one["error_mtg_resid_um"] + one["error_proc_resid_um"]
        assert one["error_pp_um"] == pytest.approx(both, abs=1e-3)
    assert set(found["part"]["errors"]) == {"machine", "CMM"}
    written = {file.name for file in (tmp_path / "out").iterdir()}
    assert {"part.json", "part.html"} <= written


def test_a_part_in_quarantine_is_left_out(shop: tuple[Path, str]) -> None:
    store = open_store(shop[1])
    first = find(store, Inspection)[0].value
    cut = Cut(first.part, Stage.FINISH, at=AT)
    keep(store, [cut, Quarantine(cut.identity, AT, "dropped")])
    found = diagnosed(shop, "series")
    parts = found["parts"]
    assert isinstance(parts, list)
    assert [one["serial"] for one in parts] == [f"S{k:02d}" for k in range(1, 8)]
    assert "DIA-FEW" in codes(found)
    assert diagnosed(shop, "machine")["parts"] == 7
    assert "in quarantine" in output_of("diagnose", "part", "S00", "--db", shop[1], status=3)


def test_an_inspection_before_its_cut_is_refused(shop: tuple[Path, str]) -> None:
    store = open_store(shop[1])
    first = find(store, Inspection)[0].value
    late = Cut(first.part, Stage.FINISH, at=AT)
    early = replace(first, measured_at=AT - timedelta(hours=1), sha256="9" * 64)
    keep(store, [late, early, InspectionLink(early.identity, late.identity)])
    assert "DIA-CLOCK" in output_of("diagnose", "series", "--db", shop[1], status=3)
    assert "DIA-CLOCK" in codes(diagnosed(shop, "series", "--accept", "DIA-CLOCK"))


def test_mistyped_names(shop: tuple[Path, str]) -> None:
    assert "did you mean 'S03'?" in output_of("diagnose", "part", "SO3", "--db", shop[1], status=3)
    said = output_of("diagnose", "series", "--type", "slim shft", "--db", shop[1], status=3)
    assert "DIA-NONE" in said
    assert "did you mean 'slim shaft'?" in said


def test_an_empty_store(tmp_path: Path) -> None:
    db = str(tmp_path / "trueloop.db")
    output_of("db", "init", db)
    assert "DIA-NONE" in output_of("diagnose", "series", "--db", db, status=3)
    assert "DIA-NONE" in output_of("diagnose", "machine", "-m", model_file(tmp_path), "--db", db, status=3)


def test_one_part_alone_names_no_cause(tmp_path: Path) -> None:
    model, db = model_file(tmp_path), str(tmp_path / "trueloop.db")
    output_of("db", "init", db)
    series = cut_series(BENT, Shop(SLIM, parts=1, set_anew=()), 1)
    file = both_file(series, series.made[0], tmp_path / "0.csv")
    output_of(*decompose(series, series.made[0], file, model, db, type="slim shaft", serial="S00"))
    assert "DIA-FEW" in output_of("diagnose", "series", "--db", db, status=3)
    assert "DIA-FEW" in output_of("diagnose", "machine", "-m", model, "--db", db, status=3)
    found = diagnosed((model, db), "part", "S00")
    assert found["causes"] is None
    assert "DIA-FEW" in codes(found)


def test_repeats_that_step_do_not_hold(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    steady, stepped = rng.normal(0.0, 0.5, 20), rng.normal(0.0, 0.5, 20) + 6.0 * (np.arange(20) >= 12)
    rows = [f"{what},{value:.3f}" for what, of in (("part", steady), ("tool probe", stepped)) for value in of]
    file = tmp_path / "repeats.csv"
    file.write_text("# repeats_to_um 0.5\nwhat,reading_um\n" + "\n".join(rows) + "\n")
    found = json.loads(output_of("diagnose", "fixture", file, "--json", status=1))
    assert [(one["name"], one["stable"]) for one in found["fixturings"]] == [("part", True), ("tool probe", False)]
    assert found["fixturings"][1]["step_after"] == 12
    assert found["fixturings"][1]["step"]["value_um"] == pytest.approx(6.0, abs=0.7)
    file.write_text("what,reading_um\n" + "\n".join(rows) + "\n")
    assert "repeats_to_um" in output_of("diagnose", "fixture", file, status=3)
    output_of("diagnose", "fixture", file, "--repeats-to-um", "0.5", "--limit-um", "10", status=0)
