"""What is linked into LinuxCNC's servo thread: nothing in it panics, asks for memory or uses a deep stack."""

import re
import subprocess
from pathlib import Path

import pytest

from trueloop import _core

FUNCTIONS = re.findall(r"^\w[\w ]*[ *](rtec_\w+)\(", _core.realtime_header(), re.MULTILINE)
FROM_C = {"memcpy", "memset", "memmove", "memcmp", "bcmp", "strlen"}
"""What a compiler asks of any C library."""
FORBIDDEN = re.compile(r"panic|unwind|unwrap_failed|expect_failed|alloc|bounds")


@pytest.fixture(scope="module")
def linked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The object file, and what the functions of the header reach in it."""
    folder = tmp_path_factory.mktemp("linked")
    (folder / "rtec.o").write_bytes(_core.realtime_library())
    asked = [part for name in FUNCTIONS for part in ("-u", name)]
    subprocess.run(["ld", "-r", "--gc-sections", *asked, "-o", "linked.o", "rtec.o"], cwd=folder, check=True)
    return folder


def symbols(path: Path, *options: str) -> set[str]:
    told = subprocess.run(["nm", "-P", *options, path], check=True, capture_output=True, text=True).stdout
    return {line.split()[0] for line in told.splitlines()}


def test_it_has_the_functions_of_the_header_and_asks_nothing_but_copies_of_c(linked: Path) -> None:
    assert len(FUNCTIONS) >= 7
    assert symbols(linked / "linked.o", "--defined-only", "--extern-only") == set(FUNCTIONS)
    assert symbols(linked / "linked.o", "--undefined-only") <= FROM_C


def test_nothing_that_is_reached_panics_or_asks_for_memory(linked: Path) -> None:
    assert not {name for name in symbols(linked / "linked.o") if FORBIDDEN.search(name)}


def test_a_panic_that_is_reached_would_be_seen(tmp_path: Path) -> None:
    """The handler asks for a function that is nowhere: whatever may panic does so too, however it was inlined."""
    (tmp_path / "panics.rs").write_text(PANICS)
    build = [
        "rustc",
        "--crate-type",
        "staticlib",
        "-O",
        "-C",
        "panic=abort",
        "-C",
        "lto=fat",
        "--emit",
        "obj=panics.o,link",
    ]
    subprocess.run([*build, "panics.rs"], cwd=tmp_path, check=True)
    assert any("panic" in name for name in symbols(tmp_path / "panics.o", "--undefined-only"))


PANICS = """
#![no_std]
extern "C" { fn rtec_would_panic() -> !; }
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! { unsafe { rtec_would_panic() } }
#[no_mangle]
pub extern "C" fn one_of(numbers: &[f64; 3], k: usize) -> f64 { numbers[k] }
"""


def test_a_component_that_is_linked_with_it_lacks_nothing(linked: Path) -> None:
    """As a shared object, the way halcompile makes components: whatever is missing would be missing on the machine."""
    (linked / "rtec.h").write_text(_core.realtime_header())
    calls = "\n".join(f"void *use_{name}(void) {{ return (void *){name}; }}" for name in FUNCTIONS)
    (linked / "component.c").write_text(f'#include "rtec.h"\n{calls}\n')
    link = ["gcc", "-shared", "-fPIC", "-Wl,--gc-sections", "-Wl,--no-undefined", "component.c", "rtec.o"]
    subprocess.run([*link, "-o", "component.so"], cwd=linked, check=True)
    held = symbols(linked / "component.so")
    assert set(FUNCTIONS) <= held
    assert not {name for name in held if FORBIDDEN.search(name)}


@pytest.mark.parametrize(("function", "most_bytes"), [("rtec_step", 8 << 10), ("rtec_image_init", 64 << 10)])
def test_the_stack_is_bounded(linked: Path, function: str, most_bytes: int) -> None:
    """By what each function that is reached takes; none calls itself, so the sum of all bounds the depth."""
    code = subprocess.run(
        ["objdump", "-dr", "--no-show-raw-insn", "linked.o"], cwd=linked, check=True, capture_output=True, text=True
    ).stdout
    bodies = dict(re.findall(r"^[0-9a-f]+ <([^>]+)>:\n(.*?)(?:\n\n|\Z)", code, re.MULTILINE | re.DOTALL))
    taken = 0
    waiting, reached = [function], set[str]()
    while waiting:
        name = waiting.pop()
        reached.add(name)
        pushed = 8 * (1 + len(re.findall(r"\spush\s", bodies[name])))
        taken += pushed + sum(int(size, 16) for size in re.findall(r"sub\s+\$0x([0-9a-f]{1,7}),%rsp", bodies[name]))
        called = set(re.findall(r"R_X86_64_(?:PLT32|PC32|GOTPCREL\w*)\s+([\w.$]+)-0x4", bodies[name]))
        assert name not in called
        waiting += (called & bodies.keys()) - reached - set(waiting)
    assert reached >= {function}
    assert taken <= most_bytes
