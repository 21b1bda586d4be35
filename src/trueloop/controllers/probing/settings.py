"""How a probing program writes coordinates, and what it says besides moves."""

from dataclasses import dataclass

from trueloop.described import filled_from
from trueloop.formats.jobs.probe_toml import ProbeTable, ProgramTable
from trueloop.geometry.feature import Point
from trueloop.probing.probe_plan import ProbePlan
from trueloop.units import MM_PER_INCH


@dataclass(frozen=True)
class Settings:
    """Unit and diameter mode of the program, feeds in mm/min, the probe's tool number, work offset 54–59 and log.

    `probe_on`, `probe_off` and `orient` (of the spindle) are lines in the control's code: before the first touch, after
    the last, and behind the spindle's stop. `program_number` is the O number, below O9000: above, controls protect
    programs.

    Moves between touches are at `position_feed_mm_per_min` in straight lines: not every control runs rapids straight.
    """

    part: str = "part"
    inch: bool = False
    diameter: bool = True
    probe_feed_mm_per_min: float = 60.0
    position_feed_mm_per_min: float = 2000.0
    tool: int = 9
    work_offset: int = 54
    log: str = "touches.txt"
    program_number: int = 8100
    probe_on: tuple[str, ...] = ()
    probe_off: tuple[str, ...] = ()
    orient: tuple[str, ...] = ()

    @property
    def unit_mm(self) -> float:
        """Millimetres in a program unit."""
        return MM_PER_INCH if self.inch else 1.0

    @property
    def decimals(self) -> int:
        """Returns the decimals of a length: 0.1 µm or 0.00001 in."""
        return 5 if self.inch else 4

    def words(self, point_mm: Point) -> str:
        """Returns `X… Z…` of the ball's centre, in the program's unit, X as a diameter where that is the mode."""
        x, z = point_mm
        return f"X{self.number(x * (2.0 if self.diameter else 1.0))} Z{self.number(z)}"

    def number(self, length_mm: float) -> str:
        """Formats a length in program units, always with its decimal point."""
        text = f"{length_mm / self.unit_mm:.{self.decimals}f}".rstrip("0")
        return "0." if text in ("-0.", "0.") else text

    def added(self, vector_mm: Point) -> tuple[str, str]:
        """Returns what is added to X and Z along a vector: `+1.5`, in the program's unit, X as `words` has it."""
        words = (word[1:] for word in self.words(vector_mm).split())
        x, z = (word if word.startswith("-") else f"+{word}" for word in words)
        return x, z

    def feed(self, mm_per_min: float) -> str:
        """Returns the F word of a feed."""
        return f"F{self.number(mm_per_min)}"

    def safe_first(self, plan: ProbePlan) -> tuple[str, str]:
        """Returns the way to the safe position from anywhere outside: first away from the axis, then along it."""
        x, z = self.words(plan.safe_mm).split()
        return x, z


def heading(plan: ProbePlan, settings: Settings) -> list[str]:
    """Returns what a person at the control should know, without the control's comment marks."""
    mode = "diameters" if settings.diameter else "radii"
    return [
        f"Probing program for {settings.part}: {len(plan.touches)} touches",
        f"Programmed point: centre of the ball, radius {plan.stylus.ball_radius_mm:.3f} mm; X in {mode}",
        f"The surface is expected {plan.approach.allowance_mm:.3f} mm over the nominal one",
        *_second(plan),
        *([] if settings.probe_on else ["No code turns the probe on: see that it is"]),
    ]


def _second(plan: ProbePlan) -> list[str]:
    second = plan.approach.second
    if second is None:
        return []
    again = f"from {second.back_off_mm:.3f} mm back, at {second.feed_mm_per_min:g} mm/min"
    return [f"Each point is touched again {again}: the second touch is logged"]


def settings_of(part: str, table: ProgramTable, probe: ProbeTable) -> Settings:
    """Converts the tables [program] and [probe] of a probe file to settings."""
    return filled_from(
        Settings,
        table,
        part=part,
        inch=table.unit == "inch",
        diameter=table.x_is == "diameter",
        probe_on=_lines(probe.on),
        probe_off=_lines(probe.off),
        orient=_lines(probe.orient),
    )


def _lines(text: str) -> tuple[str, ...]:
    """Lines of code without blank ones."""
    return tuple(line.strip() for line in text.splitlines() if line.strip())
