"""The adapter's data items, and the device model that describes them to an agent, from one list."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import groupby
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from trueloop.errors import Code, TrueloopError

UNAVAILABLE: Final = "UNAVAILABLE"


@dataclass(frozen=True)
class Condition:
    """NORMAL, WARNING, FAULT or UNAVAILABLE; the control's own code and words for anything that is not normal."""

    level: str = "NORMAL"
    code: str = ""
    text: str = ""


Value = str | Condition
NONE: Final = Condition(UNAVAILABLE)


def lines(values: Mapping[str, Value], at: datetime) -> Iterator[str]:
    """Yields all plain values in one line, then a line for each condition."""
    stamp = f"{at.astimezone(UTC):%Y-%m-%dT%H:%M:%S}.{at.microsecond:06d}Z"
    plain = [f"{key}|{escaped(value)}" for key, value in values.items() if isinstance(value, str)]
    if plain:
        yield f"{stamp}|{'|'.join(plain)}\n"
    for key, value in values.items():
        if isinstance(value, Condition):
            yield f"{stamp}|{key}|{value.level}|{escaped(value.code)}|||{escaped(value.text)}\n"


def escaped(text: str) -> str:
    """Puts a text on one line, as one field: with a bar in it quoted, the bar behind a backslash, as agents undo it."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if "|" not in line:
        return line.lstrip('"')  # a quote at the beginning opens a field that nothing would close
    inner = line.replace('"', "'").replace("|", "\\|")
    return f'"{inner}"'


def number(value: float, decimals: int) -> str:
    """Formats a number without an exponent and without a minus before zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


VERSION: Final = "1.7"
NAMESPACE: Final = f"urn:mtconnect.org:MTConnectDevices:{VERSION}"
LINEAR: Final = "XYZUVW"
AXES: Final = "XYZABCUVW"
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_-]{0,63}")


@dataclass(frozen=True)
class Machine:
    """The items of a machine. `temperatures` (°C), `corrections` (mm, by axis) and `part_count` are HAL pins."""

    device: str = "linuxcnc"
    axes: str = "XZ"
    temperatures: Mapping[str, str] = field(default_factory=dict)
    corrections: Mapping[str, str] = field(default_factory=dict)
    part_count: str = ""

    def __post_init__(self) -> None:
        """Raises MTC-NAME for a name that is none, or an axis that LinuxCNC does not have."""
        for name in (self.device, *self.temperatures):
            if not _NAME.fullmatch(name):
                raise _refused(name, "is no name", "letters, digits, _ and -, a letter first: it becomes an id in XML")
        if not self.axes or set(self.axes) - set(AXES) or len(set(self.axes)) < len(self.axes):
            raise _refused(self.axes, "are no axes", f"letters of {AXES}, each once, such as XZ")
        for axis in self.corrections:
            if axis not in self.axes:
                raise _refused(axis, f"is not among the axes {self.axes}", "give the axes: --axes")


@dataclass(frozen=True)
class Item:
    """A data item: its key in SHDR is its id in the model. `of`: the component it belongs to and that one's kind."""

    key: str
    type: str
    category: str = "EVENT"
    sub_type: str = ""
    units: str = ""
    of: tuple[str, str] = ("Controller", "controller")

    @property
    def condition(self) -> bool:
        """Returns whether it is a condition (normal or a fault), not a value."""
        return self.category == "CONDITION"


def items(machine: Machine) -> list[Item]:
    """Returns all items of a machine, those of one component together."""
    return [
        Item("avail", "AVAILABILITY", of=("Device", "")),
        *(
            Item(f"temp_{name}", "TEMPERATURE", "SAMPLE", units="CELSIUS", of=("Device", ""))
            for name in machine.temperatures
        ),
        *(item for axis in machine.axes for item in _of_axis(axis, axis in machine.corrections)),
        Item(
            key="S1speed",
            type="ROTARY_VELOCITY",
            category="SAMPLE",
            sub_type="COMMANDED",
            units="REVOLUTION/MINUTE",
            of=("Rotary", "S1"),
        ),
        Item("estop", "EMERGENCY_STOP"),
        Item("system", "SYSTEM", "CONDITION"),
        *(_of_path()),
    ]


def _of_axis(axis: str, corrected: bool) -> Iterator[Item]:
    straight = axis in LINEAR
    of = ("Linear" if straight else "Rotary", axis)
    kind, units = ("POSITION", "MILLIMETER") if straight else ("ANGLE", "DEGREE")
    yield Item(key=f"{axis}pos", type=kind, category="SAMPLE", sub_type="ACTUAL", units=units, of=of)
    if corrected:
        yield Item(f"{axis}corr", "DISPLACEMENT", "SAMPLE", units="MILLIMETER", of=of)


def _of_path() -> Iterator[Item]:
    of = ("Path", "path")
    for key, kind, sub_type in (
        ("execution", "EXECUTION", ""),
        ("mode", "CONTROLLER_MODE", ""),
        ("program", "PROGRAM", ""),
        ("line", "LINE_NUMBER", "ABSOLUTE"),
        ("part_count", "PART_COUNT", ""),
        ("part_id", "PART_ID", ""),
    ):
        yield Item(key, kind, sub_type=sub_type, of=of)
    yield Item(key="feed", type="PATH_FEEDRATE", category="SAMPLE", sub_type="ACTUAL", units="MILLIMETER/SECOND", of=of)


def devices_xml(machine: Machine) -> bytes:
    """Makes `Devices.xml`, with which an agent is started."""
    root = Element("MTConnectDevices", {"xmlns": NAMESPACE})
    header = {"creationTime": "1970-01-01T00:00:00Z", "sender": "trueloop", "instanceId": "0", "version": VERSION}
    SubElement(root, "Header", header | {"bufferSize": "1", "assetBufferSize": "1", "assetCount": "0"})
    name = machine.device
    device = SubElement(SubElement(root, "Devices"), "Device", {"id": f"d_{name}", "uuid": name, "name": name})
    SubElement(device, "Description").text = "LinuxCNC, told by trueloop"
    places: dict[str, Element] = {}
    for of, group in groupby(items(machine), key=lambda item: item.of):
        data = SubElement(_component(device, of, places), "DataItems")
        for item in group:
            SubElement(data, "DataItem", _attributes(item))
    SubElement(places["Controller"], "Components").append(places["Path"])
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _component(device: Element, of: tuple[str, str], places: dict[str, Element]) -> Element:
    """The element of a component; axes are below `Axes`, all others below the device's `Components`."""
    kind, name = of
    if kind == "Device":
        return device
    found = device.find("Components")
    below = SubElement(device, "Components") if found is None else found
    if kind in ("Linear", "Rotary"):
        axes = below.find("Axes")
        if axes is None:
            axes = SubElement(below, "Axes", {"id": "axes", "name": "base"})
            SubElement(axes, "Components")
        below = axes[0]
    places[kind] = made = Element(kind, {"id": f"c_{name}", "name": name})
    if kind != "Path":
        below.append(made)
    return made


def _attributes(item: Item) -> dict[str, str]:
    given = {"category": item.category, "id": item.key, "name": item.key, "type": item.type}
    given |= {"subType": item.sub_type} if item.sub_type else {}
    given |= {"units": item.units} if item.units else {}
    return given | ({"coordinateSystem": "MACHINE"} if item.type == "POSITION" else {})


def _refused(name: str, why: str, hint: str) -> TrueloopError:
    return Code.MTC_NAME.refusal(f"{name!r} {why}", hint=hint, values={"name": name})
