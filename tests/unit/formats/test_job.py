"""Job files: what is read, and that a mistake is shown where it stands."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.job import Job, read_turned_job
from trueloop.formats.toml_tables import options_from
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging

JOB = """\
[part]
name = "step"
start = [40.0, 0.0]
feature = [
    { name = "cylinder", to = [40.0, 30.0] },
    { name = "dome", to = [0.0, 70.0], radius = 40.0 },
]

[tool]
nose_radius_mm = 0.8

[programs]
dialect = "linuxcnc"
finish = "finish.ngc"
parameters = { P46 = 3.52 }

[gauging]
touches = "touches.csv"

[compensation]
weight = 0.75
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("job") / "job.toml"


def _read(path: Path, text: str) -> Job:
    path.write_bytes(text.encode())
    return read_turned_job(path)


def _refusal(path: Path, before: str, after: str) -> TrueloopError:
    assert before in JOB
    with pytest.raises(TrueloopError) as refusal:
        _read(path, JOB.replace(before, after))
    return refusal.value


def test_values_and_defaults(path: Path) -> None:
    job = _read(path, JOB)
    assert job.part.feature[1].to == (0.0, 70.0)
    assert job.own_programs.parameters == {"P46": 3.52}
    options, gauging = options_from(Options, job), options_from(Gauging, job)
    assert (options.weight, options.junctions) == (0.75, "part")
    assert (gauging.range_x_mm, gauging.range_z_mm) == (0.0015, 0.0005)
    assert job.output.folder == Path("out")


@pytest.mark.parametrize(
    "before, after, line, says",
    [
        ("nose_radius_mm = 0.8", "nose_radius_mm = -0.8", 10, "greater than or equal to 0, given -0.8"),
        ("nose_radius_mm = 0.8", "nose_radius = 0.8", 10, "'tool.nose_radius' is no key of this file"),
        ("nose_radius_mm = 0.8", "number = 1", 9, "give the nose radius once"),
        ("weight = 0.75", "weight = 1.5", 21, "less than or equal to 1, given 1.5"),
        ("weight = 0.75", "weight = nan", 21, "'compensation.weight'"),
        ("weight = 0.75", "wieght = 0.75", 21, "'compensation.wieght' is no key of this file"),
        ("weight = 0.75", 'weight = "most"', 21, "given 'most'"),
        ("start = [40.0, 0.0]", "", 1, "`start` = [x, z] of the first feature is missing"),
        ("start = [40.0, 0.0]", "start = [40.0, inf]", 3, "finite number, given inf"),
        ("start = [40.0, 0.0]", "start = [40.0]", 3, "'part.start.1': Field required"),
        ("radius = 40.0", "radius = 40.0, centre = [0.0, 30.0]", 4, "a centre or a radius, not both"),
        ('touches = "touches.csv"', "", 17, "'gauging': `touches` or `readings` is missing"),
        ("[tool]", "[toolz]", 9, "'toolz' is no key of this file"),
        ("[tool]\nnose_radius_mm = 0.8", "", None, "a table [tool], or a table [[tools]] for each"),
        ("[tool]", "[[tools]]", 9, "`number` is needed"),
        ("[tool]", "[feature.dome]\ntool = 3\n[tool]", None, "`feature.dome.tool` is not one of [[tools]]"),
    ],
)
def test_a_mistake_is_shown_with_key_value_and_line(
    path: Path, before: str, after: str, line: int | None, says: str
) -> None:
    refusal = _refusal(path, before, after)
    assert refusal.code is Code.JOB_KEY
    assert says in refusal.message
    assert (refusal.place.file, refusal.place.line) == (str(path), line)


@pytest.mark.parametrize(
    "before, after, meant",
    [
        ("weight = 0.75", "wieght = 0.75", "weight"),
        ("nose_radius_mm", "noseradius_mm", "nose_radius_mm"),
        ("radius = 40.0", "raduis = 40.0", "radius"),
        ("[gauging]", "[gaugin]", "gauging"),
    ],
)
def test_a_mistyped_key_is_answered_with_the_nearest(path: Path, before: str, after: str, meant: str) -> None:
    hints = [_refusal(path, before, after).hint]
    assert hints == [f"did you mean {meant!r}?"]


@pytest.mark.parametrize("source", ['dxf = "part.dxf"', 'step = "part.step"', "from_program = true"])
def test_two_sources_of_a_profile_are_refused(path: Path, source: str) -> None:
    refusal = _refusal(path, 'name = "step"', f'name = "step"\n{source}')
    assert "exactly one of `feature`, `dxf`, `step` and `from_program`" in refusal.message


def test_no_toml_is_refused_with_line_and_column(path: Path) -> None:
    refusal = _refusal(path, 'dialect = "linuxcnc"', "dialect = linuxcnc")
    assert refusal.code is Code.JOB_SYNTAX
    assert (refusal.place.line, refusal.place.column) == (13, 11)


@given(st.text(max_size=200))
def test_no_text_at_all_makes_it_fail_other_than_by_refusal(path: Path, text: str) -> None:
    for start in ("", JOB, "[part]\n"):
        try:
            _read(path, start + text.encode(errors="ignore").decode())
        except TrueloopError as refusal:
            assert refusal.code.startswith("JOB-")


@pytest.mark.parametrize(
    ("text", "first", "line", "words"),
    [
        (JOB.replace("weight = 0.75", "weight = 0.75\n# why\nweight = 0.5"), 21, 23, "the key 'weight' is given twice"),
        (JOB + "\n[tool]\nnumber = 3\n", 9, 23, "the table [tool] is given twice"),
        (JOB.replace("weight", '"weight"') + "weight = 1\n", 21, 22, "the key 'weight' is given twice"),
        (
            JOB + "features.dome.knot_every = 3\nfeatures.dome.knot_every = 4\n",
            22,
            23,
            "the key 'features.dome.knot_every'",
        ),
        (JOB + "nose_from = [\n]\nnose_from = [\n'a.toml',\n]\n", 22, 24, "the key 'nose_from' is given twice"),
    ],
)
def test_a_key_given_twice_is_named_with_both_lines(path: Path, text: str, first: int, line: int, words: str) -> None:
    path.write_text(text)
    with pytest.raises(TrueloopError) as refused:
        read_turned_job(path)
    assert refused.value.code is Code.JOB_SYNTAX
    assert refused.value.place.line == line
    assert words in refused.value.message
    assert f"in line {first} before" in refused.value.message


def test_the_same_key_in_tables_of_an_array_is_not_given_twice(path: Path) -> None:
    """The fault is elsewhere: the line that is no TOML is blamed."""
    path.write_text('[[part.feature]]\nname = "a"\n[[part.feature]]\nname = "b"\nto = \n')
    with pytest.raises(TrueloopError) as refused:
        read_turned_job(path)
    assert refused.value.place.line == 5 and "twice" not in refused.value.message
