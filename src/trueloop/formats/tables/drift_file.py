"""Drift models as JSON, one a channel, in µm; signals by their columns' names, unit and all."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.formats.json_file import read_json
from trueloop.machine.drift.model import DriftModel, Member

FORMAT: Final = "trueloop drift model 1"
HINT: Final = "make one with `trueloop machine drift-fit`"


def drift_to_json(models: Mapping[str, DriftModel], made_from: dict[str, str]) -> str:
    """The models as text; `made_from` names the log they were found from, with its sha256."""
    channels = {name: _channel(model) for name, model in models.items()}
    content = {"format": FORMAT, "made_from": made_from, "channels": channels}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def read_drift_models(path: Path) -> dict[str, DriftModel]:
    """Reads such a file. Raises MCH-FILE for what is none."""
    return read_json(path, FORMAT, _channels, hint=HINT)


def _channels(content: dict[str, Any]) -> dict[str, DriftModel]:
    return {name: _read_channel(channel) for name, channel in content["channels"].items()}


def _channel(model: DriftModel) -> dict[str, Any]:
    members = [{**member.__dict__, "weights": member.weights.tolist()} for member in model.members]
    return {
        "left_um": model.left_um,
        "start": dict(model.start),
        "known": dict(model.known),
        "members": members,
    }


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
