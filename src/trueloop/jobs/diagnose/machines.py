"""Diagnoses of models of machines from a store."""

from collections.abc import Collection, Mapping
from pathlib import Path

from trueloop.errors import Finding
from trueloop.jobs.diagnose.both import GivenModel, both_of_machine, given_model
from trueloop.jobs.diagnose.shaped import machine_shape
from trueloop.loops.diagnosis.machine import MachineDiagnosis, diagnose_machine
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape
from trueloop.storage.store import Store


def machine_of(
    store: Store, given: GivenModel, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> tuple[MachineDiagnosis, list[Finding]]:
    """Diagnoses the model; returns its verdict, and the findings on the parts."""
    parts, findings = both_of_machine(store, given, part_types, accept)
    return diagnose_machine(given.model, parts, element, accept), findings


def machine(
    store: Store, model: Path, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> MachineDiagnosisShape:
    """Determines which axis errors the model of a machine has wrong."""
    given = given_model(model)
    done, findings = machine_of(store, given, part_types, element, accept)
    return machine_shape(given, done, findings)
