"""Inspections as hypothesis makes them: parts, times and readings with all that a file can hold of them."""

from collections.abc import Callable
from datetime import datetime

from hypothesis import strategies as st

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType

NAMES = st.text("abcdefgXYZ0123456789äøß°直径<>&\"'/-_.", min_size=1, max_size=12)
SIZES = st.floats(-500.0, 500.0, allow_nan=False).map(lambda value: round(value, 9) + 0.0)
TIMES = st.datetimes(datetime(1990, 1, 1), datetime(2060, 1, 1)).map(lambda time: time.replace(microsecond=0))
LIMITS = st.tuples(st.none() | SIZES, st.none() | SIZES)


def readings(places: bool) -> st.SearchStrategy[Reading]:
    """One reading; with `places` also features, place, axis and uncertainty, without only what every format has."""

    def made(quantity: Quantity, extra: dict[str, object], **fields: object) -> Reading:
        if quantity is Quantity.POSITION and "axis" not in extra:
            extra = {}
        return Reading(quantity=quantity, **fields, **extra)  # type: ignore[arg-type]

    extra = {
        "feature": NAMES,
        "other": NAMES,
        "axis": st.sampled_from("xyz"),
        "place_mm": st.lists(SIZES, min_size=1, max_size=3).map(tuple),
        "standard_u": st.floats(1e-6, 0.25),
    }
    return st.builds(
        lambda limits, **fields: made(lower_limit=limits[0], upper_limit=limits[1], **fields),
        limits=LIMITS,
        quantity=st.sampled_from(Quantity),
        extra=st.fixed_dictionaries({}, optional=extra) if places else st.just({}),
        characteristic=NAMES,
        actual=SIZES,
        nominal=st.none() | SIZES,
        measured_at=st.none() | TIMES,
    )


def inspections(places: bool, finish: Callable[[list[Reading]], list[Reading]] = list) -> st.SearchStrategy[Inspection]:
    """One inspection of one to five readings with different names."""

    def made(read: list[Reading], name: str, revision: str, serial: str, device: str, operator: str) -> Inspection:
        values = tuple(finish(read))
        time = next((one.measured_at for one in values if one.measured_at is not None), None)
        part = Part(PartType(name, revision), serial)
        return Inspection(
            part, "readings", "0" * 64, len(values), values, device=device, operator=operator, measured_at=time
        )

    several = st.lists(readings(places), min_size=1, max_size=5, unique_by=lambda one: one.characteristic)
    return st.builds(made, several, NAMES, NAMES | st.just(""), NAMES | st.just(""), NAMES | st.just(""), NAMES)
