"""A model of a machine refined from what it left on the parts of a store, offered as a version."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.diagnose.both import given_model
from trueloop.jobs.diagnose.shaped import machine_of, machine_shape
from trueloop.jobs.machine.machine_model import offer_model
from trueloop.loops.diagnosis.left_on_parts import MachineDiagnosis
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.model import MachineModel
from trueloop.machine.refine.guilty import Guilty
from trueloop.machine.refine.left import LeftOnParts
from trueloop.machine.refine.refine import refine, require_better
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape, refinement_shape
from trueloop.report.diagnosis.page_machine import machine_page
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store

AUTO: Final = "auto"
OFFERED: Final = "offered.json"


@dataclass(frozen=True)
class Refining:
    """Terms to refine: the errors by name, or those that the diagnosis finds; by parts of which types.

    `element` names the signal of each axis' element; `share` is the part of the change that is made [4773 §2.5].
    """

    errors: tuple[str, ...]
    part_types: tuple[str, ...] = ()
    element: tuple[tuple[str, str], ...] = ()
    share: float = 1.0


@dataclass(frozen=True)
class RefinedModel:
    """The result: the diagnosis with the refinement, and the files."""

    shape: MachineDiagnosisShape
    files: tuple[str, ...]
    kept: str


def refined(
    store: Store, model: Path, asked: Refining, out: Path, texts: Texts, accept: Collection[str] = ()
) -> RefinedModel:
    """Writes the offered model and the page, and keeps the version.

    Raises DIA-FEW, DIA-NONE and what the diagnosis is refused with; DIA-WORSE for a model that is no better on parts
    left out, unless it is accepted; MCH-AXIS for an error that the machine does not have.
    """
    given = given_model(model)
    done, findings = machine_of(store, given, asked.part_types, dict(asked.element), accept)
    guilty = guilty_of(given.model, asked.errors, done)
    found = refine(given.model, left_on_parts(done), guilty, share=asked.share)
    accepted = [code for code in Code if code in accept]
    require_better(found, accepted)
    offered, kept = offer_model(model, found, out / OFFERED, db=store.where, accept=accepted)
    version = read_model(offered, offered=True).version
    assert version is not None  # it was offered as one
    shape = machine_shape(given, done, findings, refinement=refinement_shape(found, version))
    page = [
        ("refinement.json", (shape.model_dump_json(indent=1) + "\n").encode()),
        ("refinement.html", machine_page(shape, texts).encode()),
    ]
    files = [str(offered), *(str(file) for file in write_all(out, page, inputs=(model, offered)))]
    return RefinedModel(shape, tuple(files), "" if kept is None else kept.words)


def guilty_of(model: MachineModel, errors: Sequence[str], done: MachineDiagnosis) -> list[Guilty]:
    """Returns the errors named, each with the signal that it follows in the diagnosis; `auto`: all of every set found.

    A set that the data cannot divide is refined as a whole: what its members share is corrected wherever it lies.
    """
    follows = {
        str(suspect.error): suspect.follows
        for one in done.verdict.sets
        for suspect in one.suspects
        if suspect.follows in done.seen.state.signals
    }
    if tuple(errors) != (AUTO,):
        return [Guilty(_possible(model, name), follows.get(name, "")) for name in errors]
    found = [error for one in done.verdict.sets for error in one.axis_errors]
    if not found:
        raise Code.DIA_NONE.refusal(
            f"nothing is found wrong with the model: that it is sound has the probability {done.verdict.sound:.3f}",
            hint="name the errors to refine all the same: `--errors EXX,EBZ`",
        )
    return [Guilty(error, follows.get(str(error), "")) for error in found]


def left_on_parts(done: MachineDiagnosis) -> LeftOnParts:
    """Converts a diagnosis to the input of the refinement."""
    types = sorted({part.part_type for part in done.parts})
    kinds = np.array([types.index(part.part_type) for part in done.parts])
    seen, noise = done.seen, done.verdict.noise_mm
    return LeftOnParts(seen.part, kinds[seen.part], seen.normal, seen.state, seen.residual_mm, max(noise, 1e-5))


def _possible(model: MachineModel, name: str) -> ErrorName:
    """An error of this machine. Raises MCH-AXIS with those that there are."""
    known = {str(error): error for error in model.machine.chain.errors()}
    if name in known:
        return known[name]
    raise Code.MCH_AXIS.refusal(
        f"the machine cannot have {name!r}; it has {len(known)} errors: {' '.join(known)}",
        hint="name one of them, or `--errors auto` for those that the diagnosis finds",
    )
