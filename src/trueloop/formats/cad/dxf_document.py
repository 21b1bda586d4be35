"""Opens a DXF drawing. Plain lines and arcs, of which it may hold 100,000, are read here; all else is left to ezdxf.

An entity is plain if its group codes are those that every CAD system writes, each once, in the plane and in model
space. ezdxf reads the file without them: in its place each run of them has one point on a layer of its own.
"""

import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ezdxf.document import Drawing

RUN: Final = "run-of-plain-entities-5c1f0b2e"
"""The layer of the points that stand for runs of plain entities."""
BLOCK_LINES: Final = 1 << 17
"""Lines of the file that are looked at together; an even number."""
PLAIN: Final = {
    "LINE": ((10, 20, 11, 21), ("AcDbEntity", "AcDbLine"), (10, 11)),
    "ARC": ((10, 20, 40, 50, 51), ("AcDbEntity", "AcDbCircle", "AcDbArc"), (10,)),
    "CIRCLE": ((10, 20, 40), ("AcDbEntity", "AcDbCircle"), (10,)),
}
"""By kind: group codes of its numbers, its subclass markers, and the codes that begin its points."""
ASIDE_INT: Final = {62, 370, 420}
ASIDE: Final = {0, 5, 6, 8, 100, 330} | ASIDE_INT
"""Group codes besides: handle, line type, layer, marker, owner, colours, width of the line."""


class DrawnEntity(NamedTuple):
    """An entity: kind, layer, own line type in small letters; its `numbers` in the order of `PLAIN`, or ezdxf's."""

    kind: str
    layer: str
    line_type: str
    numbers: tuple[float, ...]
    entity: Any


@dataclass(frozen=True)
class Document:
    """A drawing, and the entities of its model space in the order of the file."""

    drawing: "Drawing"
    entities: tuple[DrawnEntity, ...]


class _UnusualError(ValueError):
    """The file is not laid out so that plain entities could be separated from the rest."""


class _Shape(NamedTuple):
    """Where in a plain entity its values are."""

    numbers: tuple[int, ...]
    checked: tuple[int, ...]
    """Coordinates z, which do not count but have to be numbers."""
    ints: tuple[int, ...]
    layer: int
    line_type: int
    owner: int
    markers: tuple[int, ...]


def drawn(entity: Any) -> DrawnEntity:
    """Returns an entity of ezdxf as drawn; on layer 0, as the format has it, where it names none."""
    line_type = str(entity.dxf.get("linetype", "BYLAYER")).casefold()
    return DrawnEntity(entity.dxftype(), str(entity.dxf.get("layer", "0")), line_type, (), entity)


def open_document(path: Path) -> Document:
    """Opens a drawing. Raises what ezdxf raises of it."""
    # ezdxf takes a tenth of a second to import, and most jobs have no drawing.
    from ezdxf.filemanagement import read, readfile
    from ezdxf.lldxf.const import DXFError

    try:
        rest, runs, owners = _separated(path)
        drawing = read(rest)
    except (ValueError, LookupError, TypeError, AttributeError, StopIteration, DXFError):
        drawing, runs = readfile(path), []  # either reads it or refuses it with its place in the file
    else:
        if owners & {layout.layout_key for layout in drawing.layouts if layout.name != "Model"}:
            drawing, runs = readfile(path), []
    return Document(drawing, tuple(_in_order(drawing, runs)))


def _in_order(drawing: "Drawing", runs: Sequence[list[DrawnEntity]]) -> Iterator[DrawnEntity]:
    for entity in drawing.modelspace():
        one = drawn(entity)
        if one.layer == RUN and one.kind == "POINT" and runs:
            yield from runs[int(entity.dxf.location.x)]
        else:
            yield one


def _separated(path: Path) -> tuple[io.StringIO, list[list[DrawnEntity]], set[str]]:
    """The file without its plain entities, these in runs, and the handles of their owners. Raises _UnusualError."""
    from ezdxf.filemanagement import dxf_file_info
    from ezdxf.lldxf.validator import is_binary_dxf_file, is_dxf_file

    if is_binary_dxf_file(str(path)) or not is_dxf_file(str(path)):
        raise _UnusualError
    info = dxf_file_info(path)
    with_markers = info.version > "AC1009"
    rest, runs, owners = io.StringIO(), list[list[DrawnEntity]](), set[str]()
    sections, inside, in_run, linked = 0, False, False, False
    with path.open(encoding=info.encoding, errors="surrogateescape") as file:
        for spans, codes, values, lines in _entities(file):
            plain = _plain_of(spans, codes, values, with_markers, owners)
            for a, b in spans:
                if inside and not linked and a in plain:
                    if not in_run:
                        rest.write(f"0\nPOINT\n8\n{RUN}\n10\n{len(runs)}\n20\n0\n30\n0\n")
                        runs.append([])
                    runs[-1].append(plain[a])
                    in_run = True
                    continue
                in_run = False
                kind = values[a].rstrip("\n") if a < len(values) and codes[a] == 0 else ""
                if kind == "SECTION":
                    inside = codes[a + 1 : min(a + 2, b)] == [2] and values[a + 1].rstrip("\n") == "ENTITIES"
                    sections += inside
                elif kind == "ENDSEC":
                    inside = False
                linked = kind in ("POLYLINE", "VERTEX", "ATTRIB") or (kind == "INSERT" and 66 in codes[a:b])
                rest.writelines(lines[2 * a : 2 * b])
    if sections != 1:
        raise _UnusualError
    rest.seek(0)
    return rest, runs, owners


class _Codes(dict[str, int]):
    """Group codes by the lines that hold them."""

    def __missing__(self, line: str) -> int:
        self[line] = code = int(line)
        return code


def _entities(file: Iterator[str]) -> Iterator[tuple[list[tuple[int, int]], list[int], list[str], list[str]]]:
    """By block of the file, where entities, from each code 0 to the next, begin and end; group codes, values, lines.

    Raises ValueError where a group code is expected and something else stands.
    """
    known = _Codes()
    lines, codes, more = list[str](), list[int](), True
    while more:
        block = list(islice(file, BLOCK_LINES))
        more = len(block) == BLOCK_LINES
        lines += block
        codes += [known[line] for line in block[::2]]
        starts = [0, *(k for k, code in enumerate(codes) if code == 0 and k), *([] if more else [len(codes)])]
        if codes:
            yield list(pairwise(starts)), codes, lines[1::2], lines
        last = starts[-1]
        del lines[: 2 * last], codes[:last]


def _plain_of(
    spans: Sequence[tuple[int, int]], codes: list[int], values: list[str], with_markers: bool, owners: set[str]
) -> dict[int, DrawnEntity]:
    """The plain ones of entities, by where they begin; those of one kind and of the same codes are read together."""
    alike: dict[tuple[str, tuple[int, ...]], list[int]] = {}
    for a, b in spans:
        if codes[a] == 0 and b <= len(values):
            alike.setdefault((values[a].rstrip("\n"), tuple(codes[a:b])), []).append(a)
    found: dict[int, DrawnEntity] = {}
    for (kind, own), at in alike.items():
        if kind in PLAIN and (shape := _shape(kind, own)):
            markers = PLAIN[kind][1] if with_markers else ()
            marked = [a for a in at if tuple([values[a + k].rstrip("\n") for k in shape.markers]) == markers]
            found |= _plain(kind, shape, marked, values, owners)
    return found


def _plain(kind: str, shape: _Shape, at: list[int], values: list[str], owners: set[str]) -> dict[int, DrawnEntity]:
    """Entities of one shape, by where they begin; none where a number of one of them is not plain."""
    try:
        numbers = [[float(values[a + k]) for a in at] for k in shape.numbers]
        aside = [[float(values[a + k]) for a in at] for k in shape.checked]
        for k in shape.ints:
            for a in at:
                int(values[a + k])
    except ValueError:
        return {}
    layer, line_type = (
        [_name(values[a + k]) for a in at] if k else [""] * len(at) for k in (shape.layer, shape.line_type)
    )
    finite = np.all(np.isfinite([*numbers, *aside]), axis=0).tolist()
    found = {
        a: DrawnEntity(kind, of or "0", own.casefold() or "bylayer", row, None)
        for a, of, own, row, usual in zip(at, layer, line_type, zip(*numbers, strict=True), finite, strict=True)
        if usual and of is not None and own is not None
    }
    if shape.owner:
        owners |= {values[a + shape.owner].rstrip("\n") for a in found}
    return found


@lru_cache(maxsize=256)
def _shape(kind: str, codes: tuple[int, ...]) -> _Shape | None:
    """Where the values of an entity are, if it is plain."""
    numbers, _, points = PLAIN[kind]
    heights = {first + 20 for first in points}
    once = [code for code in codes if code != 100]
    if len(set(once)) != len(once) or not set(numbers) <= set(codes) or set(codes) - ASIDE - heights - set(numbers):
        return None
    at = {code: k for k, code in enumerate(codes)}
    for first in points:  # x, y and z of a point follow one another
        if at[first + 10] != at[first] + 1 or at.get(first + 20, at[first] + 2) != at[first] + 2:
            return None
    marks = tuple(k for k, code in enumerate(codes) if code == 100)
    if marks and not _in_their_classes(at, marks, numbers):
        return None
    return _Shape(
        numbers=tuple(at[code] for code in numbers),
        checked=tuple(at[code] for code in heights & set(at)),
        ints=tuple(at[code] for code in ASIDE_INT & set(at)),
        layer=at.get(8, 0),
        line_type=at.get(6, 0),
        owner=at.get(330, 0),
        markers=marks,
    )


def _in_their_classes(at: dict[int, int], marks: Sequence[int], numbers: Sequence[int]) -> bool:
    """Returns whether layer and line type follow the first subclass marker, geometry the second, angles the third."""
    ends = [*marks, math.inf]
    if len(marks) < 2 or not all(ends[0] < at.get(code, ends[0] + 0.5) < ends[1] for code in (8, 6)):
        return False
    return all(marks[-1] < at[code] if code in (50, 51) else marks[1] < at[code] < ends[2] for code in numbers)


@lru_cache(maxsize=4096)
def _name(line: str) -> str | None:
    """A name of a layer or a line type; None of one that ezdxf has rules for."""
    from ezdxf.lldxf.validator import is_valid_table_name

    name = line.rstrip("\n")
    usual = name and name == name.strip() and "\\" not in name and name != RUN and is_valid_table_name(name)
    return name if usual else None
