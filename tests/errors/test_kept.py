"""Every way in which what is kept in a store is refused."""

from collections.abc import Callable

from tests.support.correction import example_correction
from tests.support.kept import cut_of
from trueloop.errors import Code
from trueloop.loops.turned.made_parts import program_that_ran

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.STO_PROGRAM: lambda: program_that_ran(
        example_correction("modbas2"), cut_of(example_correction("modbas2"), program_sha256="0" * 64)
    ),
}
