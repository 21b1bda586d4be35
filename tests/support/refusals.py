"""What a call is refused with."""

from collections.abc import Callable

import pytest

from trueloop.errors import TrueloopError


def refused(call: Callable[..., object], *given: object) -> TrueloopError:
    """The refusal that the call ends with; there must be one."""
    with pytest.raises(TrueloopError) as refusal:
        call(*given)
    return refusal.value
