"""Every way in which MTConnect is refused."""

import socket
from collections.abc import Callable

from trueloop.controllers.mtconnect.agent import read
from trueloop.controllers.mtconnect.items import Machine
from trueloop.controllers.mtconnect.run import listening
from trueloop.errors import Code, TrueloopError


def _taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        try:
            listening("127.0.0.1", port := other.getsockname()[1])
        except TrueloopError as error:  # the port is another one each time
            message = error.message.replace(str(port), "7878")
            raise TrueloopError(error.code, message, hint=error.hint, values={**error.values, "port": 7878.0}) from None


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MTC_NAME: lambda: Machine(temperatures={"spindle 1": "a.b"}),
    Code.MTC_ADDRESS: _taken,
    Code.MTC_AGENT: lambda: list(read("10.0.0.7:5000", lambda: True, print)),
}
