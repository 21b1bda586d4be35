"""An image with signals, the model that it was made from, and a configuration beside them."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.tables.model_file import model_to_json
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of
from trueloop.realtime.image import Block, Identity, Image, RealTimeLimits, bank_of, signals_of

MACHINE = Machine("lathe", chain_of("turning"), "4711")


def model_of(names: tuple[str, ...], lags: tuple[Lag, ...] = (), unit: str = "°C") -> MachineModel:
    """A spindle that drifts by 1 µm for one unit of each signal, known from 10 to 60 of it."""
    terms = (Term(error_name("EX0C"), tuple(Part(CONSTANT, name, 20.0) for name in names)),)
    size, known = sum(term.size for term in terms), dict.fromkeys(names, (10.0, 60.0))
    covariance = np.zeros((size + len(lags),) * 2)
    units = dict.fromkeys(names, unit)
    return MachineModel(MACHINE, terms, np.full(size, 1e-3), covariance, known, lags, units)


def image_bytes(model: MachineModel, program: bytes = b"", blocks: tuple[Block, ...] = ()) -> bytes:
    """The model as an image, with a table for a program where there are blocks."""
    sha256 = hashlib.sha256(program).hexdigest() if program else ""
    identity = Identity("lathe", "4711", hashlib.sha256(model_to_json(model).encode()).hexdigest(), "part", sha256)
    limits = RealTimeLimits(((-10.0, 400.0), (-1.0, 1.0), (-300.0, 200.0)))
    return image_to_bytes(Image(identity, limits, bank_of(model, (0.0, 0.0, 0.0), signals_of(model)), blocks))


def write_image(folder: Path, model: MachineModel) -> None:
    """`model.json` and `lathe.img`."""
    (folder / "model.json").write_text(model_to_json(model))
    (folder / "lathe.img").write_bytes(image_bytes(model))


def write_configuration(folder: Path, text: str, top: Mapping[str, object] = {}) -> Path:
    """`signals.toml`: the tables after `image` and what else stands at the top."""
    head = [f"{name} = {value}" for name, value in {"image": '"lathe.img"', **top}.items()]
    path = folder / "signals.toml"
    path.write_text("\n".join([*head, "", text]))
    return path
