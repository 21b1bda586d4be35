"""Records of corrections, made up: every field holds something."""

import json
from datetime import UTC, datetime

from hypothesis import strategies as st

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import HeldTool, TableRow, ToolOffset
from trueloop.domain.record import CONTENT, ChangedWord, Component, Product, Program, Record, content_sha256
from trueloop.domain.tool import Edge, Machine, Setting, Tool

PART = PartType("shaft", "B", "C45")
TURNED = Record(
    id="0123456789abcdef",
    made_at="2026-01-02T03:04:05+00:00",
    made_by="ana",
    trueloop_version="0.1.0",
    inputs_sha256={"job.toml": "0" * 64, "touches.csv": "1" * 64},
    options={"limits": {"correction_mm": 0.15, "slope": 0.04}, "unit": {"unit": "mm", "stated_by": "line 1"}},
    model={"curves": [{"feature": "dome"}], "scatter_mm": 0.0013, "degrees_of_freedom": 21},
    decision=["X: the contour is changed."],
    changes=[ChangedWord(3, 5, "X10.", "X9.98")],
    components=[Component.of("dome", "20", -0.005, -0.0734)],
    product=Product.TURNED,
    edits=1,
    part_type=PART,
    machine=Machine("lathe", "7"),
    tool=Tool(1, "SVJBR 2020", 0.8),
    program=Program("finish.nc", "fanuc-lathe", "2" * 64, "mm"),
    tool_offset=ToolOffset(
        *(3, -0.012, 0.004, True, "diameter", "mm", "1" * 64),
        HeldTool("OD", 1, TableRow("tool.tbl", "wear", "-0.1", None, "mm")),
        *(4, ("G21 G10 P3 U-0.0240 W0.0040",)),
    ),
    inspections=(
        Inspection(
            Part(PART, "17"),
            "touches",
            "1" * 64,
            1,
            (Touch("20", (10.0, -5.0), "dome", error_mm=0.0784, line=2),),
            device="probe of the machine tool",
            measured_at=datetime(2026, 1, 2, 3, tzinfo=UTC),
            temperatures={"bed_C": 21.5},
        ),
    ),
)

names = st.text(max_size=12)
lengths = st.floats(allow_nan=False, allow_infinity=False)
times = st.datetimes(timezones=st.just(UTC))
vectors = st.tuples(lengths, lengths, lengths)
points = st.tuples(lengths, lengths)
digests = st.text("0123456789abcdef", min_size=64, max_size=64)
part_types = st.builds(PartType, names, names, names)
parts = st.builds(Part, part_types, names)
machines = st.builds(Machine, names, names)
tools = st.builds(Tool, st.none() | st.integers(0, 99), names, st.none() | lengths, st.none() | lengths)
edges = st.builds(Edge, tools, names, names)
settings_of_edges = st.builds(Setting, edges, times)
programs = st.builds(Program, names, names, digests, st.sampled_from(["mm", "inch", None]))
touches = st.builds(Touch, names, points, st.none() | names, st.none() | points, st.none() | lengths)
readings = st.builds(
    Reading,
    characteristic=names,
    quantity=st.sampled_from(Quantity),
    actual=lengths,
    nominal=st.none() | lengths,
    lower_limit=st.none() | lengths,
    upper_limit=st.none() | lengths,
    feature=names,
    other=names,
    axis=st.sampled_from(["", "x", "y", "z"]),
    place_mm=st.lists(lengths, max_size=3).map(tuple),
    repeat=st.integers(1, 99),
    standard_u=st.none() | lengths,
    measured_at=st.none() | times,
    temperature_c=st.none() | lengths,
    line=st.none() | st.integers(1, 10**6),
)
cmm_points = st.builds(CmmPoint, vectors, st.none() | vectors, st.none() | vectors, names)
inspections = st.builds(
    Inspection,
    parts,
    st.sampled_from(["touches", "readings", "CMM points", "readings and CMM points"]),
    digests,
    st.integers(0, 10**6),
    st.lists(st.one_of(touches, readings, cmm_points), max_size=3).map(tuple),
    names,
    names,
    st.sampled_from(["part", "machine", "device"]),
    st.none() | times,
    lengths,
    st.none() | names,
    st.dictionaries(names, lengths, max_size=3),
)
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | names,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3),
)
options = st.dictionaries(names, anything, max_size=3)
counts = st.integers(1, 99)
rows = st.builds(
    TableRow,
    names,
    st.sampled_from(["geometry", "wear"]),
    st.none() | names,
    st.none() | names,
    st.sampled_from(["mm", "inch"]),
)
held = st.builds(HeldTool, names, counts, st.none() | rows)
tool_offsets = st.builds(
    ToolOffset,
    counts,
    lengths,
    lengths,
    st.booleans(),
    st.sampled_from(["radius", "diameter"]),
    st.sampled_from(["mm", "inch"]),
    digests,
    held,
    counts,
    st.lists(names, max_size=2).map(tuple),
)
records = st.builds(
    Record,
    names,
    times.map(datetime.isoformat),
    names,
    names,
    st.dictionaries(names, digests, max_size=3),
    options,
    options,
    st.lists(names, max_size=2),
    st.lists(st.builds(ChangedWord, st.integers(1, 10**6), st.integers(1, 200), names, names), max_size=2),
    st.lists(st.builds(Component, names, names, lengths, lengths, lengths), max_size=2),
    product=st.sampled_from(Product),
    edits=st.none() | st.integers(0, 10**6),
    part_type=st.none() | part_types,
    machine=st.none() | machines,
    tool=st.none() | tools,
    program=st.none() | programs,
    inspections=st.lists(inspections, max_size=2).map(tuple),
    tool_offset=st.none() | tool_offsets,
)
values = st.one_of(
    *(part_types, parts, machines, tools, edges, settings_of_edges, programs),
    *(inspections, touches, readings, cmm_points, records, rows, held, tool_offsets),
)
"""Every value of the domain but corrections."""


def sealed(text: str) -> str:
    """A record's file after an edit, with the hash of what it states now."""
    content = json.loads(text)
    return json.dumps(content | {CONTENT: content_sha256(content)}, indent=2, ensure_ascii=False)
