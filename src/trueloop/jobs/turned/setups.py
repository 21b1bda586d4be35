"""A part's job with several set-ups, read: every program with the frame, the tools and what was measured of its own."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trueloop.domain.characteristic import Characteristic
from trueloop.formats.jobs.curve_of_job import fit_notes
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.jobs.turned.inspection import read_part_errors
from trueloop.jobs.turned.job import Measured, ReadFiles, decided_of, inputs_of, read_measured
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.in_setup import characteristics_in, ends_in, vectors_in
from trueloop.loops.turned.setup_corrections import CutsOfSetup
from trueloop.loops.turned.setups import InSetups, OfSetup, Setup, in_setups
from trueloop.turned.readings.shared import own_seen, shared_words
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import all_of, wording


@dataclass(frozen=True)
class ReadSetups:
    """A part with its set-ups: `profile` in the part's frame, and what each set-up cuts of it."""

    profile: Profile
    found: InSetups
    files: tuple[JobFiles, ...]
    """The job by set-up, as if that were its only one."""


def read_setups(files: JobFiles) -> ReadSetups:
    """Every set-up of a job with what it cuts: its touches need not exist yet.

    Raises JOB, GEO, NC and SET errors, but not those of single features.
    """
    frames = files.frames
    of_setups = tuple(files.with_setup(table) for table in files.job.setups)
    for one in of_setups:
        one.require_uncorrected()
    profile = files.profile()
    decided_of(files, profile)
    setups = [
        Setup(frame, one.finish_program(), one.run, one.edges, decided_of(one, profile))
        for frame, one in zip(frames, of_setups, strict=True)
    ]
    given = files.job.feature
    decided = {
        name: None if cut.left_alone else cut.setup for name, cut in given.items() if cut.setup or cut.left_alone
    }
    return ReadSetups(profile, in_setups(profile, setups, decided), of_setups)


@dataclass(frozen=True)
class ReadCuts:
    """The same with what was measured of each set-up; `notes` on what is of none alone."""

    read: ReadSetups
    measured: Measured
    cuts: tuple[CutsOfSetup, ...]
    notes: tuple[str, ...]


def read_cuts_of_setups(files: JobFiles) -> ReadCuts:
    """A job with several set-ups, whole. Raises what reading raises, also where the set-up of a feature is in doubt."""
    read = read_setups(files)
    read.found.require_plain()
    measured = read_measured(files, read.profile)
    after = files.job.gauging.finish_touches
    finish = None if after is None else read_part_errors(files.sources.file(after), files.job, read.profile)
    pairs = list(zip(read.found.setups, read.files, strict=True))
    cuts = [_cuts(of, one, read.profile, measured, finish) for of, one in pairs]
    notes = (*fit_notes(files.job.part, read.profile), *measured.notes, *_of_none(measured, read))
    return ReadCuts(read, measured, tuple(cuts), notes)


def _cuts(
    of: OfSetup, files: JobFiles, profile: Profile, measured: Measured, finish: ErrorVectors | None
) -> CutsOfSetup:
    frame, program = of.setup.frame, of.setup.program
    vectors = vectors_in(frame, _of_features(measured.vectors, profile, {*of.features}), profile)
    asked = [one for one in measured.characteristics if _features_of(one) <= {*of.features}]
    own = replace(measured, vectors=vectors, characteristics=characteristics_in(frame, asked))
    after = None if finish is None else vectors_in(frame, _of_features(finish, profile, {*of.features}), profile)
    read = ReadFiles(program, of.profile, own, after, None, None, files)
    tables = {tool.called: tool for tool in files.job.tools}
    cuts = tuple((edge, _inputs(files.with_tool(tables[edge.edge.called]), read, frame)) for edge in of.contours)
    return CutsOfSetup(of, cuts, f"corrected-{frame.name}{Path(program.file_name).suffix}")


def _inputs(files: JobFiles, read: ReadFiles, frame: SetupFrame) -> Inputs:
    inputs = inputs_of(files, read)
    where = wording(
        "Set-up {name}: positions are those of its program, {formula} of the part.",
        name=frame.name,
        formula=frame.words,
    )
    options = replace(inputs.options, prescribed=ends_in(frame, inputs.options.prescribed))
    return replace(inputs, setup=frame, options=options, notes=(where,))


def _of_features(vectors: ErrorVectors, profile: Profile, features: set[str]) -> ErrorVectors:
    """Those on some features, and what readings state of these alone."""
    rows = np.flatnonzero([profile.names[index] in features for index in vectors.feature_index.tolist()])
    own = [index for index, name in enumerate(profile.names) if name in features]
    return replace(vectors.chosen(rows), seen=own_seen(vectors.seen, own))


def _features_of(asked: Characteristic) -> set[str]:
    return {asked.feature, asked.other} - {""}


def _of_none(measured: Measured, read: ReadSetups) -> list[str]:
    """Where z counts from, readings that are of no set-up alone, touches of what none cuts, in words.

    The part of the next cut stands on a face that another set-up cuts, which a correction of its own error moves.
    """
    owns = [set(one.features) for one in read.found.setups]
    touched = {read.profile.names[index] for index in measured.vectors.feature_index.tolist()}
    unused = [name for name in read.found.uncut if name in touched]
    found: list[str] = []
    if len(owns) > 1 and not measured.vectors.at_reference.any():
        found.append(
            wording(
                "z counts from no face (`gauging.z_reference`): where a correction moves the face by which the part is "
                "set up again, all that is cut there moves with it."
            )
        )
    names = read.profile.names
    indices = [[index for index, name in enumerate(names) if name in own] for own in owns]
    found.extend(shared_words(measured.vectors.seen, indices, names))
    if unused:
        found.append(wording("{features}: touched, which corrects nothing.", features=all_of(unused)))
    return found
