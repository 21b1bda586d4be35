"""A job that states its tool's number alone gets edge and setting out of the store."""

import shutil
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.correction import EXAMPLES
from tests.support.tools import at, mount, put, set_anew, turn
from trueloop.domain.life import Cut
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.tools import with_edge
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.storage.store import Store, find, open_store

NOON = at(12)


@pytest.fixture
def store() -> Store:
    made = open_store("sqlite://", create=True)
    mount(made, at(8))
    return made


def inputs(
    *, number: int | None = 3, edge: Edge | None = None, made_at: datetime = NOON, measured_at: datetime | None = None
) -> Inputs:
    read = read_job(EXAMPLES / "piecs11" / "job.toml", serial="1").inputs
    inspections = tuple(replace(one, measured_at=measured_at) for one in read.inspections)
    options = replace(read.options, tool=number)
    return replace(
        read, options=options, edge=edge, edge_set_at=None, made_at=made_at, inspections=inspections, machine_tool=None
    )


def test_the_number_alone_is_enough(store: Store) -> None:
    found = with_edge(store, inputs())
    assert found.edge is not None and found.edge.identity == ("SVJBR 2020", "VBMT 160408", "1")
    assert found.edge_set_at == at(8) and found.edge.tool.number == 3


def test_the_holder_alone_is_enough_too(store: Store) -> None:
    found = with_edge(store, inputs(number=None, edge=Edge(Tool(name="SVJBR 2020"))))
    assert found.edge is not None and found.edge.corner == "1" and found.edge.insert == "VBMT 160408"


def test_the_edge_is_that_of_the_cut_still_to_be_made(store: Store) -> None:
    turn(store, "2", at(10))
    found = with_edge(store, inputs(measured_at=at(11)))
    assert found.edge is not None and found.edge.corner == "2"


def test_the_edge_of_a_finished_part_is_that_of_its_touches(store: Store) -> None:
    turn(store, "2", at(10))
    finished = replace(inputs(measured_at=at(9)), semifinish=None, allowance_mm=0.0, measured_allowance_mm=0.0)
    assert finished.measured_finished
    found = with_edge(store, finished)
    assert found.edge is not None and found.edge.corner == "1"


def test_touches_older_than_the_setting_are_refused(store: Store) -> None:
    assert with_edge(store, inputs(measured_at=at(9))).edge_set_at == at(8)
    set_anew(store, at(10))
    with pytest.raises(TrueloopError) as refused:
        with_edge(store, inputs(measured_at=at(9)))
    assert refused.value.code is Code.EDG_SETTING
    assert with_edge(store, inputs(measured_at=None)).edge_set_at == at(10)  # their age is not known


def test_a_job_without_a_tool_in_the_store_stays_as_it_is(store: Store) -> None:
    given = inputs(number=4)
    assert with_edge(store, given) is given
    stated = Edge(Tool(4, "other"), "I", "1")
    assert with_edge(store, inputs(number=4, edge=stated)).edge == stated


def test_a_contradiction_and_an_edge_that_is_gone_are_refused(store: Store) -> None:
    with pytest.raises(TrueloopError) as other:
        with_edge(store, inputs(edge=Edge(Tool(3), corner="2")))
    assert other.value.code is Code.EDG_OTHER
    put(store, "remove", at(11))
    stated = Edge(Tool(3, "SVJBR 2020"), "VBMT 160408", "1")
    with pytest.raises(TrueloopError) as gone:
        with_edge(store, inputs(edge=stated, made_at=at(11) + timedelta(minutes=1)))
    assert gone.value.code is Code.EDG_ENDED
    assert with_edge(store, inputs(edge=stated, made_at=datetime(2026, 3, 2, 9, tzinfo=UTC))).edge_set_at == at(8)


def test_compensate_keeps_the_part_with_the_edge_that_is_mounted(tmp_path: Path) -> None:
    """The job states the number of its tool, the store the rest: what is kept teaches that edge."""
    for file in (EXAMPLES / "piecs11").iterdir():
        shutil.copy(file, tmp_path)
    job = tmp_path / "job.toml"
    job.write_text(job.read_text(encoding="utf-8").replace("../../out/piecs11", "out"), encoding="utf-8")
    db = tmp_path / "trueloop.db"
    run("db", "init", db)
    run(
        "tool",
        "mount",
        "T1",
        "--holder",
        "H",
        "--insert",
        "I",
        "--corner",
        "1",
        "--nose-radius-mm",
        0.79375,
        "--db",
        db,
    )
    run("compensate", job, "--serial", "3511.158")
    kept = open_store(db, codec=store_codec())
    (cut,) = (one.value for one in find(kept, Cut))
    assert cut.setting is not None and cut.setting.edge.identity == ("H", "I", "1")
    (correction,) = (one.value for one in find(kept, Correction))
    assert correction.record.edge is not None and correction.record.edge.identity == ("H", "I", "1")
    assert correction.record.edge_set_at == cut.setting.set_at is not None
    text = job.read_text(encoding="utf-8").replace("[tool]\n", '[tool]\ncorner = "2"\n')
    job.write_text(text, encoding="utf-8")
    assert "EDG-OTHER" in run("compensate", job, "--serial", "3511.158", status=3)
