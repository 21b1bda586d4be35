"""The answer of a milled part's job in words: what to enter at the control, and what to know of it."""

from collections.abc import Iterator, Sequence

from trueloop.jobs.milled import MilledJob
from trueloop.milled.entries import Proposal, ProposedEntry
from trueloop.milled.entry import Entry
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.units import MM_PER_INCH, UM_PER_MM


def entry_lines(job: MilledJob, proposal: Proposal, say: Texts = ENGLISH) -> list[str]:
    """Returns a line for each number, in the unit of the control and of its register, and the RMS with all of them."""
    before, after = (UM_PER_MM * value for value in proposal.rms_mm)
    lines = [_entry_line(job, entry, say) for entry in proposal.proposed]
    nothing = [] if lines else [say("nothing to enter: no number is known to be off")]
    rms = say(
        "expected deviation, RMS: {before:.1f} µm unchanged, {after:.1f} µm with these numbers",
        before=before,
        after=after,
    )
    return [*lines, *nothing, rms]


def _entry_line(job: MilledJob, entry: ProposedEntry, say: Texts) -> str:
    """Returns what to type; in the job's unit beside it where it differs from the control's."""
    typed, in_tool = job.as_entered(entry), entry.entry.register in ("radius", "length")
    unit, decimals = {"mm": (" mm", 3), "in": (" in", 4), "deg": ("°", 3)}[typed.unit]

    def number(value: float, spec: str) -> str:
        return say.spelled(f"{value:{spec}}")

    change = f"{number(typed.change, f'+.{decimals}f')}{unit}"
    if typed.unit != "deg" and job.control_unit != job.job.unit:
        own, per = ("in", 1.0 / MM_PER_INCH) if typed.unit == "mm" else ("mm", MM_PER_INCH)
        change += f" = {number(typed.change * per, f'+.{8 - decimals}f')} {own}"
    line = say(
        "{register}: add {change} (± {u})",
        register=_named(entry.entry, typed.holds, say) + (f" ({typed.name})" if in_tool and typed.name else ""),
        change=change,
        u=f"{number(2.0 * typed.standard_u, f'.{decimals + 1}f')}{unit}",
    )
    if entry.change == entry.total:
        return line
    return line + say("; since the first part {total}", total=f"{number(typed.total, f'+.{decimals}f')}{unit}")


def _named(entry: Entry, holds: str, say: Texts) -> str:
    """Names a register; `holds` is the quantity that stands there of a tool."""
    if entry.register in ("radius", "length"):
        quantities = {"radius": say("radius"), "diameter": say("diameter"), "length": say("length")}
        return say("tool {tool}, {quantity}", tool=entry.of, quantity=quantities[holds])
    if entry.register == "turn":
        return say("{offset}, rotation about Z", offset=entry.of)
    return f"{entry.of}, {entry.register.upper()}"


def proposal_notes(job: MilledJob, proposal: Proposal, say: Texts = ENGLISH) -> list[str]:
    """Returns the readings that the numbers leave out, and the numbers that rest on one reading."""
    return list(_notes(job, proposal, say))


def _notes(job: MilledJob, proposal: Proposal, say: Texts) -> Iterator[str]:
    for name in proposal.unlike:
        yield say(
            "{name}: far off what tools and work offsets explain; it has no part in these numbers, measure it again",
            name=name,
        )
    for each in proposal.contradictory:
        low, high = (say.spelled(f"{UM_PER_MM * value:+.1f}") for value in each.between_mm)
        yield say(
            "{names}: {n} readings on part '{serial}', {low} to {high} µm{counted}, contradict each other; they have "
            "no part in these numbers, measure it again",
            names=say(" and ").join(each.names),
            n=each.readings,
            serial=each.serial,
            low=low,
            high=high,
            counted="" if len(each.names) == 1 else say(" as {name}", name=each.names[0]),
        )
    if proposal.suspected:
        yield say(
            "part '{serial}' is off {slip}; so little may be scatter: look at the control before anything is entered",
            serial=job.parts[-1].serial,
            slip=proposal.suspected,
        )
    for entry, name in proposal.by_one_reading.items():
        yield say(
            "{register}: only {name} shows it, read once; a chip there would be entered too: measure it a second time",
            register=_named(entry, entry.register, say),
            name=name,
        )
    for name in job.cut.stated:
        yield say("{name}: not in the program; tool and work offset are as stated", name=name)
    if job.unused:
        yield say(
            "{n} readings show no size or coordinate of a feature: {names}", n=len(job.unused), names=_first(job.unused)
        )


def _first(names: Sequence[str]) -> str:
    return ", ".join(names[:10]) + (", …" if len(names) > 10 else "")
