"""Entities of a drawing beside those that ezdxf reads from the whole file."""

import math
import random
from pathlib import Path

import ezdxf.filemanagement
import pytest
from ezdxf.document import Drawing
from hypothesis import given
from hypothesis import strategies as st

from trueloop import example
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.dxf import read_dxf
from trueloop.formats.cad.dxf_document import DrawnEntity, drawn, open_document
from trueloop.formats.cad.dxf_entities import edges_of, unfolded

VERSIONS = ("R12", "R2000", "R2010")
KINDS = ("line", "arc", "circle", "text", "polyline", "old polyline", "spline", "insert", "paper", "behind", "thick")


def all_by_ezdxf(path: Path) -> list[DrawnEntity]:
    return [drawn(entity) for entity in ezdxf.filemanagement.readfile(path).modelspace()]


def same(path: Path, scale: float = 1.0) -> None:
    """Kinds, layers and line types are equal, and so are the edges but for the last digit of a cosine."""
    mine, theirs = open_document(path).entities, all_by_ezdxf(path)
    assert [one[:3] for one in mine] == [one[:3] for one in theirs]
    edges, by_ezdxf = (edges_of(unfolded(each), scale) for each in (mine, theirs))
    assert edges.layer.tolist() == by_ezdxf.layer.tolist()
    for ours, expected in zip(edges.features, by_ezdxf.features, strict=True):
        assert type(ours) is type(expected)
        for a, b in ((ours.start_mm, expected.start_mm), (ours.end_mm, expected.end_mm)):
            assert math.dist(a, b) <= 1e-12 * scale * 400
        assert ours.length_mm == pytest.approx(expected.length_mm, rel=1e-12)
        assert getattr(ours, "sweep_rad", 0.0) == getattr(expected, "sweep_rad", 0.0)


def mixed(version: str, kinds: list[str], seed: int) -> Drawing:
    """Entities of many kinds, on layers that are hidden, dashed or absent from the table."""
    chance, document = random.Random(seed), ezdxf.filemanagement.new(version, setup=True, units=4)
    document.layers.add("hidden").off()
    document.layers.add("Achse", linetype="CENTER")
    document.blocks.new("plate").add_line((0, 0), (3, 4))
    space = document.modelspace()
    for kind in kinds:
        (x, y), (u, v) = ((chance.uniform(-400, 400), chance.uniform(-400, 400)) for _ in range(2))
        given = {"layer": chance.choice(["0", "hidden", "Achse", "Größe 1"]), "color": chance.randint(1, 9)}
        if chance.random() < 0.3:
            given["linetype"] = chance.choice(["CENTER", "Dashed"])
        if kind in ("line", "paper", "thick"):
            at = document.paperspace() if kind == "paper" else space
            at.add_line((x, y, 1.0), (u, v), dxfattribs=given | ({"thickness": 2} if kind == "thick" else {}))
        elif kind in ("arc", "behind"):
            extra = {"extrusion": (0, 0, -1)} if kind == "behind" else {}
            space.add_arc((x, y), abs(u) + 1, v, v + chance.uniform(1, 500), dxfattribs=given | extra)
        elif kind == "circle":
            space.add_circle((x, y), abs(u) + 1, dxfattribs=given)
        elif kind == "text":
            space.add_text("Ø 20", dxfattribs=given)
        elif kind == "polyline" and version != "R12":
            space.add_lwpolyline([(x, y, 0.3), (u, v, 0)], format="xyb", dxfattribs=given)
        elif kind == "old polyline":
            space.add_polyline2d([(x, y, 0.3), (u, v, 0)], format="xyb", dxfattribs=given)
        elif kind == "spline" and version != "R12":
            space.add_open_spline([(x, y), (x + 5, y + 3), (x + 9, y), (x + 12, y + 5)], dxfattribs=given)
        elif kind == "insert":
            space.add_blockref("plate", (x, y), dxfattribs={**given, "rotation": v})
    return document


@given(st.sampled_from(VERSIONS), st.lists(st.sampled_from(KINDS), max_size=30), st.integers(0, 2**32))
def test_every_entity_is_as_ezdxf_reads_it(
    tmp_path_factory: pytest.TempPathFactory, version: str, kinds: list[str], seed: int
) -> None:
    path = tmp_path_factory.mktemp("dxf") / "mixed.dxf"
    mixed(version, kinds, seed).saveas(path)
    same(path)
    same(path, 25.4)


def test_a_drawing_of_a_cad_system() -> None:
    same(example("dxf/piecs11.dxf"))


def damaged(path: Path, old: str, new: str) -> Path:
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
    return path


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (" 10\n1.5\n", " 10\n1,5\n"),
        (" 10\n1.5\n", " 10\n1.5\n 10\n2.5\n"),
        (" 10\n1.5\n", "999\nby hand\n 10\n1.5\n"),
        (" 10\n1.5\n 20\n", " 20\n1.5\n 10\n"),
        (" 10\n1.5\n", " 10\nnan\n"),
        (" 10\n1.5\n", "ten\n1.5\n"),
        ("  8\nouter\n", "  8\nou<er\n"),
        ("  8\nouter\n", "  8\n\\U+00D8\n"),
        ("  8\nouter\n", "  8\n\n"),
        ("  8\nouter\n", ""),
        ("  8\nouter\n", "  8\nouter\n 67\n1\n"),
        ("  8\nouter\n", "  8\nouter\n 62\nred\n"),
        (" 21\n4.5\n", ""),
    ],
)
@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_unusual_is_read_or_refused_as_by_ezdxf(version: str, old: str, new: str, tmp_path: Path) -> None:
    document, path = ezdxf.filemanagement.new(version), tmp_path / "line.dxf"
    document.modelspace().add_line((1.5, 2.5), (3.5, 4.5), dxfattribs={"layer": "outer"})
    document.modelspace().add_line((7, 7), (8, 8))
    document.saveas(path)
    damaged(path, old, new)

    def result(read: object) -> object:
        try:
            return [
                (one[:3], one.numbers or [str(one.entity.dxf.get(name)) for name in ("start", "end")])
                for one in read(path)  # type: ignore[operator]
            ]
        except Exception as error:
            return type(error), str(error)

    theirs = result(all_by_ezdxf)
    ours = result(lambda path: [again(one) for one in open_document(path).entities])
    assert str(ours) == str(theirs)


def again(one: DrawnEntity) -> DrawnEntity:
    """A plain line as an entity of ezdxf, to compare with."""
    if one.entity is not None:
        return one
    x0, y0, x1, y1 = one.numbers
    line = ezdxf.filemanagement.new("R12").modelspace().add_line((x0, y0, 0), (x1, y1, 0))
    return one._replace(numbers=(), entity=line)


def test_a_damaged_file_is_refused_in_the_words_of_ezdxf(tmp_path: Path) -> None:
    document, path = ezdxf.filemanagement.new("R12"), tmp_path / "line.dxf"
    document.modelspace().add_line((1, 2.5), (2, 4.5))
    document.saveas(path)
    path.write_text(path.read_text("utf-8").removesuffix("  0\nEOF\n"), "utf-8")
    with pytest.raises(TrueloopError, match="EOF") as refusal:
        read_dxf(path)
    assert refusal.value.code is Code.GEO_DXF
