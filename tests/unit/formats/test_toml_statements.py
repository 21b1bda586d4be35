"""What two statements of a TOML file define alike is named with both, where Python's own reader says one place."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.unit.formats.test_job import JOB
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.formats.jobs.surface_job import read_surface_job
from trueloop.formats.toml_tables import Statement, collision, statements

ONE_VALUE, ONE_PLACE = "either one value or a table", "in one place: under its heading, or dotted"
PATHS = st.lists(st.sampled_from("abc"), min_size=1, max_size=3).map(".".join)
LINES = st.lists(
    st.one_of(PATHS.map("[{}]".format), PATHS.map("[[{}]]".format), PATHS.map("{} = 1".format)), min_size=2, max_size=9
)


@pytest.mark.parametrize(
    ("text", "line", "column", "message", "hint"),
    [
        (
            'compensation.by = "path"\n' + JOB,
            21,
            1,
            "the table [compensation] and the key 'compensation.by' in line 1 both define 'compensation'",
            ONE_PLACE,
        ),
        (
            JOB + "weight.of = 1\n",
            22,
            1,
            "the key 'weight.of' and the key 'weight' in line 21 both define 'compensation.weight'",
            ONE_VALUE,
        ),
        (
            JOB + "\n  [ compensation.weight ] # of the correction\n",
            23,
            3,
            "the table [compensation.weight] and the key 'weight' in line 21 both define 'compensation.weight'",
            ONE_VALUE,
        ),
        (
            JOB + "[features.dome]\nknot_every = 3\n[features]\ndome.curve = 1\n",
            25,
            1,
            "the key 'dome.curve' and the table [features.dome] in line 22 both define 'features.dome'",
            ONE_PLACE,
        ),
        (
            JOB + "[[tool]]\nnumber = 3\n",
            22,
            1,
            "the table [[tool]] and the table [tool] in line 9 both define 'tool'",
            ONE_PLACE,
        ),
        (
            JOB.replace("{ P46 = 3.52 }", "{ P46 = 3.52, P46 = 1 }"),
            15,
            35,
            "a key is given twice between the braces of one value",
            "keep one of them",
        ),
        (
            JOB.replace("{ P46 = 3.52 }", "{ P46 = 3.52 }\nparameters.P47 = 1"),
            16,
            1,
            "the key 'parameters.P47' and the key 'parameters' in line 15 both define 'programs.parameters'",
            ONE_VALUE,
        ),
    ],
)
def test_a_name_defined_in_two_ways_is_named_with_both_places(
    tmp_path: Path, text: str, line: int, column: int, message: str, hint: str
) -> None:
    file = tmp_path / "job.toml"
    file.write_text(text)
    with pytest.raises(TrueloopError) as refused:
        read_turned_job(file)
    error = refused.value
    assert (error.code, error.place.line, error.place.column) == (Code.JOB_SYNTAX, line, column)
    assert error.message == message and hint in error.hint


def test_every_file_of_tables_says_it_alike(tmp_path: Path) -> None:
    file = tmp_path / "file.toml"
    file.write_text("stylus.ball_radius_mm = 1.5\n[stylus]\nstem_radius_mm = 0.75\n")
    for read, code in ((read_probe, Code.PRB_FILE), (read_surface_job, Code.JOB_SYNTAX)):
        with pytest.raises(TrueloopError, match=r"the table \[stylus\] and the key 'stylus.ball_radius_mm'") as refused:
            read(file)
        assert refused.value.code is code and refused.value.place.line == 2


@pytest.mark.parametrize(
    ("key", "hint"),
    [("compensation.weight = 0.5", "leave 'compensation.' out"), ("tool.number = 3", "write it under [tool]")],
)
def test_a_key_named_in_full_under_a_heading_counts_from_there(tmp_path: Path, key: str, hint: str) -> None:
    (tmp_path / "job.toml").write_text(f"{JOB}{key}\n")
    with pytest.raises(TrueloopError) as refused:
        read_turned_job(tmp_path / "job.toml")
    assert refused.value.code is Code.JOB_KEY and refused.value.place.line == 22
    assert refused.value.hint == f"keys under [compensation] count from there: {hint}"


def test_rows_of_an_array_are_no_headings() -> None:
    found = list(statements("[part]\nstart = [\n  [1, 2],\n  [3, 4]\n]\nname = 'step'\n"))
    assert [statement.location for statement in found] == [("part",), ("part", "start"), ("part", "name")]


@settings(max_examples=400)
@example(lines=["[[c.b]]", "[c]", "b.a = 1"])
@example(lines=["[[a]]", "[[a.a]]", "[[a]]", "[a.a]", "[[a.a]]"])
@given(lines=LINES)
def test_the_two_that_are_named_collide_by_themselves(lines: list[str]) -> None:
    """Judged by Python's reader: it refuses the file in that line, and the two with nothing but their headings too."""
    refused_at = next((k for k in range(1, len(lines) + 1) if not readable(lines[:k])), None)
    if refused_at is None:
        return
    found = collision("\n".join(lines), refused_at)
    assert found is not None and found.later.line == refused_at
    kept = {*with_heading(found.earlier, lines), *with_heading(found.later, lines)}
    arrays = {k for k, line in enumerate(lines, 1) if line.startswith("[[")}
    assert not readable([line for k, line in enumerate(lines, 1) if k <= refused_at and k in kept | arrays])


def with_heading(statement: Statement, lines: list[str]) -> list[int]:
    """The line of a statement, and that of the heading above it."""
    above = [k for k in range(1, statement.line) if lines[k - 1].startswith("[")] if statement.kind == "key" else []
    return [*above[-1:], statement.line]


def readable(lines: list[str]) -> bool:
    try:
        tomllib.loads("\n".join(lines))
    except tomllib.TOMLDecodeError:
        return False
    return True
