"""Every way in which outputs are refused."""

import os
import sys
import tempfile
import unittest.mock
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.outputs import write_all
from trueloop.report.pdf import as_pdf
from trueloop.report.shape import to_frame
from trueloop.report.style import shown


def _over_an_input() -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_all(Path(folder), [("finish.nc", b"new")], [Path(folder) / "finish.nc"])


def _into_a_file() -> None:
    with tempfile.NamedTemporaryFile() as file:
        write_all(Path(file.name), [("finish.nc", b"new")])


def _twice() -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_all(Path(folder), [("t.cma", b"axis"), ("t.cma", b"table")])


def _without_plotly() -> None:
    """A process in which Plotly cannot be imported."""
    with unittest.mock.patch.dict(sys.modules, {"plotly.graph_objects": None}):
        shown({})


def _without_pandas_and_polars() -> None:
    """A process in which neither can be imported."""
    with unittest.mock.patch.dict(sys.modules, {"pandas": None, "polars": None}):
        to_frame([])


def _without_a_browser() -> None:
    with unittest.mock.patch.dict(os.environ, {"TRUELOOP_BROWSER": "no-browser-of-this-name"}):
        as_pdf("<p>page</p>")


def _browser_that_prints_nothing() -> None:
    """A program that ends without a word."""
    with unittest.mock.patch.dict(os.environ, {"TRUELOOP_BROWSER": "true"}):
        as_pdf("<p>page</p>")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.OUT_INPUT: _over_an_input,
    Code.OUT_FOLDER: _into_a_file,
    Code.OUT_TWICE: _twice,
    Code.OUT_FIGURE: _without_plotly,
    Code.OUT_FRAME: _without_pandas_and_polars,
    Code.OUT_BROWSER: _without_a_browser,
    Code.OUT_PDF: _browser_that_prints_nothing,
}
