"""A part corrected from Python, by edge: as the command does it, and edges found by what calls them."""

from pathlib import Path, PureWindowsPath
from typing import cast

import pytest

import trueloop
from tests.support.cli import run
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.readings import Sources

JOBS = ("modbas2/job.toml", "grooved/grooved.toml", "two-sides/two-sides.toml")


def texts(folder: Path) -> dict[str, list[str]]:
    """Programs and tables by file name, without what is of the day: comments with a record's id."""
    files = (file for file in folder.iterdir() if file.suffix in (".nc", ".csv"))
    return {
        file.name: [line for line in file.read_text().splitlines() if not line.startswith(("(", "#"))] for file in files
    }


@pytest.mark.parametrize("job", JOBS)
def test_a_part_is_corrected_as_by_the_command(tmp_path: Path, job: str) -> None:
    part = trueloop.compensate_part(trueloop.example(job), tmp_path / "python")
    run("compensate", trueloop.example(job), "-o", tmp_path / "command")
    assert texts(tmp_path / "python") == texts(tmp_path / "command")
    names = {file.name for file in (tmp_path / "command").iterdir()}
    assert {file.name for file in part.files} == names
    for edge in part.edges:
        assert edge.correction is not None
        source = trueloop.example(job).parent / edge.correction.name_to_run
        assert edge.correction.name_to_run in names or source.exists(), "what is run is written, or the given one"


def test_an_edge_is_found_by_what_calls_it(tmp_path: Path) -> None:
    part = trueloop.compensate_part(trueloop.example("two-sides/two-sides.toml"), tmp_path / "out")
    assert part.edge("T2") is part.edge("T2", "second") is part.edges[1]
    corners = trueloop.compensate_part(trueloop.example("grooved/grooved.toml"), tmp_path / "corners")
    assert corners.edge("T15") is corners.edge("T15 (right corner)") is corners.edges[2]
    for tool, setup in (("T9", ""), ("T2", "first"), ("T", "")):
        with pytest.raises(TrueloopError) as refused:
            part.edge(tool, setup)
        assert refused.value.code is Code.NC_NO_TOOL and set(refused.value.values) == set(Code.NC_NO_TOOL.values)
        assert "T4 in 'second'" in refused.value.message


def test_one_tool_alone_is_refused_where_several_are_meant(tmp_path: Path) -> None:
    """`compensate_job` is of one tool; the refusal names the function that takes several."""
    for job in JOBS[1:]:
        with pytest.raises(TrueloopError) as refused:
            trueloop.compensate_job(trueloop.example(job), tmp_path / "out")
        assert "compensate_part" in (refused.value.hint or "")
    assert not (tmp_path / "out").exists()


def test_a_record_of_windows_names_its_inputs_as_one_of_linux() -> None:
    """The record's id is made of the names too, and a job on another computer finds the program by its name."""
    folder, job = (cast(Path, PureWindowsPath(path)) for path in ("C:\\jobs\\shaft", "."))
    sources = Sources(folder, job)
    sources.file("..\\finish.nc")
    sources.beside(cast(Path, PureWindowsPath("other\\job.toml"))).file("touches.csv")
    assert list(sources.named) == ["../finish.nc", "other/touches.csv"]
