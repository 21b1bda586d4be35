"""Every way in which a machine model or its data is refused."""

from collections.abc import Callable

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.machine.names import error_name
from trueloop.machine.structure import chain_of

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MCH_NAME: lambda: error_name("EXX1"),
    Code.MCH_STRUCTURE: lambda: chain_of("w X Y Z t"),
    Code.MCH_AXIS: lambda: chain_of("mill-gantry").axis("C"),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert any(character.isdigit() for character in refusal.value.message)
    assert refusal.value.hint
