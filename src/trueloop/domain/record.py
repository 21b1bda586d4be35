"""The correction record: what was corrected, from what, by which model, within which limits, and what was changed.

A corrected program carries the record's id and its source's hash in a comment; correcting it again is refused, and so
is correcting a program that is not the one the touches came from.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import KW_ONLY, asdict, dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Final, Generic, Literal, TypeVar

from trueloop._core import nc_mentions
from trueloop.arrays import by_content
from trueloop.domain.characteristic import Characteristic, Judged
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Ran
from trueloop.domain.part import PartType
from trueloop.domain.proposal import ToolOffset
from trueloop.domain.tool import Edge, Machine, Tool
from trueloop.errors import Code, Place
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

XZ = tuple[float, float]


@dataclass(frozen=True)
class CutWith:
    """How a part was cut, as stated in the job or the store; a known input of every estimate of its errors.

    `ran` is the program, or that an offset was entered; `correction` the id of the record, "" where none was in force;
    `program_sha256` the hash of the text that ran, "" where it is not known. `offset_mm` is how far the tool stood off
    the path of that program by offsets (x as a radius, z); `wear_mm` the part of it in the control's wear table: it is
    in force for the next cut too, which a program's own offset is not.
    """

    ran: Ran = Ran.AS_PROGRAMMED
    correction: str = ""
    program_sha256: str = ""
    offset_mm: XZ = (0.0, 0.0)
    wear_mm: XZ = (0.0, 0.0)

    @property
    def corrected(self) -> bool:
        """Returns whether a correction was in force."""
        return bool(self.correction)

    @property
    def words(self) -> str:
        """Returns words such as `correction 319bcb4f5bd4419b (corrected program)`."""
        if not self.corrected:
            return wording("the given program, no correction in force")
        how = {
            Ran.CORRECTED: wording("corrected program"),
            Ran.OFFSETS: wording("program with tool offsets"),
            Ran.WEAR: wording("offset entered at the control"),
            Ran.AS_PROGRAMMED: wording("given program"),
        }[self.ran]
        return wording("correction {id} ({how})", id=self.correction, how=how)

    def still_to_do(self, total_mm: XZ) -> XZ:
        """Returns what of a whole offset is not in the control's wear table yet, mm."""
        return total_mm[0] - self.wear_mm[0], total_mm[1] - self.wear_mm[1]


GIVEN: Final = CutWith()
"""The given program without a correction."""


@dataclass(frozen=True)
class Program:
    """One text of a program: its file's `name`, `dialect`, hash, and the unit in force at its first length.

    `unit` is None where the program has no length. The text itself is `trueloop.nc.program.program.Program`.
    """

    name: str
    dialect: str
    sha256: str
    unit: Literal["mm", "inch"] | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the hash alone: a program edited in one character is another one."""
        return (self.sha256,)


@dataclass(frozen=True)
class ProgramText:
    """The text of a program, byte for byte, by its hash."""

    sha256: str
    content: bytes
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the program."""
        return (self.sha256,)


MARK: Final = "trueloop corrected"
"""How a corrected program says so, in a comment of its dialect."""
MARKED: Final = re.compile(rb"\s+".join(MARK.encode().split()), re.IGNORECASE)
"""The mark as controls and editors give it back: many store capitals only, some change the blanks."""


class Product(StrEnum):
    """The product that a correction is of."""

    TURNED = "turned"  # the contour of a turned part, by its touches
    SURFACE = "surface"  # a free-form surface, by measured parts
    MACHINE = "machine"  # a program, by a machine model or another field of displacements
    POINTS = "points"  # a drilling program, by errors in the plane


@dataclass(frozen=True)
class ChangedWord:
    """One change to a program: the place in the source and the text before and after (several lines for an arc)."""

    line: int
    column: int
    before: str
    after: str


@dataclass(frozen=True)
class Component:
    """Components of a correction at one touch, along its normal, µm: of the machine, of the process, and both."""

    feature: str
    point: str
    comp_mtg_um: float
    comp_proc_um: float
    composed_um: float

    @classmethod
    def of(cls, feature: str, point: str, comp_mtg_mm: float, comp_proc_mm: float) -> "Component":
        """Makes a component from lengths in mm, rounded to a nanometre."""
        mtg, proc = (round(value * UM_PER_MM, 3) + 0.0 for value in (comp_mtg_mm, comp_proc_mm))
        return cls(feature, point, mtg, proc, round(mtg + proc, 3) + 0.0)


@dataclass(frozen=True)
class Record:
    """One correction, complete enough to be repeated and to be judged later.

    `id` stands in the corrected program. `product`: what was corrected and by what. `inputs_sha256` by file name.
    `options` and `model` hold what JSON can; a number that is not finite is None there. `decision`: in words.
    `changes` are listed where the whole program was in memory, `edits` counts them in every case. `components`: of a
    correction of machine and process together. `inspections` are those it was made from; `edge` is the tool's
    that cuts, mounted and measured at `edge_set_at`. `tool_offset` is the change of the tool's offset that is the
    correction, or could take its place; it is the change against `cut_with`, what cut the part that was measured.
    `characteristics` are those that the drawing asks for, judged; `between` the lengths of the drawing from a face that
    this edge cuts to one that another edge cuts, by the part's names. None and empty: not stated.
    """

    id: str
    made_at: str
    made_by: str
    trueloop_version: str
    inputs_sha256: dict[str, str]
    options: dict[str, object]
    model: dict[str, object]
    decision: list[str]
    changes: list[ChangedWord]
    components: list[Component] = field(default_factory=list)
    _: KW_ONLY
    schema: Literal[1] = 1
    product: Product
    edits: int | None = None
    part_type: PartType | None = None
    machine: Machine | None = None
    tool: Tool | None = None
    edge: Edge | None = None
    edge_set_at: datetime | None = None
    program: Program | None = None
    inspections: tuple[Inspection, ...] = ()
    tool_offset: ToolOffset | None = None
    cut_with: CutWith | None = None
    characteristics: tuple[Judged, ...] = ()
    between: tuple[Characteristic, ...] = ()

    def __post_init__(self) -> None:
        for name in ("options", "model"):
            object.__setattr__(self, name, _plain(getattr(self, name)))

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the id: of inputs and options."""
        return (self.id,)

    def to_json(self) -> str:
        """Writes the record as JSON, keys in order of declaration, with the hash of its content last."""
        plain = json.dumps(asdict(self), ensure_ascii=False, allow_nan=False, default=datetime.isoformat)
        content = json.loads(plain)
        return json.dumps(content | {CONTENT: content_sha256(content)}, indent=2, ensure_ascii=False) + "\n"


CONTENT: Final = "content_sha256"
"""Key of the hash of all other keys of a record's file."""


def content_sha256(content: Mapping[str, object]) -> str:
    """Returns the hash of a record's keys and values, as JSON has them, however they are laid out."""
    stated = {key: value for key, value in content.items() if key != CONTENT}
    return sha256_of(json.dumps(stated, sort_keys=True, ensure_ascii=False).encode())


def _plain(value: object) -> object:
    """As JSON gives it back: lists for tuples, None for anything that is not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def sha256_of(content: bytes) -> str:
    """Returns the hex digest by which inputs are known."""
    return hashlib.sha256(content).hexdigest()


def record_id(inputs_sha256: dict[str, str], options: dict[str, object]) -> str:
    """Returns sixteen hex digits from inputs and options alone: the same job gives the same id on any day."""
    return sha256_of(json.dumps([inputs_sha256, options], sort_keys=True).encode())[:16]


def marks_of_record(record: str, source: bytes) -> list[str]:
    """Returns the comments by which a program names the correction it carries, and the program it was made from."""
    return [f"{MARK}: record {record}", f"source sha256 {sha256_of(source)}"]


def mark_of_field(record: str, source_sha256: str) -> str:
    """Returns the comment by which a program states that a field of errors was taken out, of no touches of its own."""
    return f"{MARK} {record} by a field, source {source_sha256[:16]}"


def check_uncorrected(source: bytes, what: str = "program") -> None:
    """Refuses a program, or another file, that a correction was already written into."""
    # A search by pattern that does not mind the case is slow: half a second in a program of 80 MB.
    found = MARKED.search(source) if nc_mentions(source, MARK.split()[0].encode()) else None
    if found is not None:
        position = found.start()
        line = source.count(b"\n", 0, position) + 1
        comment = source[position:].split(b"\n", 1)[0].decode("latin-1").strip()
        raise Code.CMP_TWICE.refusal(
            wording("this {what} is corrected already: {comment!r}", what=what, comment=comment),
            hint=f"correct the {what} that it was made from; its hash stands in the record of that id",
            place=Place(line=line),
            values={"comment": comment},
        )


def check_same_program(source: bytes, expected_sha256: str) -> None:
    """Refuses touches that were taken after another program than the one to be corrected."""
    found = sha256_of(source)
    if found != expected_sha256.lower():
        raise Code.CMP_OTHER_PROGRAM.refusal(
            f"the touches belong to the program with sha256 {expected_sha256[:16]}…, this one has {found[:16]}…",
            hint="name the program that was run before probing, or probe again",
            override="leave out gauging.program_sha256 in the job",
            values={"expected_sha256": expected_sha256, "found_sha256": found},
        )


Payload = TypeVar("Payload")


@by_content
@dataclass(frozen=True)
class Correction(Generic[Payload]):
    """A correction as it is stored, sent and judged later.

    `record` says of every product alike what was corrected, from what, and why; `limits` are those it was held against,
    by name with the unit in the name; `payload` is what the product's loop gave.
    """

    record: Record
    limits: Mapping[str, float]
    payload: Payload
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of its record."""
        return self.record.identity

    @property
    def source_sha256(self) -> str:
        """Returns the hash of the program that it corrects; "" where it corrects none."""
        return "" if self.record.program is None else self.record.program.sha256
