"""Every way in which a model, a job or a file makes no image."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.machines import any_model, chain_with_travel, random_model, set_back_chain
from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.examples import copy_example
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.tables.model_file import model_to_json
from trueloop.jobs.realtime.image import ImageOptions, make_image
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of
from trueloop.realtime.image import SignalLimits, bank_of, signals_of


def growing(*signals: str, **identified: tuple[float, float]) -> MachineModel:
    """A gantry whose spindle grows with signals, a micrometre a unit."""
    terms = (Term(error_name("EZ0S"), tuple(Part(CONSTANT, signal, 20.0) for signal in signals)),)
    count = len(signals)
    machine = Machine("mill", chain_with_travel("mill-gantry"), "4711")
    return MachineModel(machine, terms, np.full(count, 0.001), np.zeros((count, count)), identified)


def image_of(model: MachineModel, options: ImageOptions | None = None) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.json"
        path.write_text(model_to_json(model))
        return make_image(path, options)


def _five_axes() -> object:
    model = any_model(set_back_chain("five-axis-table-table-ac"), np.random.default_rng(1))
    return bank_of(model, (0.0, 0.0, 0.0), signals_of(model, SignalLimits({"T1": (15.0, 30.0)}, {})))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.RTC_MODEL: _five_axes,
    Code.RTC_SIGNAL: lambda: signals_of(growing("T1", "T2", T1=(18.0, 25.0))),
    Code.RTC_LIMIT: lambda: image_of(growing("T1", T1=(18.0, 180.0))),
    Code.RTC_IMAGE: lambda: read_image("no-such-image-1.img"),
}


def with_axis_u() -> object:
    model = random_model(
        Machine("mill", chain_of("w b X U Z (S) t")), (Term(error_name("EZ0S")),), np.random.default_rng(1)
    )
    return bank_of(model, (0.0, 0.0, 0.0), ())


def endless() -> object:
    return image_of(
        MachineModel(Machine("mill", chain_of("mill-gantry")), (Term(error_name("EZ0S")),), np.ones(1), np.eye(1))
    )


MANY = [f"T{k}" for k in range(17)]
OTHERS: dict[str, tuple[Code, Callable[[], object], str]] = {
    "an axis that is not one of X, Y, Z": (Code.RTC_MODEL, with_axis_u, "U"),
    "a travel that nobody states": (Code.RTC_MODEL, endless, "--travel X=LOW,HIGH --travel Y=LOW,HIGH"),
    "a travel of an axis that is not there": (
        *(Code.RTC_MODEL, lambda: image_of(growing("T1", T1=(18.0, 25.0)), ImageOptions(travel_mm={"W": (0.0, 1.0)}))),
        "W",
    ),
    "too many signals": (Code.RTC_SIGNAL, lambda: signals_of(growing(*MANY, **dict.fromkeys(MANY, (0.0, 1.0)))), "16"),
    "a range without an inside": (Code.RTC_SIGNAL, lambda: signals_of(growing("T1", T1=(18.0, 18.0))), "--range T1="),
    "a range of another signal": (
        *(Code.RTC_SIGNAL, lambda: signals_of(growing("T1", T1=(18.0, 25.0)), SignalLimits({"T9": (1.0, 2.0)}, {}))),
        "T9",
    ),
    "a step of nothing": (
        *(Code.RTC_SIGNAL, lambda: signals_of(growing("T1", T1=(18.0, 25.0)), SignalLimits({}, {"T1": 0.0}))),
        "T1 0",
    ),
    "another machine": (
        *(Code.MCH_MACHINE, lambda: image_of(growing("T1", T1=(18.0, 25.0)), ImageOptions(serial="4712"))),
        "4712",
    ),
}


@pytest.mark.parametrize("what", OTHERS)
def test_it_says_what_it_is_about(what: str) -> None:
    code, call, word = OTHERS[what]
    said = refused(call)
    assert said.code is code
    assert word in str(said)


WIDE = {"X": (0.0, 200.0), "Z": (-400.0, 50.0)}


def test_a_table_that_the_drives_cannot_follow_is_refused_and_so_are_options_of_no_use(tmp_path: Path) -> None:
    for name in ("linuxcnc", "modbas2"):
        copy_example(name, tmp_path / name)
    job = tmp_path / "linuxcnc" / "job.toml"
    options = ImageOptions(travel_mm=WIDE, limit_mm=0.2, origin_mm=(100.0, -150.0))
    driven = np.concatenate([block.rows[:, 0] + block.rows[:, 2] for block in make_image(job, options).image.blocks])
    low, high = float(driven.min()), float(driven.max())
    for changed, goes_to in (
        ({"travel_mm": WIDE | {"X": (0.0, high - 0.01)}}, high),
        ({"travel_mm": WIDE | {"X": (low + 0.01, 200.0)}}, low),
        ({"origin_mm": (1000.0, -150.0)}, high + 900.0),
    ):
        said = refused(lambda changed=changed: make_image(job, replace(options, **changed)))
        assert said.code is Code.RTC_TABLE and f"X goes to {goes_to:.3f} mm" in said.message
    make_image(job, replace(options, travel_mm=WIDE | {"X": (low, high)}))
    for stated in (SignalLimits({"T1": (1.0, 2.0)}, {}), SignalLimits({}, {"T1": 1.0})):
        said = refused(lambda stated=stated: make_image(job, replace(options, stated=stated)))
        assert said.code is Code.RTC_SIGNAL and said.values == {"signals": ["T1"]}
    model = tmp_path / "model.json"
    model.write_text(model_to_json(growing("T1", T1=(18.0, 25.0))))
    alone = ImageOptions(travel_mm=WIDE)
    for kind, source, given, name in (
        ("a table", job, replace(options, tool_mm=(0.0, 0.0, -120.0)), "--tool"),
        ("a table", job, replace(options, standing=("C",)), "--standing"),
        ("a model", model, replace(alone, origin_mm=(100.0, -150.0)), "--origin"),
        ("a model", model, replace(alone, tip=3), "--tip"),
    ):
        said = refused(make_image, source, given)
        assert said.code is Code.RTC_TABLE and f"{name} is stated; the image holds {kind} alone" in said.message


def test_the_largest_correction_is_refused_where_it_is() -> None:
    """160 °C above the reference by 1 µm each, of which −E is added."""
    said = refused(PRODUCERS[Code.RTC_LIMIT])
    assert said.values == {"largest_um": pytest.approx(160.0), "limit_um": 150.0}
    assert "along Z" in said.message
    assert "T1 180" in said.message
