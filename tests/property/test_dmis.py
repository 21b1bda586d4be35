"""DMIS however it is written: broken into lines anywhere, with other blanks and capitals, damaged."""

import random
from dataclasses import fields
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from tests.support.dmis import read_text
from trueloop.domain.inspection import CmmPoint, Reading
from trueloop.errors import TrueloopError
from trueloop.formats.inspections.dmis.reader import dmis_text, statements_of

LABELS = st.text("ABCxyz019-_.", min_size=1, max_size=8)
LENGTHS = st.integers(-(10**7), 10**7).map(lambda tenths: f"{tenths / 1e4:.4f}")
UNIT = st.sampled_from(["1,0,0", "0,0,1", "0.8,0,-0.6", ",,", "0,-1,0"])


@st.composite
def _features(draw: st.DrawFn) -> list[str]:
    """Nominal and measured feature, tolerance and result of one point or circle."""
    label, normal = draw(LABELS), draw(UNIT)
    places = [",".join(draw(LENGTHS) for _ in range(3)) for _ in range(2)]
    point = draw(st.booleans())
    form, what = ("POINT,CART", "PROFP") if point else ("CIRCLE,OUTER,CART", "DIAM")
    sizes = ["", ""] if point else [f",{draw(st.integers(1, 10**6)) / 1e4:.4f}" for _ in range(2)]
    return [
        f"OUTPUT/F({label}),T({label}_T)",
        f"F({label})=FEAT/{form},{places[0]},{normal}{sizes[0]}",
        f"T({label}_T)=TOL/{what},-0.1,0.1",
        f"OUTPUT/FA({label}),TA({label}_T)",
        f"FA({label})=FEAT/{form},{places[1]},{normal}{sizes[1]}",
        f"TA({label}_T)=TOL/{what},{draw(LENGTHS)},INTOL",
    ]


FILES = st.lists(_features(), min_size=1, max_size=4).map(
    lambda each: ["UNITS/MM,ANGDEC", *(line for lines in each for line in lines), "ENDFIL"]
)


def _values(text: str) -> list[tuple[object, ...]]:
    """All that is read but the lines, which depend on how the text is broken."""
    values = []
    for inspection in read_text(text).inspections:
        for value in inspection.values:
            assert isinstance(value, (Reading, CmmPoint))
            values.append(tuple(getattr(value, one.name) for one in fields(value) if one.name != "line"))
    return values


@given(FILES, st.integers(0, 2**32), st.sampled_from(["\n", "\r\n", "\r"]))
def test_statements_broken_into_lines_anywhere_are_read_the_same(lines: list[str], seed: int, end: str) -> None:
    chance = random.Random(seed)
    broken = [piece for line in lines for piece in _broken(line, chance)]
    assert _values(end.join([*broken, ""])) == _values("\n".join([*lines, ""]))


def _broken(line: str, chance: random.Random) -> list[str]:
    """One statement over several lines: cut with `$`, behind a comma with `,$$`, or before a comma."""
    pieces, indent, rest = [], "", line
    while len(rest) > 2 and chance.random() < 0.6:
        cut = chance.randrange(1, len(rest))
        commas = [k for k, letter in enumerate(rest) if letter == "," and k > 0]
        way = chance.choice(["$", ",$$", ","]) if commas else "$"
        if way == "$":
            end = "$" + " " * chance.randrange(3)
        elif way == ",$$":
            cut = chance.choice(commas) + 1
            end = "$$" + chance.choice(["", " a comment"])
        else:
            cut = chance.choice(commas)
            end = ""
        pieces.append(indent + rest[:cut] + end)
        indent, rest = " " * chance.randrange(4), rest[cut:]
    if not pieces and chance.random() < 0.2:
        pieces.append("$$ a comment of its own")
    return [*pieces, indent + rest]


@given(FILES, st.booleans())
def test_blanks_between_fields_and_small_letters_change_nothing(lines: list[str], small: bool) -> None:
    spread = [line.replace(",", " ,  ") for line in lines]
    text = "\n".join([*spread, ""])
    expected = _values("\n".join([*lines, ""]))
    if small:  # labels are shown as they are written
        text, expected = text.lower(), _lowered(expected)
    assert _values(text) == expected


def _lowered(values: list[tuple[object, ...]]) -> list[tuple[object, ...]]:
    words = (" DIAM", " XAXIS", " YAXIS", " ZAXIS")
    return [tuple(_lower(item, words) if type(item) is str else item for item in value) for value in values]


def _lower(text: str, words: tuple[str, ...]) -> str:
    return next((text.removesuffix(word).lower() + word for word in words if text.endswith(word)), text.lower())


@given(st.text("FAT()=$,'/\r\n ab1.-\x1a\ufeffé", max_size=80))
def test_every_byte_is_kept(text: str) -> None:
    assert "".join(statement.raw for statement in statements_of(text)) == text
    content = text.encode()
    decoded, encoding = dmis_text(content, Path("part.dmo"))
    assert decoded.encode(encoding) == content


@given(FILES, st.integers(0, 2**32), st.integers(1, 12))
def test_a_damaged_file_is_read_or_refused_and_nothing_else(lines: list[str], seed: int, count: int) -> None:
    chance = random.Random(seed)
    content = bytearray("\n".join(lines).encode())
    for _ in range(count):
        place = chance.randrange(len(content))
        what = chance.randrange(4)
        if what == 0:
            content[place] = chance.randrange(256)
        elif what == 1:
            content[place : place + 1] = chance.choice(
                [b"$", b",", b"'", b"\n", b"$$", b"(", b")", b"=", b"/", b"1e999"]
            )
        elif what == 2:
            del content[place : place + chance.randrange(1, 20)]
        else:
            content[place:place] = content[: chance.randrange(1, 60)]
        content = content or bytearray(b" ")
    try:
        file = read_text(bytes(content))
    except TrueloopError as error:
        assert error.code.startswith("MSR-")
        return
    for inspection in file.inspections:
        assert inspection.count == len(inspection.values) > 0
