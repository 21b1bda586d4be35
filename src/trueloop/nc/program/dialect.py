"""The dialects the Rust core knows: what a writer of programs needs of them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from trueloop._core import nc_dialects
from trueloop.errors import Code, TrueloopError
from trueloop.units import MM_PER_INCH


@dataclass(frozen=True)
class Dialect:
    """How one control writes numbers, comments and expressions.

    `resolution_inch` and `resolution_mm` are the smallest programmable steps of an inch and of a metric program.
    `radius_address` is what stands before the radius of an arc: `R`, `CR=`. `lead_along_thread`: the lead of a tapered
    thread counts along it, else along the axis on which it is longer. `decimal_comma`: the
    program at hand writes `X+2,5`.
    """

    name: str
    resolution_inch: float
    resolution_mm: float
    comment_open: str
    comment_close: str
    bracket_open: str
    radius_address: str
    lead_along_thread: bool
    decimal_comma: bool = False

    def step(self, inch: bool) -> float:
        """The smallest programmable step, in the unit of the program."""
        return self.resolution_inch if inch else self.resolution_mm

    def step_mm(self, inch: bool) -> float:
        """The same in mm."""
        return self.step(inch) * (MM_PER_INCH if inch else 1.0)

    def with_decimals(self, decimals: int) -> "Dialect":
        """The same, with steps of that many decimals where its own are coarser."""
        finest = float(f"1e-{decimals}")
        inch, metric = min(self.resolution_inch, finest), min(self.resolution_mm, finest)
        return replace(self, resolution_inch=inch, resolution_mm=metric)

    def comment(self, text: str) -> str:
        """The text as a comment on one line."""
        kept = " ".join(text.split())
        if self.comment_close:
            kept = kept.replace(self.comment_open, "[").replace(self.comment_close, "]")
        return f"{self.comment_open}{kept}{self.comment_close}"


DIALECTS: Mapping[str, Dialect] = MappingProxyType({row[0]: Dialect(*row) for row in nc_dialects()})
"""Every dialect by its name."""


def dialect_named(name: str) -> Dialect:
    """The dialect of that name. Raises NC-DIALECT when there is none."""
    if name not in DIALECTS:
        raise TrueloopError(
            Code.NC_DIALECT, f"unknown NC dialect {name!r}", hint=f"choose one of: {', '.join(DIALECTS)}"
        )
    return DIALECTS[name]
