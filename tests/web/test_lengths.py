"""The one place where the pages convert lengths, by arithmetic by hand; and that no page has another."""

import json
import re
import subprocess
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

WEB = Path(__file__).parents[2] / "web"
CONVERTS = WEB / "src" / "show" / "length.ts"
RUN = """const ts = require("typescript"), fs = require("fs");
const options = { compilerOptions: { module: ts.ModuleKind.CommonJS, target: ts.ScriptTarget.ES2022 } };
const made = { exports: {} };
new Function("exports", ts.transpileModule(fs.readFileSync(process.argv[1], "utf8"), options).outputText)(made.exports);
console.log(JSON.stringify(JSON.parse(process.argv[2]).map(([name, ...given]) => made.exports[name](...given))));"""
ITSELF = re.compile(r"25\.4|0\.0254|39\.37|[µu]in\b|µm|[\"'` ]mm\b(?![\":])")
"""A factor, or a unit beside a number or in a text."""
RAW = re.compile(r"\bnumber\([^)]*_(?:um|mm)\b|import .*\bsigned\b.*/format\"")
"""A length that is written as a number like any other; one with a sign is one."""


def asked(*calls: tuple[Any, ...]) -> list[Any]:
    """What functions of `length.ts` answer, each call its name and arguments."""
    done = subprocess.run(
        ["node", "-e", RUN, CONVERTS, json.dumps(calls)],
        capture_output=True,
        text=True,
        check=True,
        cwd=WEB,
        timeout=60,
    )
    found: list[Any] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize(
    ("given", "value", "shown"),
    [
        ("mm", 25.4, 1.0),
        ("mm", -19.05, -0.75),
        ("mm", 0.0127, 0.0005),
        ("um", 25.4, 1000.0),
        ("um", 2.54, 100.0),
        ("um", -0.0254, -1.0),
        ("um", 1.0, 39.37007874015748),
        ("um", 0.0, 0.0),
    ],
)
def test_an_inch_is_25_point_4_mm_and_a_microinch_a_millionth_of_it(given: str, value: float, shown: float) -> None:
    inch, metric = asked(("shownIn", "inch", given, value), ("shownIn", "mm", given, value))
    assert inch == pytest.approx(shown, rel=1e-15, abs=0)
    assert metric == value


def test_as_many_decimals_as_keep_the_resolution_and_none_more() -> None:
    """A step of the last decimal is at most that in mm, and ten times that is more."""
    cases = [(given, decimals) for given in ("mm", "um") for decimals in range(7)]
    inch = Decimal("25.4")
    found = asked(*(("decimalsIn", "inch", *case) for case in cases))
    for (given, decimals), digits in zip(cases, found, strict=True):
        step = Decimal(10) ** -digits * (inch if given == "mm" else inch / 1000)
        assert step <= Decimal(10) ** -decimals
        assert 10 * step > Decimal(10) ** -decimals or digits == 0
    assert asked(*(("decimalsIn", "mm", *case) for case in cases)) == [decimals for _, decimals in cases]
    assert found[4] == 6 and found[8] == 0  # 0.1 µm of a size: 0.000001 in; of an error: 1 µin


def test_a_number_and_its_unit_are_of_one_choice() -> None:
    names = asked(*(("nameOf", unit, given) for unit in ("mm", "inch") for given in ("mm", "um")))
    assert names == ["mm", "µm", "in", "µin"]
    assert asked(*(("isLength", one) for one in ("mm", "um", "deg", "σ", ""))) == [True, True, False, False, False]


@pytest.mark.parametrize(
    ("kept", "shown"),
    [
        (("radius_mm", "0.9987"), ["radius_in", "0.039319"]),
        (("flank_wear_mm", 0.127), ["flank_wear_in", "0.00500"]),
        (("nose_radius_mm", 0.8), ["nose_radius_in", "0.03150"]),
        (("left_um", "-12.7"), ["left_uin", "-500"]),
        (("minutes_in_cut", 35), ["minutes_in_cut", "35"]),
        (("verdict_mm", "made"), ["verdict_mm", "made"]),
        (("sha256", "12"), ["sha256", "12"]),
    ],
)
def test_a_value_kept_under_a_name_with_its_unit_changes_both_or_neither(
    kept: tuple[Any, ...], shown: list[str]
) -> None:
    assert asked(("namedIn", "inch", *kept), ("namedIn", "mm", *kept)) == [shown, [kept[0], str(kept[1])]]


def test_no_page_converts_a_length_or_names_its_unit_by_itself() -> None:
    """Their units stand in `length.ts` alone; a text has `{um}` and `{mm}`. A certificate is a document: µm stay."""
    found = []
    for file in sorted((WEB / "src").rglob("*.ts*")):
        if file in (CONVERTS, CONVERTS.with_name("lengths.ts"), WEB / "src" / "api" / "shapes.ts"):
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            code = re.sub(r"/\*\*?.*?(\*/|$)|^ \*.*|//.*", "", line)
            if (ITSELF.search(code) or RAW.search(code)) and '"certificate.u"' not in code and '"unit.' not in code:
                found.append(f"{file.relative_to(WEB)}:{number}: {line.strip()}")
    assert found == []
