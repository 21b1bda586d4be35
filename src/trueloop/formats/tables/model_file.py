"""A machine model as JSON: mm, rad, and the units of its signals. What is written is read back bit for bit."""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.domain.record import sha256_of
from trueloop.errors import in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.record_file import read_json
from trueloop.machine.drift import DriftModel, Member
from trueloop.machine.model.chain import Axis, AxisKind, Chain, error_name
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import Acceptance, Machine, MachineModel, Version
from trueloop.machine.model.term import Part, PositionBasis, Term
from trueloop.machine.model.validity import require_in_force

DRIFT_FILE_FORMAT: Final = "trueloop drift model 1"
DRIFT_FILE_HINT: Final = "make one with `trueloop machine drift-fit`"


def drift_to_json(models: Mapping[str, DriftModel], made_from: dict[str, str]) -> str:
    """Returns the models as text; `made_from` names the log they were fitted to, with its sha256."""
    channels = {name: _channel(model) for name, model in models.items()}
    content = {"format": DRIFT_FILE_FORMAT, "made_from": made_from, "channels": channels}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def read_drift_models(path: Path) -> dict[str, DriftModel]:
    """Reads such a file. Raises MCH-FILE for what is none."""
    return read_json(path, DRIFT_FILE_FORMAT, _channels, hint=DRIFT_FILE_HINT)


def _channels(content: dict[str, Any]) -> dict[str, DriftModel]:
    return {name: _read_channel(channel) for name, channel in content["channels"].items()}


def _channel(model: DriftModel) -> dict[str, Any]:
    members = [{**member.__dict__, "weights": member.weights.tolist()} for member in model.members]
    return {"left_um": model.left_um, "start": dict(model.start), "known": dict(model.known), "members": members}


def _read_channel(content: dict[str, Any]) -> DriftModel:
    members = tuple(_member(member) for member in content["members"])
    start = {name: float(value) for name, value in content["start"].items()}
    known = {name: (float(low), float(high)) for name, (low, high) in content["known"].items()}
    model = DriftModel(members, start, known, float(content.get("left_um", 0.0)))
    if not members or set(model.inputs) - start.keys() or set(model.signals) - known.keys() or not model.left_um >= 0:
        raise ValueError(f"{len(members)} members, of whose inputs some have no start or no range")
    return model


def _member(content: dict[str, Any]) -> Member:
    inputs, ladder = tuple(content["inputs"]), tuple(map(float, content["ladder_s"]))
    weights, constant = np.array(content["weights"], dtype=np.float64), float(content["constant"])
    if weights.shape != (len(inputs) * len(ladder),) or not (np.isfinite(weights).all() and np.isfinite(constant)):
        raise ValueError(f"{len(inputs)} inputs with {len(ladder)} time constants have {weights.shape} weights")
    return Member(inputs, ladder, weights, constant)


FORMAT: Final = "trueloop machine model 2"
"""Format 1 counted the arms of a table's angular errors from the table itself: its coefficients mean something else."""

HINT: Final = "make one with `trueloop machine fit`; a model of format 1 has to be fitted again from its readings"


OPPOSITE: Final = ", opposite sense"
"""Ending of a kind of axis; no key of its own, which earlier versions would pass over."""


def model_to_json(model: MachineModel, made_from: Mapping[str, str] | None = None) -> str:
    """Returns the model as text; `made_from` names the files it was fitted to, with their sha256.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> _ = Path("model.json").write_text(trueloop.model_to_json(found.model), encoding="utf-8")
    >>> trueloop.read_model("model.json").machine.serial
    '4711'
    """
    content = {
        "format": FORMAT,
        "machine": {
            "name": model.machine.name,
            "serial": model.machine.serial,
            "work": [_axis(axis) for axis in model.machine.chain.work],
            "tool": [_axis(axis) for axis in model.machine.chain.tool],
        },
        "made_from": dict(made_from or {}),
        **({} if model.version is None else {"version": asdict(model.version)}),
        "identified": {name: list(known) for name, known in model.identified.items()},
        "terms": [
            {"error": str(t.name), "both_ways": t.both_ways, "parts": [_part(p) for p in t.parts]} for t in model.terms
        ],
        "lags": [{**lag.__dict__, "between_s": lag.between_s and list(lag.between_s)} for lag in model.lags],
        "units": dict(model.units),
        "coefficients": model.coefficients.tolist(),
        "covariance": model.covariance.tolist(),
    }
    return _text(content)


def _text(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def read_model(path: FilePath, *, offered: bool = False) -> MachineModel:
    """Reads a model file. Raises MCH-FILE for what is none, MCH-OFFERED for a refined one that was not accepted.

    With `offered` such a one is read too, to be looked at: nothing may be corrected by it.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> _ = Path("model.json").write_text(trueloop.model_to_json(found.model), encoding="utf-8")
    >>> np.array_equal(trueloop.read_model("model.json").coefficients, found.model.coefficients)
    True
    """
    path = Path(path)
    model = read_json(path, FORMAT, _model, hint=HINT)
    if not offered and model.version is not None:
        with in_file(path):
            require_in_force(model, sha256_of(path.read_bytes()))
    return model


def accepted_text(path: Path, acceptance: Acceptance) -> str:
    """Returns an offered model file with its acceptance, all else as it was. Raises MCH-FILE for any other."""

    def accepted(content: dict[str, Any]) -> str:
        version = _model(content).version
        if version is None:
            raise ValueError("it was fitted from readings and needs no acceptance")
        if version.accepted is not None:
            raise ValueError(f"version {version.number} was accepted by {version.accepted.who} {version.accepted.at}")
        return _text({**content, "version": asdict(replace(version, accepted=acceptance))})

    return read_json(path, FORMAT, accepted, hint="name a refined model that is offered")


def _model(content: dict[str, Any]) -> MachineModel:
    named = content["machine"]
    work, tool = (tuple(_read_axis(axis) for axis in named[side]) for side in ("work", "tool"))
    machine = Machine(named["name"], Chain(work, tool), named["serial"])
    terms = tuple(
        Term(error_name(t["error"]), tuple(_read_part(p) for p in t["parts"]), t["both_ways"]) for t in content["terms"]
    )
    coefficients, covariance = (np.array(content[name], dtype=np.float64) for name in ("coefficients", "covariance"))
    lags = tuple(Lag(between_s=_pair(lag.pop("between_s")), **lag) for lag in content.get("lags", []))
    size = sum(term.size for term in terms)
    if coefficients.shape != (size,) or covariance.shape != (size + len(lags),) * 2:
        raise ValueError(f"{size} coefficients are needed, {coefficients.shape} and {covariance.shape} are there")
    if not (np.isfinite(coefficients).all() and np.isfinite(covariance).all()):
        raise ValueError(f"some of {size} coefficients and their covariance are no numbers")
    identified = {name: (float(low), float(high)) for name, (low, high) in content["identified"].items()}
    units = {str(name): str(unit) for name, unit in content.get("units", {}).items()}
    version = _version(content.get("version"))
    return MachineModel(
        machine=machine,
        terms=terms,
        coefficients=coefficients,
        covariance=covariance,
        identified=identified,
        lags=lags,
        units=units,
        version=version,
    )


def _version(content: dict[str, Any] | None) -> Version | None:
    if content is None:
        return None
    given = {**content, "errors": tuple(str(error_name(one)) for one in content["errors"])}
    accepted = given.pop("accepted")
    texts = [given[name] for name in ("parent_sha256", "reason", "judged", "made_at", "made_by")]
    if not all(isinstance(text, str) for text in texts) or type(given["number"]) is not int:
        raise TypeError("the version's number, parent, reason, judgement, time or maker is of another kind")
    known = None if accepted is None else Acceptance(**accepted)
    if known is not None and not (known.who and all(isinstance(text, str) for text in accepted.values())):
        raise ValueError("the version was accepted by nobody")
    return Version(**given, accepted=known)


def _pair(ends: list[float] | None) -> tuple[float, float] | None:
    if not ends:
        return None
    low, high = map(float, ends)
    return low, high


def _axis(axis: Axis) -> dict[str, Any]:
    travel = [None if np.isinf(end) else end for end in axis.travel]
    offset = list(axis.offset_mm)
    kind = axis.kind if axis.sense > 0 else f"{axis.kind}{OPPOSITE}"
    return {"name": axis.name, "kind": kind, "number": axis.number, "offset_mm": offset, "travel": travel}


def _read_axis(content: dict[str, Any]) -> Axis:
    low, high = content["travel"]
    x, y, z = content["offset_mm"]
    travel = (-np.inf if low is None else low, np.inf if high is None else high)
    kind = AxisKind(content["kind"].removesuffix(OPPOSITE))
    sense = -1.0 if content["kind"].endswith(OPPOSITE) else 1.0
    return Axis(
        name=content["name"], kind=kind, number=content["number"], offset_mm=(x, y, z), travel=travel, sense=sense
    )


def _part(part: Part) -> dict[str, Any]:
    basis = part.basis
    shape = {"breaks": list(basis.breaks), "degree": basis.degree, "zero_at": list(basis.zero_at)}
    return shape | {"signal": part.signal, "reference": part.reference}


def _read_part(content: dict[str, Any]) -> Part:
    basis = PositionBasis(tuple(content["breaks"]), content["degree"], tuple(content["zero_at"]))
    return Part(basis, content["signal"], content["reference"])
