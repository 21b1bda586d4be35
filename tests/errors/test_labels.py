"""Every way in which labels are refused."""

from collections.abc import Callable

from trueloop.domain.labels import contradictions, read_label
from trueloop.domain.part import PartType
from trueloop.errors import Code

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.LAB_FORM: lambda: read_label("1411-A2-X1"),
    Code.LAB_LINK: lambda: contradictions(read_label("1411-A2-P1.560"), PartType("1411"), "561"),
}
