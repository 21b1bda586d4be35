"""Every way in which stored values are refused."""

from collections.abc import Callable

from trueloop.domain.codec import Codec
from trueloop.errors import Code

PRODUCERS: dict[Code, Callable[[], object]] = {Code.VAL_FORM: lambda: Codec.of().from_json('{"type": "Shift"}', object)}
