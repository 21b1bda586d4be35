"""Every code of the catalogue is produced, and what it says helps the person who reads it.

Each `test_<area>.py` beside this file holds `PRODUCERS`: for a code, a call that is refused with it or that returns
findings of which one has it.
"""

import ast
import importlib
import json
import pickle
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import pytest

from scripts.error_page import page
from tests.errors.expected import kept, words
from trueloop.cli.terminal import as_dict
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.report.texts.texts import Texts
from trueloop.wording import Wording

AREAS = sorted(file.stem for file in Path(__file__).parent.glob("test_*.py") if file != Path(__file__))
PRODUCERS: list[tuple[str, Code, Callable[[], object]]] = [
    (area, code, produce)
    for area in AREAS
    for code, produce in importlib.import_module(f"tests.errors.{area}").PRODUCERS.items()
]
SOURCE = Path(__file__).parents[2] / "src"
READ_BY_PEOPLE = (
    *(Code.CMP_ALLOWANCE, Code.CMP_CUT_WITH, Code.CMP_SCATTER, Code.CMP_SIZE, Code.CMP_STOCK, Code.CMP_TWICE),
    *(Code.FAC_ALARM, Code.FAC_ARM, Code.FAC_HELD, Code.FAC_ORDERED, Code.FAC_PLAN, Code.FAC_RELEASE, Code.FAC_ROLE),
    *(Code.FAC_STALE, Code.FAC_STATE, Code.FAC_UNKNOWN, Code.GEO_AXIS, Code.GEO_DXF_CHOICE, Code.GEO_DXF_UNIT),
    *(Code.GEO_NOSE, Code.MIL_CONTRADICTED, Code.MIL_CORNER, Code.MIL_CUT, Code.MIL_ENTRY, Code.MIL_LARGE),
    *(Code.MIL_NOMINAL, Code.MIL_NONE, Code.MIL_NOT_CUT, Code.MSR_FEATURE, Code.MSR_FORMAT),
    *(Code.MSR_NOMINAL, Code.MSR_NUMBER, Code.MSR_OLD, Code.NC_AMBIGUOUS, Code.NC_BORE, Code.NC_NO_TOOL, Code.NC_TOOLS),
    *(
        Code.SET_DATUM,
        Code.SET_EDGE,
        Code.SET_FEATURE,
        Code.SET_MIRROR,
        Code.SRV_ACCOUNT,
        Code.SRV_DELAY,
        Code.SRV_FILE,
    ),
    *(Code.SRV_INTERNAL, Code.SRV_KEYS, Code.SRV_LARGE, Code.SRV_LOGIN, Code.SRV_PASSWORD, Code.SRV_ROLE),
    *(Code.SRV_SIGN_IN, Code.SRV_STALE, Code.SRV_UNKNOWN, Code.STO_CLOCK, Code.STO_OTHER_PART, Code.STO_STAGE),
    *(Code.STO_UNIT, Code.TOL_FIT, Code.TOL_SIZE, Code.TOL_TEXT),
)
"""What people at the pages bring about; every other code that pages meet has its meaning in German."""
NUMBER = re.compile(r"(?<![\w.])[+-]?(?:\d+\.?\d*|inf|nan)(?:e[+-]?\d+)?")
UNITS = ("um", "mm", "deg", "h", "s", "um_per_mm", "mm_per_min")
NUMBER_OR_QUOTED = re.compile(r"\d|'[^']+'|\"[^\"]+\"|`[^`]+`")


@pytest.fixture(scope="module")
def expected() -> dict[str, str]:
    return kept()


def complaint(code: Code, produce: Callable[[], object]) -> TrueloopError | Finding:
    """The error raised, or the finding of that code among those returned."""
    try:
        produced = produce()
    except TrueloopError as error:
        return error
    findings = produced if isinstance(produced, Iterable) else [produced]
    of_this_code = [item for item in findings if isinstance(item, Finding) and item.code is code]
    assert of_this_code, f"neither raised nor found: {produced!r}"
    return of_this_code[0]


def test_every_code_is_produced() -> None:
    missing = set(Code) - {code for _, code, _ in PRODUCERS}
    assert not missing, f"no test produces {', '.join(sorted(missing))}"


def test_every_code_is_its_name_in_words() -> None:
    assert all(code.value == code.name.replace("_", "-") for code in Code)


@pytest.mark.parametrize(
    ("area", "code", "produce"),
    [pytest.param(area, code, produce, id=f"{area.removeprefix('test_')}-{code}") for area, code, produce in PRODUCERS],
)
def test_the_complaint_names_code_values_hint_and_place_and_carries_the_values_it_prints(
    area: str, code: Code, produce: Callable[[], object], expected: dict[str, str]
) -> None:
    said = complaint(code, produce)
    assert said.code is code
    assert words(said) == expected[f"{area} {code}"], "if it is meant so: python -m tests.errors.expected"
    assert NUMBER_OR_QUOTED.search(said.message), f"no value in {said.message!r}"
    assert said.hint.strip()
    if isinstance(said, TrueloopError):
        place = "".join(
            f"{part}:" for part in (said.place.file, said.place.line, said.place.column) if part is not None
        )
        assert str(said).startswith(f"{place} {code}: {said.message}" if place else f"{code}: {said.message}")
        assert f"hint: {said.hint}" in str(said)
        assert said.override is None or said.override in str(said)
    _carries_what_it_prints(code, said)


@pytest.mark.parametrize("code", READ_BY_PEOPLE)
def test_a_german_page_states_it_in_german_with_the_values(code: Code) -> None:
    """Of those that a mistyped value or a wrong click brings about, all is said; of others the meaning of the code."""
    (produce, *_) = [produce for _, one, produce in PRODUCERS if one is code]
    said, say = complaint(code, produce), Texts("de")
    text = say.refusal(code.meaning, said.message)
    assert isinstance(said.message, Wording) and text != said.message and "{" not in text
    values = [said.message.values[name] for name in said.message.values]
    assert all(f"{value}" in text for value in values if isinstance(value, int))


def _carries_what_it_prints(code: Code, said: TrueloopError | Finding) -> None:
    assert set(said.values) == set(code.values)
    for name, given in said.values.items():
        each: list[float | str] = [given] if isinstance(given, (str, float, int)) else list(given)
        assert {type(value) for value in json.loads(json.dumps(each))} <= {float, int, str}
        if name.endswith(tuple(f"_{unit}" for unit in UNITS)):
            assert all(isinstance(value, float) for value in each), f"{name} has a unit: {given!r}"
        for value in each:
            assert _stands_in(said.message, value), f"{name} = {value!r} is not in {said.message!r}"


def _stands_in(message: str, value: float | str) -> bool:
    """A text as it is, or as much of it as a message shows; a number to the digits printed, a size without its sign."""
    if isinstance(value, str):
        return value[:16] in message
    printed = NUMBER.findall(message)
    return any(_same(text, value) or (text[0] not in "+-" and _same(text, -value)) for text in printed)


def _same(printed: str, value: float) -> bool:
    digits, _, power = printed.partition("e")
    step = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
    return abs(float(printed) - value) <= 0.5 * step * (1 + 1e-9)


@pytest.mark.parametrize(("printed", "value"), [("13.3", 13.26), ("-0.5", -0.51), ("1.6e-08", 1.55e-8), ("40", 40.4)])
def test_a_printed_number_is_a_value_rounded(printed: str, value: float) -> None:
    assert _same(printed, value)
    assert not _same(printed, value * 1.1)


def _raised() -> Iterator[tuple[str, Code, ast.Call]]:
    """Every place in the source where an error or finding is made whose code is written there."""
    for file in sorted(SOURCE.glob("trueloop*/**/*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                codes = [ast.unparse(given) for given in node.args] if called in ("TrueloopError", "Finding") else []
                for code in (*codes, called.removesuffix(".refusal")):
                    if re.fullmatch(r"Code\.[A-Z0-9_]+", code):
                        yield f"{file.name}:{node.lineno}", Code[code.removeprefix("Code.")], node


def test_every_place_that_raises_a_code_gives_the_values_that_the_code_names() -> None:
    places = list(_raised())
    assert len(places) > 200
    for where, code, call in places:
        given = next((keyword.value for keyword in call.keywords if keyword.arg == "values"), ast.Dict([], []))
        if isinstance(given, ast.Dict):
            names = {ast.literal_eval(key) for key in given.keys if key}
            if ast.unparse(call.func).endswith(".refusal") and any(keyword.arg == "place" for keyword in call.keywords):
                names |= {"file"} & set(code.values)  # its place names the file
            assert names == set(code.values), f"{where}: {code}"


def test_values_stay_on_their_way_to_the_user() -> None:
    values = {"size_um": 160.2, "limit_um": 150.0}
    found = Finding(Severity.ERROR, Code.CMP_SIZE, "160.2 µm, 150.0 µm", "look at it", Place(line=3), values)
    error = found.as_error()
    for same in (error, error.in_file("part.nc"), pickle.loads(pickle.dumps(error)), found.in_file("part.nc")):
        assert same.values == values
    assert as_dict(error)["values"] == values


def test_a_value_that_is_no_number_is_null_in_json() -> None:
    error = TrueloopError(Code.GEO_NOSE, "nose radius nan mm", hint="give it", values={"nose_radius_mm": float("nan")})
    assert json.loads(json.dumps(as_dict(error), allow_nan=False))["values"] == {"nose_radius_mm": None}


def test_every_code_has_a_meaning_of_its_own() -> None:
    meanings = [code.meaning for code in Code]
    assert all(meanings)
    assert len(set(meanings)) == len(meanings)


def test_the_page_of_errors_has_every_code_once_in_its_order() -> None:
    assert re.findall(r"^\| `([A-Z-]+)` \|", page(), re.M) == [str(code) for code in Code]
