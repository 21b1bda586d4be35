"""The elements of a QIF document that results need, one after the other: memory does not grow with the rest of it.

Expat gives them: it counts lines beyond 65535 and hands over long text in pieces. What a hostile file could do is
refused: a DOCTYPE (entities expand to any size, or name other files), nesting and single elements without bound.
"""

import codecs
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.parsers import expat

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.shared.text import HINT, MARKS, NUMBER

CHUNK: Final = 1 << 16
MAX_DEPTH: Final = 200
MAX_MARKUP: Final = 1 << 24
"""Bytes of one tag or comment."""
MAX_TEXT: Final = 1 << 25
"""Characters of one element's text: 500 000 points. What is longer is left out, and `cut` says so."""
MAX_PARTS: Final = 1 << 20
"""Elements within one record."""
MAX_RECORDS: Final = 5_000_000
"""Records of one file: what is kept of them fits into 3 GB."""
BEGINNINGS: Final = {"QIFDocument", "MeasurementResults"}
"""Come when they begin, without their parts."""
ALWAYS: Final = BEGINNINGS | {"FileUnits", "InspectionTraceability", "ActualComponentIds"}
WITHIN: Final = {
    "MeasurementDevices",
    "PartSet",
    "AssemblySet",
    "ComponentSet",
    "AsmPaths",
    "FeatureNominals",
    "FeatureItems",
    "ToleranceDefinitions",
    "CharacteristicDefinitions",
    "CharacteristicNominals",
    "CharacteristicItems",
    "MeasuredFeatures",
    "FeatureActuals",
    "FeatureMeasurements",
    "PointSets",
    "MeasuredPointSets",
    "CharacteristicActuals",
    "CharacteristicMeasurements",
    "ActualComponentSet",
    "ExternalQIFReferences",
}
"""Lists whose members are records."""
DECLARED: Final = re.compile(rb"""^\s*<\?xml[^>]*encoding\s*=\s*["']([\w.:-]+)""")


@dataclass(slots=True)
class Element:
    """An element with its parts; `text` is its own, stripped. `cut`: its text was too long to be kept."""

    name: str
    attributes: dict[str, str]
    line: int
    text: str = ""
    parts: list["Element"] = field(default_factory=list)
    cut: bool = False

    def first(self, *names: str) -> "Element | None":
        """Returns the first part of the first name, of that the first of the second name, and so on; None: missing."""
        found: Element | None = self
        for name in names:
            found = next((part for part in found.parts if part.name == name), None) if found else None
        return found

    def words(self, *names: str) -> str:
        """Returns the text of that part; empty where there is none."""
        found = self.first(*names)
        return "" if found is None else found.text

    def every(self, name: str) -> Iterator["Element"]:
        """Yields all parts of this name, at any depth."""
        for part in self.parts:
            if part.name == name:
                yield part
            yield from part.every(name)


def records(path: Path) -> Iterator[tuple[str, Element]]:
    """Yields elements of `ALWAYS` or in a list of `WITHIN`, with the name of the element around, in the file's order.

    Raises MSR-FILE for anything that is not XML, MSR-SIZE for what passes a bound.
    """
    reader = _Reader(path)
    yield from reader.read()


def encoding_of(head: bytes) -> str:
    """Returns the encoding that a document's first bytes mark or declare; UTF-8 where they do neither."""
    marked = next((name for mark, name in MARKS if head.startswith(mark)), None)
    for start, name in ((b"<\0", "utf-16-le"), (b"\0<", "utf-16-be")):
        marked = marked or (name if head.startswith(start) else None)
    declared = DECLARED.match(head)
    return marked or (declared[1].decode("ascii").lower() if declared else "utf-8")


class _Reader:
    def __init__(self, path: Path) -> None:
        self.path, self.count = path, 0
        self.around: list[str] = []
        self.open: list[Element] = []
        self.pieces: list[list[str]] = []
        self.sizes: list[int] = []
        self.inside = 0
        self.ready: list[tuple[str, Element]] = []
        self.parser = expat.ParserCreate(namespace_separator=" ")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype

    def read(self) -> Iterator[tuple[str, Element]]:
        with readable(self.path, Code.MSR_FILE, hint=HINT), self.path.open("rb") as file:
            head = file.read(CHUNK)
            decoder = self.decoder(encoding_of(head))
            fed, chunk = 0, head
            while chunk:
                fed += self.feed(decoder, chunk)
                if fed - self.parser.CurrentByteIndex > MAX_MARKUP:
                    raise self.too_large(f"one tag or comment has more than {MAX_MARKUP} bytes")
                yield from self.take()
                chunk = file.read(CHUNK)
            self.feed(decoder, b"", final=True)
            yield from self.take()

    def take(self) -> list[tuple[str, Element]]:
        ready, self.ready = self.ready, []
        return ready

    def decoder(self, encoding: str) -> codecs.IncrementalDecoder:
        try:
            return codecs.getincrementaldecoder(encoding)()
        except LookupError as error:
            raise self.wrong(f"the encoding {encoding!r} that it declares is not known") from error

    def feed(self, decoder: codecs.IncrementalDecoder, chunk: bytes, *, final: bool = False) -> int:
        try:
            text = decoder.decode(chunk, final)
            self.parser.Parse(text, final)
        except UnicodeDecodeError as error:
            raise self.wrong(
                f"bytes {error.object[error.start : error.end].hex(' ')} are no {error.encoding}"
            ) from error
        except expat.ExpatError as error:
            raise self.wrong(f"it is no whole XML: {expat.ErrorString(error.code)}", error.offset + 1) from error
        except UnicodeEncodeError as error:
            raise self.wrong("it holds half of a character") from error
        return len(text)

    def wrong(self, what: str, column: int | None = None) -> TrueloopError:
        place = Place(str(self.path), self.parser.CurrentLineNumber, column)
        return Code.MSR_FILE.refusal(f"{self.path.name!r} cannot be read: {what}", hint=HINT, place=place)

    def too_large(self, what: str) -> TrueloopError:
        place = Place(str(self.path), self.parser.CurrentLineNumber)
        hint = "split the file: the results of fewer parts in each"
        return Code.MSR_SIZE.refusal(f"{self.path.name!r} is not read: {what}", hint=hint, place=place)

    def doctype(self, *_: object) -> None:
        raise self.wrong("it has a DOCTYPE, whose entities may expand to any size; QIF needs none")

    def start(self, name: str, attributes: dict[str, str]) -> None:
        name = name.rpartition(" ")[2]
        self.around.append(name)
        if len(self.around) > MAX_DEPTH:
            raise self.too_large(f"its elements are nested more than {MAX_DEPTH} deep")
        if not self.open and name not in ALWAYS and (len(self.around) < 2 or self.around[-2] not in WITHIN):
            return
        element = Element(name, attributes, self.parser.CurrentLineNumber)
        if name in BEGINNINGS and not self.open:
            self.emit(self.around[-2] if len(self.around) > 1 else "", element)
            return
        if self.open:
            self.open[-1].parts.append(element)
            self.inside += 1
            if self.inside > MAX_PARTS:
                raise self.too_large(f"{self.open[0].name} holds more than {MAX_PARTS} elements")
        self.open.append(element)
        self.pieces.append([])
        self.sizes.append(0)

    def characters(self, text: str) -> None:
        if not self.open:
            return
        self.sizes[-1] += len(text)
        if self.sizes[-1] <= MAX_TEXT:
            self.pieces[-1].append(text)
        else:
            self.open[-1].cut = True
            self.pieces[-1].clear()

    def end(self, _: str) -> None:
        self.around.pop()
        if not self.open:
            return
        element = self.open.pop()
        element.text = "".join(self.pieces.pop()).strip()
        self.sizes.pop()
        if not self.open:
            self.inside = 0
            self.emit(self.around[-1] if self.around else "", element)

    def emit(self, around: str, element: Element) -> None:
        self.count += 1
        if self.count > MAX_RECORDS:
            raise self.too_large(f"it holds more than {MAX_RECORDS} definitions and results")
        self.ready.append((around, element))


KEPT: Final = "trueloop."
"""The beginning of the names of these attributes."""
KINDS: Final = {
    Quantity.DIAMETER: "Diameter",
    Quantity.RADIUS: "Radius",
    Quantity.LENGTH: "Length",
    Quantity.ANGLE: "Angle",
}


def written_kind(reading: Reading) -> str:
    """Returns the kind of characteristic a reading is written as; the definition states that of others in words."""
    if reading.quantity is Quantity.POSITION and reading.axis:
        return "LinearCoordinate"
    return KINDS.get(reading.quantity, "UserDefinedLinear")


def kept_of(reading: Reading) -> dict[str, str]:
    """Names of features, place and axis by what they are called."""
    axis = reading.axis if written_kind(reading) != "LinearCoordinate" else ""
    place = " ".join(map(repr, reading.place_mm))
    kept = {"feature": reading.feature, "other": reading.other, "axis": axis, "place": place}
    return {name: value for name, value in kept.items() if value}


def kept_in(item: Element) -> Mapping[str, str]:
    """Returns the attributes kept in an item that was read."""
    every = (one.attributes for one in item.every("AttributeStr"))
    return {
        one["name"].removeprefix(KEPT): one.get("value", "") for one in every if one.get("name", "").startswith(KEPT)
    }


def place_in(text: str) -> tuple[float, ...]:
    """Returns a place from its text; empty for none."""
    words = text.split()
    return tuple(map(float, words)) if all(NUMBER.fullmatch(word) and "," not in word for word in words) else ()
