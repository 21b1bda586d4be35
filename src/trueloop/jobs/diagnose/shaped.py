"""Diagnoses of machines and fixturings as shapes for JSON and pages.

A model of a machine refined from what it left on the parts of a store, offered as a version.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.diagnosis.features.fixturing import Instability, fixturing
from trueloop.errors import Code, Finding, in_file
from trueloop.formats.measurements.inspections_csv import read_repeats
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.diagnose.records import GivenModel, both_of_machine, given_model, part_named
from trueloop.jobs.diagnose.seen_series import DiagnosisOptions, parts_of, sources_of
from trueloop.jobs.machine.machine_model import offer_model
from trueloop.loops.diagnosis.left_on_parts import MachineDiagnosis, diagnose_machine
from trueloop.loops.diagnosis.part import Repeats, repeats_of, require_stable
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.model import MachineModel
from trueloop.machine.refine.left import Guilty, LeftOnParts
from trueloop.machine.refine.refine import refine, require_better
from trueloop.report.diagnosis.machine_shapes import (
    CorrelationShape,
    MachineDiagnosisShape,
    RefinementShape,
    ResidualShape,
    SuspectShape,
    TermSetShape,
    refinement_shape,
)
from trueloop.report.diagnosis.page_machine import machine_page
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape, FixturingShape, JudgedShape
from trueloop.report.series.values import findings_shape
from trueloop.report.shape import um
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class Repeatability:
    """A reading's expected repeatability and its permitted variation; None: as stated, and no limit."""

    standard_u_mm: float | None = None
    limit_mm: float | None = None


def fixture_of_file(path: Path, repeatability: Repeatability, accept: Collection[str] = ()) -> FixtureDiagnosisShape:
    """Repeats in a file. Raises DIA-FEW, and DIA-UNSTABLE unless it is accepted or only shown."""
    read, u_mm = read_repeats(path, repeatability.standard_u_mm)
    with in_file(path):
        found = [Repeats(name, mm, u_mm, fixturing(mm, u_mm, repeatability.limit_mm)) for name, mm in read.items()]
    return shown(path.stem, found, accept)


def fixture_of_part(
    store: Store, serial: str, options: DiagnosisOptions, repeatability: Repeatability
) -> FixtureDiagnosisShape:
    """Repeats of a part's own points and readings. Raises DIA-NONE and DIA-FEW."""
    shares = part_named(store, serial, options.part_type).shares
    of_shares = [sources_of(store, options, share.part_type.name) for share in shares]
    repeats = [
        one
        for sources in of_shares
        for each in parts_of(sources, (serial,))[0]
        for points in each.points(sources.places).values()
        for one in repeats_of(points, repeatability.standard_u_mm, repeatability.limit_mm)
    ]
    if not repeats:
        raise Code.DIA_FEW.refusal(
            f"no point of part {serial!r} was read 5 times: its fixturing cannot be judged",
            hint="touch one point repeatedly right after fixturing, and keep the readings",
            values={"count": 0, "needed": 5},
        )
    return shown(serial, repeats, options.accept)


def shown(name: str, repeats: Sequence[Repeats], accept: Collection[str]) -> FixtureDiagnosisShape:
    """Shows the fixturings of a machine, the unstable ones as findings, which are refused elsewhere."""
    findings = require_stable([("", repeat) for repeat in repeats], (*accept, Code.DIA_UNSTABLE))
    # Makes the shape of a fixture diagnosis, with each point that was read repeatedly
    return FixtureDiagnosisShape(
        machine=name, fixturings=[_fixturing(repeat) for repeat in repeats], findings=findings_shape(findings)
    )


def limits_of(u_um: float | None, limit_um: float | None) -> Repeatability:
    """Returns limits in mm from micrometres."""
    return Repeatability(*(None if one is None else one / UM_PER_MM for one in (u_um, limit_um)))


def machine_of(
    store: Store, model: GivenModel, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> tuple[MachineDiagnosis, list[Finding]]:
    """Diagnoses the model; returns its verdict, and the findings on the parts."""
    parts, findings = both_of_machine(store, model, part_types, accept)
    return diagnose_machine(model.model, parts, element, accept), findings


def machine(
    store: Store, model: Path, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> MachineDiagnosisShape:
    """Determines which axis errors the model of a machine has wrong."""
    given = given_model(model)
    done, findings = machine_of(store, given, part_types, element, accept)
    return machine_shape(given, done, findings)


def machine_shape(
    model: GivenModel, done: MachineDiagnosis, findings: Iterable[Finding], refinement: RefinementShape | None = None
) -> MachineDiagnosisShape:
    """Makes the shape: errors the model has wrong, what it left at each point, what the source's own way would name."""
    seen, verdict, order = done.seen, done.verdict, model.model.machine.chain.order
    at = np.broadcast_to(seen.state.positions, (len(seen.residual_mm), len(order)))
    return MachineDiagnosisShape(
        machine=model.model.machine.name,
        model=f"{model.path.name} {model.sha256[:12]}",
        parts=len(done.parts),
        points=len(seen.residual_mm),
        sound=verdict.sound,
        sets=[
            TermSetShape.from_values(
                term_set,
                errors=[
                    SuspectShape(error=str(suspect.error), follows=suspect.follows, probability=share)
                    for suspect, share in zip(term_set.suspects, term_set.each, strict=True)
                ],
            )
            for term_set in verdict.sets
        ],
        scatter_um=um(verdict.noise_mm),
        by_error={str(error): share for error, share in verdict.by_error.items()},
        residuals=[
            ResidualShape(
                part=done.parts[int(seen.part[k])].serial,
                position_mm={name: round(float(at[k, j]), 6) for j, name in enumerate(order)},
                residual_um=um(float(seen.residual_mm[k])),
            )
            for k in range(len(seen.residual_mm))
        ],
        temperatures={
            name: np.broadcast_to(np.asarray(values, np.float64), seen.residual_mm.shape).tolist()
            for name, values in seen.state.signals.items()
        },
        frames=None if done.frames is None else done.frames.words,
        own_way=[
            CorrelationShape(error=correlation.error, signal=correlation.signal, correlation=correlation.correlation)
            for correlation in done.own_way
        ],
        refinement=refinement,
        findings=findings_shape([*findings, *done.findings]),
    )


def _fixturing(repeats: Repeats) -> FixturingShape:
    found = repeats.found
    return FixturingShape(
        name=repeats.what,
        values_um=[um(float(value)) for value in repeats.values_mm - repeats.values_mm.mean()],
        standard_u_um=repeats.standard_u_mm * UM_PER_MM,
        limit_um=None if found.limit_mm is None else found.limit_mm * UM_PER_MM,
        spread=JudgedShape.from_values(found.spread),
        drift=JudgedShape.from_values(found.drift),
        step=JudgedShape.from_values(found.step),
        step_after=found.step_at if found.shows is Instability.STEP else None,
        stable=found.stable,
    )


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
    store: Store, model: Path, refining: Refining, out: Path, texts: Texts, accept: Collection[str] = ()
) -> RefinedModel:
    """Writes the offered model and the page, and keeps the version.

    Raises DIA-FEW, DIA-NONE and what the diagnosis is refused with; DIA-WORSE for a model that is no better on parts
    left out, unless it is accepted; MCH-AXIS for an error that the machine does not have.
    """
    given = given_model(model)
    done, findings = machine_of(store, given, refining.part_types, dict(refining.element), accept)
    guilty = guilty_of(given.model, refining.errors, done)
    found = refine(given.model, left_on_parts(done), guilty, share=refining.share)
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
        for term_set in done.verdict.sets
        for suspect in term_set.suspects
        if suspect.follows in done.seen.state.signals
    }
    if tuple(errors) != (AUTO,):
        return [Guilty(_possible(model, name), follows.get(name, "")) for name in errors]
    found = [error for term_set in done.verdict.sets for error in term_set.axis_errors]
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
    return LeftOnParts(
        part=seen.part,
        part_type=kinds[seen.part],
        normal=seen.normal,
        state=seen.state,
        residual_mm=seen.residual_mm,
        u_mm=max(noise, 1e-5),
    )


def _possible(model: MachineModel, name: str) -> ErrorName:
    """An error of this machine. Raises MCH-AXIS with those that there are."""
    known = {str(error): error for error in model.machine.chain.errors()}
    if name in known:
        return known[name]
    raise Code.MCH_AXIS.refusal(
        f"the machine cannot have {name!r}; it has {len(known)} errors: {' '.join(known)}",
        hint="name one of them, or `--errors auto` for those that the diagnosis finds",
    )
