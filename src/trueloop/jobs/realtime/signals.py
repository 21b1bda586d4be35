"""The signals of a running corrector: from a configuration to the component, or to a check of its sources."""

import hashlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from trueloop.controllers.linuxcnc.realtime.signals import checking, component
from trueloop.controllers.linuxcnc.realtime.signals.hal_pins import linuxcnc_module
from trueloop.controllers.linuxcnc.realtime.signals.setup import Setup, setup_of
from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.realtime.signals_toml import HINT, SignalsFile, read_signals
from trueloop.formats.tables.model_file import read_model
from trueloop.formats.toml_tables import Located
from trueloop.machine.model.model import MachineModel
from trueloop.realtime.image import Image, Signal


@dataclass(frozen=True)
class Prepared:
    """A configuration with what it names."""

    image_file: Path
    image: Image
    setup: Setup


def prepared(path: Path) -> Prepared:
    """Reads a configuration, the image and the model. Raises RTC-SOURCE, RTC-IMAGE and as reading a model does."""
    file = read_signals(path)
    with file.at("image"):
        image_file = path.parent / file.model.image
        image = read_image(image_file)
    model = _model(file, image)
    lags, units = (model.lags, model.units) if model else ((), {})
    return Prepared(image_file, image, setup_of(file, _wanted(image), lags, units))


def check(path: Path, wait_s: float) -> list[checking.Checked]:
    """Reads every source once. Raises as `prepared`."""
    return checking.checked(prepared(path).setup, wait_s, lambda: None)


def run(path: Path, stop: threading.Event, say: Callable[[str], None]) -> None:
    """Runs the component until `stop`. Raises as `prepared`, and RTC-CONNECTION."""
    hal, linuxcnc = linuxcnc_module("_hal"), linuxcnc_module("linuxcnc")
    given = prepared(path)
    component.run(given.setup, hal, linuxcnc, ImageProgram(given), stop, say)


class ImageProgram:
    """The hash of the program that the image's table belongs to, read anew when the image's file changes."""

    def __init__(self, given: Prepared) -> None:
        self._file, self._image = given.image_file, given.image
        self._seen = self._identity()

    def __call__(self) -> str:
        """Raises RTC-SOURCE where the image's signals are others than those that the pins carry.

        A file that is not an image changes nothing: the corrector refuses it too.
        """
        identity = self._identity()
        if identity is not None and identity != self._seen:
            self._seen = identity
            try:
                image = read_image(self._file)
            except TrueloopError:
                return self._image.identity.program_sha256
            self._take(image)
        return self._image.identity.program_sha256

    def _identity(self) -> tuple[int, int, int] | None:
        """None where there is no file: one is being put in its place."""
        try:
            of = self._file.stat()
        except OSError:
            return None
        return of.st_ino, of.st_size, of.st_mtime_ns

    def _take(self, image: Image) -> None:
        if _wanted(image) != _wanted(self._image):
            raise Code.RTC_SOURCE.refusal(
                f"the signals of {str(self._file)!r} have changed: {len(_wanted(self._image))} were given, "
                f"{len(_wanted(image))} are wanted, with their order, ranges and names",
                hint="start LinuxCNC anew, so that component and signals agree on which pin carries which signal",
            )
        self._image = image


def _wanted(image: Image) -> tuple[Signal, ...]:
    return image.bank.signals if image.bank else ()


def _model(file: Located[SignalsFile], image: Image) -> MachineModel | None:
    """The model that the image was made from, for its lags and units. Raises RTC-SOURCE for another one."""
    if not file.model.model:
        return None
    with file.at("model"):
        path = file.path.parent / file.model.model
        found = hashlib.sha256(read_input(path, Code.RTC_SOURCE, hint=HINT)).hexdigest()
        if found != image.identity.model_sha256:
            raise Code.RTC_SOURCE.refusal(
                f"{path.name!r} is not the model that the image was made from: its SHA-256 begins with {found[:12]}, "
                f"that in the image with {image.identity.model_sha256[:12] or 'nothing'}",
                hint="make the image anew with `trueloop realtime image`, or name its model",
            )
        return read_model(path)
