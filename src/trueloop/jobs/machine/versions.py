"""Versions of a machine's model: offered as files, accepted by somebody, both kept in a store."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop.domain.machine import Machine
from trueloop.domain.model_version import ModelDecision, ModelVersion
from trueloop.domain.record import sha256_of
from trueloop.errors import Code
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.model_file import accepted_text, model_to_json, read_model
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.jobs.store.where import store_of
from trueloop.jobs.user import user_name
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.version import Acceptance, Version
from trueloop.machine.refine.refine import Refined, require_better


def offer_model(
    parent: Path, refined: Refined, out: Path, *, db: str | None = None, accept: Sequence[Code] = ()
) -> tuple[Path, KeptFacts | None]:
    """Writes the refined model to `out` as a version that is offered, and keeps it; None: there is no store.

    `parent` is the file that it was refined from. Raises DIA-WORSE for one that is no better on parts left out, unless
    that is among `accept`, OUT errors (the parent is never overwritten), and what keeping refuses.
    """
    require_better(refined, accept)
    known, content = read_model(parent), parent.read_bytes()
    version = Version(
        number=1 if known.version is None else known.version.number + 1,
        parent_sha256=sha256_of(content),
        errors=tuple(dict.fromkeys(str(one.error) for one in refined.guilty)),
        reason=str(refined.reason),
        judged=str(refined.judged.words),
        made_at=_now(),
        made_by=user_name(),
    )
    model = replace(refined.model, version=version)
    text = model_to_json(model, {parent.name: version.parent_sha256})
    (written,) = write_all(out.parent, [(out.name, text.encode())], inputs=(parent,))
    return written, _kept(written, (_value(model, version, text),), db)


def accept_model(
    offered: Path, out: Path, *, why: str = "", who: str = "", db: str | None = None
) -> tuple[Path, KeptFacts | None]:
    """Writes the offered model to `out` as accepted, by the user unless `who` is named, and keeps the decision.

    Raises MCH-FILE for a model that is not offered or was accepted before, OUT errors (the offered file is never
    overwritten), and STO-DIFFERS where the store holds another decision on it.
    """
    before = read_model(offered, offered=True)
    text, content = offered.read_text(encoding="utf-8"), offered.read_bytes()
    acceptance = Acceptance(who or user_name(), _now(), why)
    accepted = accepted_text(offered, acceptance)
    (written,) = write_all(out.parent, [(out.name, accepted.encode())], inputs=(offered,))
    at = datetime.fromisoformat(acceptance.at)
    decision = ModelDecision(sha256_of(content), "accepted", acceptance.who, at, why)
    now = read_model(written)
    assert before.version is not None and now.version is not None
    values = (_value(before, before.version, text), decision, _value(now, now.version, accepted))
    return written, _kept(written, values, db)


def _value(model: MachineModel, version: Version, text: str) -> ModelVersion:
    """As the store has it."""
    return ModelVersion(
        machine=Machine(model.machine.name, model.machine.serial),
        sha256=sha256_of(text.encode()),
        text=text,
        parent_sha256=version.parent_sha256,
        errors=version.errors,
        reason=version.reason,
        judged=version.judged,
        made_at=datetime.fromisoformat(version.made_at),
        made_by=version.made_by,
    )


def _kept(file: Path, values: tuple[ModelVersion | ModelDecision, ...], db: str | None) -> KeptFacts | None:
    store = store_of(file.parent, db, None)
    return None if store is None else keep_facts(store, values)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
