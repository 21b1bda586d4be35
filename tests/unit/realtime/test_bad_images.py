"""Files that are no image are refused by name."""

from pathlib import Path

import pytest

from tests.support.bad_images import BAD, PROGRAM, SERIAL, good_image, write_bad_images
from tests.support.refusals import refused
from trueloop._core import realtime_names
from trueloop.errors import Code
from trueloop.formats.realtime.image_file import image_to_bytes, read_image


def read(path: Path) -> object:
    return read_image(path, serial=SERIAL, program=PROGRAM)


def test_the_good_one_is_read(tmp_path: Path) -> None:
    path = tmp_path / "good.img"
    path.write_bytes(image_to_bytes(good_image()))
    assert read(path) == good_image()


@pytest.mark.parametrize("what", ["no file", *BAD])
def test_a_bad_one_is_refused_by_name(what: str, tmp_path: Path) -> None:
    path, refusal = write_bad_images(tmp_path)[what]
    said = refused(read, path)
    assert (said.code, said.values["refusal"], said.place.file) == (Code.RTC_IMAGE, refusal, str(path))


def test_a_file_of_more_than_64_mb_is_too_long(tmp_path: Path) -> None:
    """Whatever its head says; the file is sparse."""
    path = tmp_path / "long.img"
    good = image_to_bytes(good_image())
    size = (64 << 20) + 8
    with path.open("wb") as file:
        file.write(good[:16] + size.to_bytes(8, "little") + good[24:])
        file.truncate(size)
    assert refused(read, path).values["refusal"] == "long"


def test_a_folder_is_no_image(tmp_path: Path) -> None:
    assert refused(read, tmp_path).values["refusal"] == "missing"


def test_without_a_serial_and_a_program_any_machine_s_will_do(tmp_path: Path) -> None:
    files = write_bad_images(tmp_path)
    for what in ("another machine", "a table for another program"):
        assert read_image(files[what][0]).blocks == good_image().blocks


def test_every_refusal_has_a_bad_image() -> None:
    """Those of the reader in the servo thread, but `none`; `missing` is no content."""
    known = {name for _, name, _ in realtime_names()["refusals"]}
    assert known - {"none", "missing"} == {refusal for refusal, _ in BAD.values()}
