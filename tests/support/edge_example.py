"""The files of `examples/edge`, two parts of one edge in the simulator: `python -m tests.support.edge_example`."""

from pathlib import Path

import numpy as np

from tests.support.correction import EXAMPLES, example_inputs
from tests.support.edge_in_simulator import cut, measured_vectors, workshop_of
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import finish_along, semifinish_and_probe, trial_of

FOLDER = EXAMPLES / "edge"
FEW = (2, 9, 16)


def files() -> dict[str, ErrorVectors]:
    """By name: touches of part 1, what a measuring machine found on it after its finish cut, touches of part 2, and
    what was found on that one after a finish cut by the given program instead of the corrected one.
    """
    inputs = example_inputs("modbas2")
    trial = trial_of(inputs, inputs.touches.point[int(np.flatnonzero(inputs.touches.at_reference)[0])])
    dome = inputs.profile.names.index("dome")
    _, first = semifinish_and_probe(trial, workshop_of(0), 0)
    made = cut(trial, dome, None, (), workshop_of(0), 0)
    stock, second = semifinish_and_probe(trial, workshop_of(1), 1)
    not_run = finish_along(workshop_of(1), workshop_of(1).machine, trial.finish, stock, 1)
    left_out = np.delete(second.of_feature(dome), FEW)
    few = second.chosen(np.setdiff1d(np.arange(len(second.point)), left_out))
    return {
        "touches-1.csv": first,
        "finish-1.csv": measured_vectors(trial, made.finished, workshop_of(0), 0),
        "touches-2.csv": few,
        "not-run-2.csv": measured_vectors(trial, not_run, workshop_of(1), 1),
    }


def text_of(vectors: ErrorVectors) -> str:
    """A table of touches with errors to 0.1 µm."""
    inputs = example_inputs("modbas2")
    rows = [
        f"{point},{inputs.profile.names[index]},{x:.6f},{z:.6f},{error * UM_PER_MM:.1f}"
        for point, index, (x, z), error in zip(
            vectors.point, vectors.feature_index, vectors.nominal_mm, vectors.error_mm, strict=True
        )
    ]
    head = ["# simulated, no metal: tests/support/edge_example.py", "point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    return "\n".join([*head, *rows]) + "\n"


if __name__ == "__main__":
    for name, vectors in files().items():
        Path(FOLDER / name).write_text(text_of(vectors), encoding="utf-8")
