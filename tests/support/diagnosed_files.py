"""A simulated series as files and commands take it: a model that knows nothing, both inspections of each part."""

from pathlib import Path

import numpy as np

from studies.diagnosed.axis_errors import CHUCK_MM, SIGNALS
from studies.diagnosed.shop import Made, Series, tool_of_points_mm
from studies.diagnosed.truth import Fault, Truth, Wrong
from trueloop.diagnosis.causes.cause import SeenBy
from trueloop.formats.tables.model_file import model_to_json
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, PositionBasis, Term, chain_of

ELEMENT = {"X": "T cross slide", "Z": "T carriage", "C": "T spindle"}
RANGES = {"X": (-80.0, 60.0), "Z": (-20.0, 270.0)}
AXIS_ERRORS = ("EXX", "EZX", "EBX", "EXZ", "EZZ", "EBZ", "EX0C", "EZ0C", "EB0C")


def name_of(signal: str) -> str:
    """As commands take it: without a blank."""
    return signal.replace(" ", "_")


def wrong(error: str, size_mm: float) -> Truth:
    """One axis error that the model has wrong, following the temperature of its own element."""
    return Truth((Wrong(Fault.AXIS_ERROR, size_mm, error=error, signal=ELEMENT[error[-1]]),))


def model_file(folder: Path, name: str = "lathe 3", serial: str = "77") -> Path:
    """A turning centre whose model says 0 everywhere, with terms that could say otherwise."""
    chain = chain_of("turning")
    terms = tuple(_term(error) for error in AXIS_ERRORS)
    size = sum(term.size for term in terms)
    known = {**RANGES, **dict.fromkeys(map(name_of, SIGNALS), (15.0, 45.0))}
    units = dict.fromkeys(map(name_of, SIGNALS), "°C")
    model = MachineModel(Machine(name, chain, serial), terms, np.zeros(size), 1e-12 * np.eye(size), known, units=units)
    file = folder / "model.json"
    file.write_text(model_to_json(model), encoding="utf-8")
    return file


def _term(error: str) -> Term:
    axis, name = error[-1], error_name(error)
    basis = CONSTANT if axis == "C" else PositionBasis(RANGES[axis], 1)
    return Term(name, (Part(basis), Part(basis, name_of(ELEMENT[axis]), 20.0)))


def both_file(series: Series, made: Made, file: Path, *, tools: bool = True) -> Path:
    """What both devices read of one part on the side where it is cut, with the tool that cut each point."""
    rows = series.points.angle_rad == 0.0
    at, flat = series.points.at_mm[rows], series.points.normal[rows]
    held = tool_of_points_mm(series.places, series.points)[rows]
    nominal, normal, tool = (_in_space(v) for v in (at, flat, held))
    controller, cmm = (nominal + normal * made.read_mm[by][rows][:, None] for by in (SeenBy.MACHINE, SeenBy.CMM))
    columns = [nominal, normal, controller, cmm, *([tool, tool] if tools else [])]
    names = [
        f"{kind}_{c}{unit}"
        for kind, unit in (("nominal", "_mm"), ("normal", ""), ("controller", "_mm"), ("cmm", "_mm"))
        + ((("tool", "_mm"), ("probe", "_mm")) if tools else ())
        for c in "xyz"
    ]
    points = [f"{name}:{k}" for k, name in enumerate(np.array(series.points.feature)[rows].tolist())]
    table = np.hstack(columns)
    lines = ["# touch_u_um 0.8", "# cmm_u_um 0.5", ",".join(["point", *names])]
    lines += [",".join([point, *(f"{value:.9f}" for value in row)]) for point, row in zip(points, table, strict=True)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def decompose(series: Series, made: Made, file: Path, model: Path, db: str, **more: str) -> list[str]:
    """The command that keeps it; `more` options by name, `serial` and `type` among them."""
    zero = ("--work-zero", f"0,0,{CHUCK_MM}")
    cutting = [
        word for name, value in made.moment.read_c.items() for word in ("--cutting", f"{name_of(name)}={value:.3f}")
    ]
    cooler = {name: value - series.shop.cooled_k for name, value in made.moment.read_c.items()}
    probing = [word for name, value in cooler.items() for word in ("--probing", f"{name_of(name)}={value:.3f}")]
    options = [word for name, value in more.items() for word in (f"--{name}", value)]
    out = ("-o", str(file.parent / "out"), "--db", db)
    return ["machine", "decompose", str(file), "-m", str(model), *zero, *cutting, *probing, *out, *options]


def _in_space(flat: np.ndarray) -> np.ndarray:
    return np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]])
