"""The file of `trueloop realtime signals`: sources, and the place of each signal of the image in them."""

from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import Field

from trueloop.errors import Code
from trueloop.formats.toml_tables import Count, Finite, Located, Moment, NotNegative, Positive, Table, read_located

HINT: Final = "docs/realtime-signals.md shows every table and key"


class SerialTable(Table):
    """A serial port whose device sends lines."""

    port: str
    """Such as `/dev/serial/by-id/…`, which stays the same when another device is plugged in."""
    baud: Annotated[int, Field(ge=50, le=4_000_000, strict=True)] = 9600
    """Bits per second; 8 bits, no parity."""
    separator: Annotated[str, Field(min_length=1)] = ","
    """Between the columns of a line."""
    ask: str = ""
    """Sent to a device that speaks only when asked, `"R\\r\\n"`."""
    every_s: Positive = 1.0
    """How often it is asked."""


class OneWireTable(Table):
    """A 1-Wire bus as the Linux kernel shows it."""

    folder: str = "/sys/bus/w1/devices"
    """Where the kernel shows the bus."""
    every_s: Positive = 1.0
    """How often each sensor is read; a conversion takes 0.75 s."""


class MqttTable(Table):
    """An MQTT broker. User and password come from the environment: this file is copied and sent."""

    host: Annotated[str, Field(min_length=1)]
    """The broker's address."""
    port: Annotated[int, Field(ge=1, le=65535, strict=True)] | None = None
    """Left out, 1883, with TLS 8883."""
    user_env: str = ""
    """The environment variable that holds the user's name."""
    password_env: str = ""
    """The environment variable that holds the password."""
    tls: Annotated[bool, Field(strict=True)] = False
    """The broker's certificate is checked."""
    ca_file: str = ""
    """Authorities that may have signed it; left out, those of the system."""
    skew_s: NotNegative = 1.0
    """How far the clocks of sender and control may disagree; a time stamp further in the future is refused."""


class MtConnectTable(Table):
    """An MTConnect agent."""

    url: str
    """Up to the device, `http://10.0.0.7:5000/lathe`: `/current` is added."""
    every_s: Positive = 1.0
    """How often it is asked."""
    held: Annotated[bool, Field(strict=True)] = False
    """An agent passes on only what changes. `true`: what it says holds until it says UNAVAILABLE; only with an adapter
    that says so of a sensor that is gone. `false`: ages count from the time stamp."""
    skew_s: NotNegative = 1.0
    """How far ahead of the agent's clock the adapter's may be."""


class ReplayTable(Table):
    """A log played again: `time_s`, `T1_degC`, `spindle_rpm` …, straight between its rows."""

    file: str
    """The log, CSV."""
    start_s: Finite | None = None
    """Where in the log it begins; what is before is the past that lags start from. Left out, at the first row."""
    speed: Positive = 1.0
    """Times real time: the lags of all signals then run as fast."""


class SignalTable(Table):
    """Where one signal comes from, by the name that it has in the image."""

    source: str
    """The name of a source below; `"spindle"`: the pin spindle-speed; `"constant"`: `value`, for trials."""
    unit: Literal["degC", "degF", "rpm"] | None = None
    """Of what the source says: `"degC"`, `"degF"` (made °C), `"rpm"`. A replayed log, a 1-Wire sensor and the spindle
    say it themselves."""
    pattern: str | None = None
    """Serial: a regular expression whose first group is the number."""
    column: Count | None = None
    """Serial: the column of the number in a line, from 1."""
    device: str | None = None
    """1-Wire: the sensor's folder, `28-00000a1b2c3d`."""
    topic: str | None = None
    """MQTT: where it is published, without wildcards."""
    path: str | None = None
    """MQTT: where in a JSON message the number is, `sensors.0.value`; left out, the message is the number."""
    time_path: str | None = None
    """MQTT: where in it the time is at which it was read, ISO 8601 or s since 1970. Retained messages need it."""
    qos: Literal[0, 1, 2] | None = None
    """MQTT: quality of service of the subscription."""
    item: str | None = None
    """MTConnect: the `dataItemId`."""
    recorded: str | None = None
    """Replay: the name in the log, without unit; left out, the signal's own."""
    value: Finite | None = None
    """Constant: the value."""


class SignalsFile(Table):
    """A whole configuration. Files are named from the folder that it is in."""

    image: str
    """The image that the component has loaded: it says which signals, in which order."""
    model: str = ""
    """The machine model that the image was made from; needed where the image has lags."""
    log: str = ""
    """The log of all that was read, CSV. Lags start from it after a restart; `-t` of `trueloop machine compensate`
    reads it."""
    log_rows: Annotated[int, Field(ge=100, le=10_000_000, strict=True)] = 100_000
    """Then the log is begun anew with its last rows, and what was before is kept beside it, as `NAME.1.csv`."""
    cycle_hz: Annotated[float, Field(ge=1, le=100, strict=True)] = 10.0
    """How often pins are set and the heartbeat counts."""
    every_s: Annotated[float, Field(ge=0.05, le=1, strict=True)] = 1.0
    """How often lags are computed and a row is logged."""
    stale_s: Positive = 10.0
    """An older reading is taken into no lag and no row of the log."""
    settle: Annotated[float, Field(ge=3, le=20, strict=True)] = 5.0
    """After how many time constants a lag counts as known whatever was before."""
    gap: Annotated[float, Field(gt=0, le=1, strict=True)] = 0.2
    """A pause of a sensor longer than this share of its lag's time constant begins the lag anew."""
    equilibrium: Moment | None = None
    """When the machine was in equilibrium by the operator's word, `2026-11-23T06:00:00`: lags that start there are
    known at once."""
    constants: Annotated[bool, Field(strict=True)] = False
    """Signals may be constants: for trials only, because nothing is measured then."""
    signals: dict[str, SignalTable] = Field(default_factory=dict)
    serial: dict[str, SerialTable] = Field(default_factory=dict)
    one_wire: dict[str, OneWireTable] = Field(default_factory=dict)
    mqtt: dict[str, MqttTable] = Field(default_factory=dict)
    mtconnect: dict[str, MtConnectTable] = Field(default_factory=dict)
    replay: dict[str, ReplayTable] = Field(default_factory=dict)


def read_signals(path: Path) -> Located[SignalsFile]:
    """The configuration. Raises RTC-SOURCE, with the line, for a key that is unknown, missing or wrong."""
    return read_located(path, SignalsFile, Code.RTC_SOURCE, hint=HINT)
