"""A program file of any size to a displaced one: read and written as it comes, with a record beside it."""

import math
from collections.abc import Callable, Collection, Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from trueloop.domain.option import USUAL, Limits, MapOptions
from trueloop.domain.record import Record, check_uncorrected, sha256_of
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.formats.called_files import LARGEST_CALLER, WithCalled, of_folder
from trueloop.formats.input_file import FilePath, readable, require_text
from trueloop.formats.outputs import Output, write_all, written_as_it_comes
from trueloop.formats.record_file import record_beside
from trueloop.jobs.user import user_name
from trueloop.loops.machine.five_axis import PoseCorrection, correct_five_axis
from trueloop.loops.machine.mapped_program import Mapped, mapped_pieces, marked, obstacles, survey_of
from trueloop.loops.machine.program import (
    CorrectedPoints,
    correct_points,
    field_of_model,
    model_in_force,
    record_of,
    record_of_field,
    record_of_points,
)
from trueloop.machine.correct import Setup
from trueloop.machine.model.model import MachineModel
from trueloop.machine.standards import PlanarField
from trueloop.nc.field import Field
from trueloop.nc.five_axis import ROTARY, FiveAxisPath, five_axis_path, may_turn_in_cut
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, read_program


def write_corrected_points(
    program: Program,
    target: Path,
    field: PlanarField,
    provenance: dict[str, object],
    *,
    all_words: bool = False,
    limit_mm: float = Limits.correction_mm,
    inputs: Collection[Path] = (),
) -> CorrectedPoints:
    """Writes what `correct_points` makes, with its record; `inputs`: program and field. Raises OUT errors."""
    written, done, changed = correct_points(program, field, provenance, all_words=all_words, limit_mm=limit_mm)
    options = {"all_words": all_words, "limit_mm": limit_mm}
    hashes = {file.name: sha256_of(file.read_bytes()) for file in inputs if str(file) != program.file}
    made = record_of_points(program, done, changed, options, provenance, hashes, datetime.now(UTC))
    files = [(target.name, written), record_beside(target, replace(made, made_by=user_name()))]
    write_all(target.parent, files, inputs=inputs)
    return done


CHUNK: Final = 1 << 17
"""Bytes read at a time, to which the rest of their last line comes."""


def lines_of(path: Path) -> Iterator[bytes]:
    """Yields a file some whole lines at a time. Raises NC-FILE where it cannot be read."""
    with readable(path, Code.NC_FILE, hint="name an NC program"), path.open("rb") as file:
        begun = False
        while lines := file.read(CHUNK) + file.readline():
            if not begun:
                require_text(lines, path, Code.NC_FILE)
            begun = True
            yield lines


def map_program(
    source: Path,
    target: Path,
    field: Field,
    options: MapOptions = USUAL,
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
    inputs: Collection[Path] = (),
    record: Callable[[Mapped], Record] | None = None,
) -> Mapped:
    """Writes `source` to `target` with the field's displacement added to every position, as `mapped_pieces` does.

    `dialect` is guessed from the program's beginning where none is named. `inputs` are further files that must not be
    overwritten; `record` makes the record that is written beside the program, as STEM.record.json. Raises NC-FILE,
    OUT-INPUT, OUT-FOLDER and what `mapped_pieces` does; nothing is written then.
    """
    known = dialect_named(dialect or _dialect_of(source)).name
    whole = _with_called(source, known)
    files = (source, *whole.called, *inputs)
    with in_file(source), whole.placing():
        pieces = mapped_pieces(_pieces_of(whole), known, field, options, parameters or {})
        with written_as_it_comes(target, inputs=files) as out:
            done, called = _write(out, pieces, whole)
            done = replace(done, called=tuple(file.name for file in whole.called))
            beside = [] if record is None else [record_beside(target, record(done))]
            beside += [(file.name, text) for file, text in zip(whole.called, called, strict=True)]
            if beside:
                write_all(target.parent, beside, inputs=files)
    return done


def program_obstacles(
    source: Path,
    field: Field,
    options: MapOptions = USUAL,
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
) -> list[TrueloopError]:
    """Returns all for which `map_program` would refuse a program, by line. Raises NC-FILE, NC-DIALECT: unreadable."""
    try:
        known = dialect_named(dialect or _dialect_of(source)).name
    except TrueloopError as refused:
        if refused.code is not Code.CMP_TWICE:
            raise
        return [refused]
    with in_file(source):
        whole = _with_called(source, known)
        found = obstacles(_pieces_of(whole), known, field, options, parameters or {})
    return [whole.placed(error).in_file(str(source)) for error in found]


def _dialect_of(source: Path) -> str:
    """Guessed from the program's beginning. A program that was corrected before is refused first (CMP-TWICE)."""
    beginning = next(lines_of(source), b"")
    with in_file(source):
        check_uncorrected(beginning)
    return guess_dialect(beginning, str(source))


def _with_called(source: Path, dialect: str) -> WithCalled:
    """The program with those that it calls; of a large one nothing is held."""
    with readable(source, Code.NC_FILE, hint="name an NC program"):
        is_large = source.stat().st_size > LARGEST_CALLER
    return WithCalled(source, b"") if is_large else of_folder(source, dialect)


def _pieces_of(whole: WithCalled) -> Callable[[], Iterator[bytes]]:
    return (lambda: iter([whole.text])) if whole.called else partial(lines_of, whole.file)


def _write(out: Output, pieces: Generator[bytes, None, Mapped], whole: WithCalled) -> tuple[Mapped, list[bytes]]:
    """Writes the program; returns what was done, and the programs that it calls, each with the mark of the first."""
    held: list[bytes] = []
    while True:
        try:
            piece = next(pieces)
        except StopIteration as end:
            done: Mapped = end.value
            break
        if whole.called:
            held.append(piece)
        else:
            out.write(piece)
    program, *called = whole.apart(b"".join(held)) if whole.called else [b""]
    out.write(program)
    return done, [marked(text, done) for text in called]


def displace_program(
    source: FilePath,
    target: FilePath,
    field: Field,
    options: MapOptions = USUAL,
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
    inputs: Collection[Path] = (),
) -> Mapped:
    """`map_program` with a record beside the program; `inputs` are the files that the field was read from.

    >>> shift = trueloop.similarity_field(shift_mm=(0.0, 0.0, -0.02))
    >>> done = trueloop.displace_program(trueloop.example("surface/finish.ngc"), "mapped/finish.ngc", shift)
    >>> done.moves, round(done.largest_mm[2], 6)
    (2928, 0.02)
    >>> sorted(file.name for file in Path("mapped").iterdir())
    ['finish.ngc', 'finish.record.json']
    """
    source, target = Path(source), Path(target)
    hashes = {file.name: sha256_of(file.read_bytes()) for file in inputs}

    def record(done: Mapped) -> Record:
        made = record_of_field(source.name, done, field, hashes, options, parameters or {}, datetime.now(UTC))
        return replace(made, made_by=user_name())

    return map_program(
        source, target, field, options, dialect=dialect, parameters=parameters, inputs=inputs, record=record
    )


@dataclass(frozen=True)
class ModelFile:
    """A machine model with the file it was read from.

    >>> fitted = trueloop.fit_machine(
    ...     trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")]
    ... )
    >>> file, _ = fitted.write("machine")
    >>> len(trueloop.ModelFile(trueloop.read_model(file), file).sha256)
    64
    """

    model: MachineModel
    file: Path

    @property
    def sha256(self) -> str:
        """Returns the hash by which the record knows the file."""
        return sha256_of(self.file.read_bytes())


def compensate_program(
    source: FilePath,
    target: FilePath,
    model: ModelFile,
    setup: Setup,
    options: MapOptions = USUAL,
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
    extrapolate: Collection[str] = (),
    inputs: Collection[Path] = (),
) -> Mapped:
    """Writes `source` to `target` with COMP_MTG of the model, at the set-up's temperatures, in every position.

    A program that turns rotary axes in its cuts, cuts with a turned head or controls the tool point gets the axis of
    the tool corrected as well. The record is written beside it, as STEM.record.json. Raises what placing the program in
    the machine raises (MCH-FRAME, MCH-TRAVEL, MCH-RANGE) and what `map_program` does; nothing is written then.

    >>> fitted = trueloop.fit_machine(
    ...     trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")]
    ... )
    >>> model = trueloop.ModelFile(fitted.found.model, fitted.write("machine")[0])
    >>> setup = trueloop.Setup({1: (250.0, 0.0, -150.0)}, signals={"T1": 25.0})  # the zero of G54
    >>> done = trueloop.compensate_program(trueloop.example("surface/finish.ngc"), "part.ngc", model, setup)
    >>> print(np.round(done.largest_mm, 4))
    [0.0121 0.001  0.0061]
    """
    source, target = Path(source), Path(target)
    sha256 = model.sha256

    def record(done: Mapped) -> Record:
        made = record_of(source.name, done, model.model, sha256, setup, options, parameters or {}, datetime.now(UTC))
        return replace(made, made_by=user_name())

    path = _five_axis_path(source, model.model, setup, options, dialect, parameters or {})
    if path is not None:
        with in_file(source):
            known, identity = model_in_force(model.model, sha256, setup)
            named = {letter for move in path.moves for letter in move.words}
            turning = [name for name in known.machine.chain.order if name in ROTARY and name in named]
            correction = PoseCorrection(known, setup, turning, extrapolate)
            written, done = correct_five_axis(path, correction, identity, options, parameters or {})
        files = [(target.name, written), record_beside(target, record(done))]
        write_all(target.parent, files, inputs=(source, model.file, *inputs))
        return done
    return map_program(
        source,
        target,
        field_of_model(model.model, sha256, setup, extrapolate),
        options,
        dialect=dialect,
        parameters=parameters,
        inputs=(model.file, *inputs),
        record=record,
    )


def _five_axis_path(
    source: Path,
    model: MachineModel,
    setup: Setup,
    options: MapOptions,
    dialect: str | None,
    parameters: Mapping[str, float],
) -> FiveAxisPath | None:
    """Returns the moves of a program that turns rotary axes of the machine in its cuts, cuts with a turned head or
    controls the tool point; None of any other, and of one that calls programs in other files.
    """
    rotary = [name for name in model.machine.chain.order if name in ROTARY]
    known = dialect_named(dialect or _dialect_of(source)).name
    if not rotary or _with_called(source, known).called:
        return None
    with in_file(source):
        if not survey_of(lines_of(source), known).rotary:
            return None
        program = read_program(b"".join(lines_of(source)), known, str(source), options.unit, options.decimals)
        heads = [axis.name for axis in model.machine.chain.tool if axis.name in rotary]
        if not may_turn_in_cut(program, heads):
            return None
        stands = {name: math.degrees(setup.fixed.get(name, math.nan)) for name in rotary}
        path = five_axis_path(
            program, parameters, stands, skipped_blocks=options.skipped_blocks, tool_point=setup.tool_point
        )
    return path if path.turns_in_cut(heads) else None
