"""Statements of DMIS: what belongs together, and every byte kept."""

from pathlib import Path

import pytest

from trueloop.formats.inspections.dmis.reader import dmis_text, statements_of
from trueloop.formats.inspections.dmis.words import Words, words_of


def _texts(text: str) -> list[str]:
    return [statement.text for statement in statements_of(text) if statement.text]


@pytest.mark.parametrize(
    "text",
    [
        "FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,0,0,1,8\n",
        "FA(A)=FEAT/CIRC$\nLE,OUTER,CART,1,2,3,0,0,1,8\n",
        "FA(A)=FEAT/CIRC$  \r\n   LE,OUTER,CART,1,2,3,0,0,1,$\r\n8\r\n",
        "FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,$$\n   0,0,1,8",
        "FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,$$ the axis follows\n0,0,1,8\n",
        "FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3\n  ,0,0,1\n,8\n",
        "FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,\n0,0,1,\n8\n",
        "FA(A)=FEAT/CIRCLE,OUTER,$$\nCART,1,2,3,$$\n$$ a comment among them\n0,0,1,8\n",
        "  FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,0,0,1,8   $$ and a comment\n",
        "FA($\n  A)=FEAT/CIRCLE,OUTER,CART,1,2,3,0,0,1,8\r",
    ],
)
def test_one_statement_however_it_is_broken(text: str) -> None:
    assert _texts(text) == ["FA(A)=FEAT/CIRCLE,OUTER,CART,1,2,3,0,0,1,8"]
    assert "".join(statement.raw for statement in statements_of(text)) == text


@pytest.mark.parametrize(
    ("text", "texts"),
    [
        ("$$ one comment\nENDFIL\n", ["ENDFIL"]),
        ("$$<MEAS name = 'cut$\n  here' >\nENDFIL\n", ["ENDFIL"]),
        ("$$ costs 5 $\nOUTPUT/FA(A)\n", ["OUTPUT/FA(A)"]),
        ("OUTPUT/FA(A),$$\nFA(A)=FEAT/POINT,CART,1,2,3\n", ["OUTPUT/FA(A),", "FA(A)=FEAT/POINT,CART,1,2,3"]),
        ("OUTPUT/FA(A),$$\nTA(B)\n", ["OUTPUT/FA(A),TA(B)"]),
        ("TEXT/OUTFIL,'costs $$ 5, it''s'\nENDFIL\n", ["TEXT/OUTFIL,'costs $$ 5, it''s'", "ENDFIL"]),
        ("TEXT/OUTFIL,'cut $\n  inside'\n", ["TEXT/OUTFIL,'cut   inside'"]),
        ("UNITS/MM\n\n\nENDFIL\n\x1a", ["UNITS/MM", "ENDFIL"]),
        ("", []),
    ],
)
def test_comments_texts_and_ends(text: str, texts: list[str]) -> None:
    assert _texts(text) == texts
    assert "".join(statement.raw for statement in statements_of(text)) == text


def test_a_statement_has_the_line_on_which_it_begins() -> None:
    found = [(s.line, s.text) for s in statements_of("$$ a\n\nUNITS/$\nMM\nENDFIL\n") if s.text]
    assert found == [(3, "UNITS/MM"), (5, "ENDFIL")]


@pytest.mark.parametrize(
    "content",
    [
        "FILNAM/'Welle'\r\nF(Größe)=FEAT/POINT,CART,1,2,3\n".encode(encoding)
        for encoding in ("utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252")
    ]
    + ["FILNAM/'轴'\r\nF(直径)=FEAT/POINT,CART,1,2,3\n".encode("gb18030"), b"\xfe\xff\x00U\x00N\x00\r\x00\n"],
)
def test_every_byte_is_kept_in_any_encoding(content: bytes) -> None:
    text, encoding = dmis_text(content, Path("part.dmo"))
    assert "".join(one.raw for one in statements_of(text)).encode(encoding) == content


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("FA(D1)=FEAT/CIRCLE, CART,1", Words("FA", "D1", "FEAT", ("CIRCLE", "CART", "1"), 7)),
        (
            "ta(d 1) = tol/cortol, xaxis, -0.9, intol",
            Words("TA", "d 1", "TOL", ("cortol", "xaxis", "-0.9", "intol"), 7),
        ),
        ("F(P(1))=FEAT/POINT", Words("F", "P(1)", "FEAT", ("POINT",), 7)),
        ("DATE=2026/02/01", Words("", "", "DATE", ("2026/02/01",), 7)),
        ("PN(a)='shaft, short'", Words("PN", "a", "", ("'shaft, short'",), 7)),
        ("PN(a)=PARTID/'shaft'", Words("PN", "a", "PARTID", ("'shaft'",), 7)),
        ("FILNAM/'C:/a/b.dmo',5.3", Words("", "", "FILNAM", ("'C:/a/b.dmo'", "5.3"), 7)),
        ("FEAT/CIRCLE,,,", Words("", "", "FEAT", ("CIRCLE", "", "", ""), 7)),
        ("ENDFIL", Words("", "", "ENDFIL", (), 7)),
        ("IF/(A .EQ. B)", Words("", "", "IF", ("(A .EQ. B)",), 7)),
        (",0,0,1", None),
        ("= 5", None),
    ],
)
def test_the_parts_of_a_statement(text: str, expected: Words | None) -> None:
    assert words_of(text, 7) == expected
