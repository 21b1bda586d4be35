"""Moves of a program that turns rotary axes while it cuts: where X, Y, Z, A, B, C go to, and in which coordinates.

Under tool point control (Fanuc's G43.4, Haas' G234, TRAORI, M128, FUNCTION TCPM, LinuxCNC's M428) X, Y, Z are places
of the tip in the work; without it they are places of the machine's own axes.
"""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.nc.program.along import said_ends
from trueloop.nc.program.called import EDGES
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState, Motion, ToolPath
from trueloop.nc.program.understood import require_plain_frame, require_seen, require_sound
from trueloop.nc.program.unit import unit_of_path

LETTERS: Final = "XYZABC"
LINEAR: Final = LETTERS[:3]
ROTARY: Final = LETTERS[3:]


@dataclass(frozen=True)
class _Switch:
    """The words that switch tool point control on and off, and those under which words turn the tool otherwise."""

    on: str
    off: str
    otherwise: str = r"(?!)"
    stated: bool = True

    def named(self, word: Word) -> bool:
        """Returns whether a word is one of the switch, or one under which words turn the tool otherwise."""
        text = word.text.strip().upper()
        return any(re.fullmatch(pattern, text) for pattern in (self.on, self.off, self.otherwise))


_SWITCHES: Final = {
    "fanuc-mill": _Switch(r"G0*43\.4", r"G0*49", r"G0*43\.5"),
    "haas-mill": _Switch(r"G0*234", r"G0*49"),
    "siemens": _Switch(
        r"TRAORI(\(1?\))?", r"TRAFOOF(\(\))?", r"[ABC][23]\s*=.*|LEAD|TILT|ORI(MKS|VIRT\d|EULER|RPY2?|CON\w+)"
    ),
    "heidenhain": _Switch(r"M128|FUNCTION TCPM\b(?!.*(SPAT|CENTER)).*", r"M129|FUNCTION RESET TCPM", "FUNCTION TCPM.*"),
    "linuxcnc": _Switch("M428", "M429", "M430", stated=False),
}
"""By control. `stated` False: the program does not tell which is in force at its start."""

_TO_MACHINE: Final = re.compile(r"G(28|30|53|153)|SUPA|M9[12]", re.IGNORECASE)
_REFERENCE: Final = re.compile("G28", re.IGNORECASE)
_MOTION: Final = re.compile(r"G0*([0-3])", re.IGNORECASE)
_HARMLESS: Final = frozenset("GXYZABCFNS")
"""Words with which a block may be made several: what else it does might have to come before or after all of them."""


@dataclass
class PoseMove:
    """A block that moves an axis. `end`: X, Y, Z, mm, A, B, C, degrees, NaN where not known; `words` are its words by
    letter. `follows`: it goes on from the end of the move before, in the same coordinates; `came`: axes that were at a
    place of the machine since, whether at their reference points. `tool`: T, −1 before the first; `offset`: the number
    of the tool offset in force, 0 for none. `divisible`: the block does nothing but move. `feed_mode`
    is 93 for inverse time, and `feed` 1/min then.
    """

    block: Block
    end: tuple[float, ...]
    words: Mapping[str, Word]
    rapid: bool
    tool_point: bool
    follows: bool
    came: Mapping[str, bool]
    work_offset: int
    register_mm: tuple[float, float, float]
    tool: int
    offset: int
    state: CoordinateState
    feed_mode: int
    feed: float
    divisible: bool

    @property
    def linear_known(self) -> bool:
        """Returns whether X, Y and Z are known."""
        return not any(np.isnan(self.end[:3]))

    @property
    def feed_word(self) -> Word | None:
        """Returns the F word of the block."""
        return next((word for word in self.block.words if word.letter == "F"), None)


def may_turn_in_cut(program: Program, heads: Collection[str] = ()) -> bool:
    """Returns whether the text switches tool point control, names another angle of a rotary axis at feed, or one away
    from 0 of an axis that carries the tool (`heads`).
    """
    switch, stated, rapid = _switch_of(program), dict[str, float | str](), True
    for block in program.blocks:
        rapid = _is_rapid(program, block, rapid)
        if any(switch.named(word) for word in block.words):
            return True
        for word in block.words:
            if word.letter in set(ROTARY) and word.kind in ("number", "expression"):
                if word.letter in heads and word.value != 0.0:
                    return True
                angle = word.value if word.kind == "number" else word.text
                if not rapid and stated.get(word.letter) != angle:
                    return True
                stated[word.letter] = angle
    return False


def _switch_of(program: Program) -> _Switch:
    return _SWITCHES.get(program.dialect.name) or _SWITCHES.get(program.dialect.like) or _Switch("(?!)", "(?!)")


def _is_rapid(program: Program, block: Block, rapid: bool) -> bool:
    """Returns whether a block moves at rapid, after one that does or does not."""
    if program.dialect.klartext:
        return any(word.text.upper() == "FMAX" for word in block.words)
    codes = [found[1] for word in block.words if (found := _MOTION.fullmatch(word.text.strip()))]
    return codes[-1] == "0" if codes else rapid


@dataclass(frozen=True)
class FiveAxisPath:
    """The moves of a program. `unit`: that of its first length and what states it; `not_run`: lines with places that
    were not run. `parameters`, `skipped_blocks`, `stands_deg` and `tool_point` are those of `five_axis_path`.
    """

    program: Program
    moves: tuple[PoseMove, ...]
    unit: dict[str, str]
    not_run: tuple[int, ...]
    parameters: Mapping[str, float]
    skipped_blocks: bool
    stands_deg: Mapping[str, float]
    tool_point: bool | None

    def read_again(self, source: bytes) -> "FiveAxisPath":
        """Returns the moves of another text of the program."""
        return five_axis_path(
            self.program.rewritten(source),
            self.parameters,
            self.stands_deg,
            skipped_blocks=self.skipped_blocks,
            tool_point=self.tool_point,
        )

    def turns_in_cut(self, heads: Collection[str] = ()) -> bool:
        """Returns whether a rotary axis turns at feed, the tool point is controlled in a move, or one of the axes that
        carry the tool (`heads`) is away from 0 in a cut.
        """
        last: tuple[float, ...] = (np.nan,) * 3
        for move in self.moves:
            turns = not set(ROTARY).isdisjoint(move.words) and move.end[3:] != last
            leans = any(move.end[LETTERS.index(head)] % 360.0 != 0.0 for head in heads)
            if move.tool_point or (not move.rapid and (turns or leans)):
                return True
            last = move.end[3:]
        return False


def five_axis_path(
    program: Program,
    parameters: Mapping[str, float],
    stands_deg: Mapping[str, float],
    *,
    skipped_blocks: bool = False,
    tool_point: bool | None = None,
) -> FiveAxisPath:
    """Returns the moves of a program. `stands_deg`: where each rotary axis of the machine stands until it positions it,
    NaN where that is not known; `tool_point`: whether tool point control is in force at its start, None where nobody
    states it.

    Raises what running it strictly does, NC-OPAQUE for what is not followed, NC-MAP for moves other than straight ones
    to positions, MCH-FRAME for LinuxCNC where it is not stated whether the tool point is controlled.
    """
    path = program.run(parameters, skipped_blocks=skipped_blocks, roughing=False, trace=True)
    require_sound(path)
    moves = tuple(_Reader(program, path, dict(stands_deg), tool_point).moves())
    require_seen(program, path, range(len(path)), LINEAR)
    run = set(path.executed[:, 0].tolist())
    idle = (block for block in program.blocks if block.index not in run)
    not_run = tuple(block.line for block in idle if not set(LETTERS).isdisjoint(word.letter for word in block.words))
    unit = unit_of_path(program.unit, path)
    return FiveAxisPath(
        program=program,
        moves=moves,
        unit=unit,
        not_run=not_run,
        parameters=parameters,
        skipped_blocks=skipped_blocks,
        stands_deg=stands_deg,
        tool_point=tool_point,
    )


@dataclass
class _Reader:
    program: Program
    path: ToolPath
    rotary: dict[str, float]
    tool_point: bool | None
    rapid: bool = True
    lost: set[str] = field(default_factory=lambda: set(LINEAR))
    offset: int = 0
    switched: bool = True
    frame: tuple[tuple[int, float], ...] = ((0, 0.0),) * 3
    came: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(LETTERS, True))

    def __post_init__(self) -> None:
        self.switch = _switch_of(self.program)
        self.at = dict.fromkeys(LINEAR, np.nan)
        words = (word for block in self.program.blocks for word in block.words)
        self.switching = {word.start for word in words if self.switch.named(word)}

    def moves(self) -> Iterator[PoseMove]:
        """Yields the moves, in the order in which they are made."""
        self._require_followed()
        _, said = said_ends(self.program, self.path)
        first, run_before = 0, set[int]()
        for index, after, state in self.path.executed.tolist():
            block, own = self.program.block(index), range(first, after)
            first = after
            self.rapid = _is_rapid(self.program, block, self.rapid)
            self._follow_switch(block)
            named = {word.letter for word in block.words} & set(LETTERS)
            if not named and not own:
                continue
            if index in run_before:
                raise self._refusal(block, "is run several times", "write the turns of the loop, or the calls, out")
            run_before.add(index)
            to_machine = any(_TO_MACHINE.fullmatch(word.text.strip()) for word in block.words)
            if to_machine or not self._is_move(block, named):
                self._leave(named, any(_REFERENCE.fullmatch(word.text.strip()) for word in block.words))
                continue
            yield self._move(block, own, state, said)

    def _require_followed(self) -> None:
        """Raises the first finding of what is not followed, apart from switches of tool point control."""
        for found in sorted((*self.program.findings, *self.path.findings), key=lambda one: one.place.line or 0):
            if found.severity is Severity.WARNING and self._matters(found):
                at = self.program.block((found.place.line or 1) - 1).start + (found.place.column or 1) - 1
                if at not in self.switching:
                    raise found.as_error()

    def _matters(self, found: Finding) -> bool:
        code = found.code is Code.NC_CODE and found.message.startswith(('"G', '"g'))
        return code or found.code in (Code.NC_OPAQUE, Code.NC_WORD, Code.NC_DIAMETER)

    def _follow_switch(self, block: Block) -> None:
        for word in block.words:
            text = word.text.strip().upper()
            on, off = (re.fullmatch(pattern, text) for pattern in (self.switch.on, self.switch.off))
            if not (on or off) and re.fullmatch(self.switch.otherwise, text):
                raise Code.NC_OPAQUE.refusal(
                    f"{text}: directions of the tool by vectors, by angles of the work or from another point are not "
                    "corrected",
                    hint="have the program written with angles of the rotary axes and places of the tip",
                    place=self.program.place(word.start),
                )
            if on or off:
                if bool(on) != self.tool_point:
                    upright = all(angle % 360.0 == 0.0 for angle in self.rotary.values())
                    self.lost |= {"Z"} if upright else set(LINEAR)
                    self.switched = True
                self.tool_point = bool(on)
                self.offset = next((int(w.value) for w in block.words if on and w.letter == "H"), 0)

    def _is_move(self, block: Block, named: set[str]) -> bool:
        """Returns whether words of the block are places to go to, not a time, an offset or a shift."""
        codes = {word.value for word in block.words if word.letter == "G" and word.kind == "number"}
        shifts = any(word.text.upper().startswith(("TRANS", "ATRANS", "CYCL DEF")) for word in block.words)
        return bool(named) and not shifts and not codes & {4.0, 10.0, 52.0, 92.0}

    def _leave(self, named: set[str], reference: bool) -> None:
        """Forgets where axes are that went to a place of the machine, or whose places are called otherwise."""
        for letter in named or {*LINEAR, *self.rotary}:
            self.came[letter] = reference
            if letter in ROTARY:
                self.rotary[letter] = np.inf
            else:
                self.lost.add(letter)
        self.switched = True

    def _move(self, block: Block, own: range, state: int, said: np.ndarray) -> PoseMove:
        if len(own) > 1 or any(self.path.motion[k] not in (Motion.RAPID, Motion.LINE) for k in own):
            raise self._refusal(
                block,
                "is not a straight move: an arc, a cycle or a touch",
                "have it written in lines, or put what turns axes in cuts into a program of its own",
            )
        if self.tool_point is None:
            if not self.switch.stated:
                raise Code.MCH_FRAME.refusal(
                    "rotary axes turn in this program, and it does not tell whether its X, Y, Z are places of the tip "
                    "or of the joints",
                    hint="--tool-point where the kinematics of the INI (trt, 5axiskins, maxkins) is in force, "
                    "--no-tool-point for identity kinematics; or M428 or M429 before the first move",
                    place=self.program.place(block.start),
                )
            self.tool_point = False
        words: dict[str, Word] = {}
        column = {name: values[state] for name, values in self.path.states.items()}
        frame = tuple(zip(column["renamed"].tolist(), column["register_mm"].tolist(), strict=True))
        moved = {letter for letter, old, new in zip(LINEAR, self.frame, frame, strict=True) if old != new}
        self.lost, self.frame, self.switched = self.lost | moved, frame, self.switched or bool(moved)
        for word in block.words:
            if word.letter in set(ROTARY):
                if word.letter not in self.rotary:
                    raise self._refusal(block, f"turns {word.letter}, which the machine has not", "take the word out")
                if column["incremental"] if word.increment is None else word.increment:
                    raise self._refusal(block, f"turns {word.letter} by {word.text}", "turn it to a number, by G90")
                words[word.letter] = word
                self.rotary[word.letter] = float(column["rotary_deg"][ROTARY.index(word.letter)])
        for k in own:
            require_plain_frame(self.path, [k])
            if self.path.compensation[k] != 40:
                raise self._refusal(block, "is under cutter compensation", "have the tool's centre written (G40, R0)")
            for axis, letter in enumerate(LINEAR):
                index = int(self.path.word[k, axis])
                if index >= 0 and self.program.word(index).block == block.index:
                    words[letter] = self.program.word(index)
                    if column["incremental"] if words[letter].increment is None else words[letter].increment:
                        raise self._refusal(block, f"goes by an increment, {words[letter].text}", "write it in G90")
                    self.lost.discard(letter)
                self.at[letter] = float(self.path.end_mm[k, axis]) if said[k, axis] else np.nan
        end = tuple(np.nan if letter in self.lost else self.at[letter] for letter in LINEAR)
        move = PoseMove(
            block=block,
            end=(*end, *(self.rotary.get(letter, np.nan) for letter in ROTARY)),
            words=words,
            rapid=self.rapid if not own else bool(self.path.rapid[own[0]]),
            tool_point=self.tool_point,
            follows=not self.switched,
            came=self.came,
            work_offset=int(column["work_offset"]),
            register_mm=tuple(column["register_mm"].tolist()),
            tool=int(column["tool"]),
            offset=self._offset(int(column["tool_offset"]), int(column["tool"])),
            state=CoordinateState(inch=bool(column["inch"]), diameter=bool(column["diameter"])),
            feed_mode=int(column["feed_mode"]),
            feed=float(column["feed"]),
            divisible=all(word.letter in _HARMLESS or self._goes(word) for word in block.data),
        )
        self.switched, self.came = False, {}
        return move

    def _goes(self, word: Word) -> bool:
        return word.text.upper() in ("L", "R0", "RL", "RR", "FMAX")

    def _offset(self, called: int, tool: int) -> int:
        """Returns the number of the tool offset in force: that of the switch, else that which the program calls."""
        if self.tool_point and self.offset:
            return self.offset
        number = called // EDGES if self.program.dialect.edge_by_d else called
        return number if number > 0 or not self.tool_point else tool

    def _refusal(self, block: Block, why: str, hint: str) -> TrueloopError:
        return Code.NC_MAP.refusal(
            f"line {block.line} {why}: in a program that turns rotary axes in cuts it is not corrected",
            hint=hint,
            place=self.program.place(block.start),
        )
