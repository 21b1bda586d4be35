"""`make demo-factory` with three parts: a real LinuxCNC, `trueloop serve`, `trueloop cell run` and a real browser.

The metal is cut by what LinuxCNC drove, so that its true errors judge what the service had made.
"""

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import httpx2
import pytest

from scripts.factory_demo.office import Person
from trueloop.domain.factory import FactKind, Run, RunFact
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import Store, find, open_store

ROOT = Path(__file__).parents[2]
LONGEST_S = 1200
UNCORRECTED_UM = 15.0
"""What the worn corners leave on the arcs, RMS, where nothing is corrected: more than this."""


def test_three_parts_are_made_unattended(tmp_path: Path) -> None:
    folder = tmp_path / "factory"
    done = subprocess.run(
        [sys.executable, "-m", "scripts.factory_demo", str(folder), "3"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert [one["state"] for one in summary["parts"]] == ["released"] * 3
    assert max(one["true_rms_um"] for one in summary["parts"]) < UNCORRECTED_UM / 3
    assert {one["edge"].split()[-1]: one["parts"] for one in summary["memory"]} == {"1": 2, "2": 1}
    _all_is_shown(folder, summary["pages"])
    store = open_store(str(folder / "trueloop.db"), codec=store_codec())
    try:
        _each_cut_was_made_once(store)
        _what_was_measured_is_kept(store)
    finally:
        store.close()


@pytest.mark.parametrize("changes", [0, 1, 4, 5])
def test_who_records_a_step_reads_an_order_again_that_the_cell_has_changed(changes: int) -> None:
    versions = iter(range(100))
    recorded: list[str] = []

    def service(request: httpx2.Request) -> httpx2.Response:
        if request.method == "GET":
            return httpx2.Response(200, headers={"etag": f'"{next(versions)}"'}, json={})
        if request.url.path.endswith("/record"):
            recorded.append(request.headers["If-Match"])
            stale = len(recorded) <= changes
            return httpx2.Response(412 if stale else 200, json={"code": "FAC-STALE"} if stale else {})
        return httpx2.Response(200, json={})

    otto = Person("http://service", "otto", httpx2.MockTransport(service))
    if changes == 5:
        with pytest.raises(AssertionError, match="FAC-STALE"):
            otto.record("1", 2, 3, "by hand")
    else:
        otto.record("1", 2, 3, "by hand")
    assert recorded == [f'"{k}"' for k in range(min(changes, 4) + 1)]


def _all_is_shown(folder: Path, pages: dict[str, str]) -> None:
    routes = re.findall(r'path: "([^"]+)"', (ROOT / "web" / "src" / "frame" / "routes.ts").read_text(encoding="utf-8"))
    assert set(routes) - set(pages) <= {"/proposals/:id"}  # of one part there is nothing to propose
    names = {file.stem for file in (folder / "screenshots").glob("*.png")}
    assert len(names) == len(pages) + 2 and {"decision-P1", "decision-P2"} <= names
    assert "CMP-SCATTER" not in (folder / "certificates" / "P2.html").read_text(encoding="utf-8")
    assert sorted(file.name for file in (folder / "taken-in").iterdir()) == ["P1.qif", "P2.qif", "P3.qif"]


def _each_cut_was_made_once(store: Store) -> None:
    runs = {one.value.key: one.value for one in find(store, Run)}
    facts = [one.value for one in find(store, RunFact)]
    ended = Counter((runs[one.run].part.serial, runs[one.run].step) for one in facts if one.what is FactKind.ENDED)
    semifinish, probe, finish = 0, 1, 3
    once = {(serial, step): 1 for serial in ("P1", "P2", "P3") for step in (semifinish, probe, finish)}
    assert ended == once | {("P2", probe): 2}
    unknown = [runs[one.run] for one in facts if one.what is FactKind.UNKNOWN]
    assert [(one.part.serial, one.step, one.attempt) for one in unknown] == [("P1", probe, 1)]


def _what_was_measured_is_kept(store: Store) -> None:
    cuts = {one.value.part.serial: one.value for one in find(store, Cut, stage=Stage.FINISH)}
    corners = {serial: cut.setting.edge.corner for serial, cut in cuts.items() if cut.setting is not None}
    assert corners == {"P1": "1", "P2": "1", "P3": "2"}
    assert len({cut.correction for cut in cuts.values()}) == 3
    assert len(find(store, InspectionLink)) == 6  # touches and the measuring machine's, of each part
