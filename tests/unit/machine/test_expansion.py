"""`expansion = { … }` of a machine file: an error that grows with position times a signal."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.machine.identify.form import fit_form
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.model import State

AXES = '[machine]\nname = "m"\nstructure = "turning"\n[axes.X]\ntravel_mm = [0, 100]\n[axes.Z]\ntravel_mm = [-300, 0]\n'
TERM = AXES + '[[term]]\nerror = "EZZ"\ndegree = 2\nzero_at = [-100]\nexpansion = { T7 = 20.0 }\n'


def test_a_screw_that_grows_is_found(tmp_path: Path) -> None:
    """E = a z' + α z' (T − 20), z' from where it is held: read at random places and temperatures, known elsewhere."""
    (tmp_path / "machine.toml").write_text(TERM)
    machine, form = read_machine(tmp_path / "machine.toml")
    assert form.terms[0].admissible().shape == (5, 3), "both parts are zero where the error is"
    rng = np.random.default_rng(1)
    z, warm = rng.uniform(-300, 0, 60), rng.uniform(18, 32, 60)

    def truth(z: Array, warm: Array) -> Array:
        return np.asarray(30e-6 * (z + 100) + 11.5e-6 * (z + 100) * (warm - 20))

    state = State(machine.chain.positions({"Z": z}), 0.0, {"T7": warm})
    along = np.tile([0.0, 0.0, 1.0], (60, 1))
    data = Observations(state, along, truth(z, warm), np.zeros(60, bool), np.full(60, np.nan), ("1",) * 60)
    model = fit_form(machine, form, data)[0].model
    elsewhere, warmer = rng.uniform(-300, 0, 20), rng.uniform(20, 25, 20)
    asked = State(machine.chain.positions({"Z": elsewhere}), 0.0, {"T7": warmer})
    assert np.abs(model.error_mm(asked)[:, 2] - truth(elsewhere, warmer)).max() < 1e-9


def test_what_has_no_position_does_not_expand(tmp_path: Path) -> None:
    (tmp_path / "machine.toml").write_text(AXES + '[[term]]\nerror = "EZ0C"\nexpansion = { T7 = 20.0 }\n')
    with pytest.raises(TrueloopError) as refused:
        read_machine(tmp_path / "machine.toml")
    assert refused.value.code is Code.MCH_FILE
