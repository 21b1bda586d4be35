#!/usr/bin/env bash
# Builds the wheel of each system into dist/ and checks that it uses Python's stable interface alone: `make wheels`.
# Zig links for Linux and macOS, Debian's mingw-w64 for Windows.
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"
command -v rustup > /dev/null || { echo "wheels of other systems need rustup, which brings Rust's library for them: https://rustup.rs" >&2; exit 1; }
while read -r target options; do
    echo "building for $target"
    rustup --quiet target add "$target" 2> /dev/null
    # shellcheck disable=SC2086 # options are words
    maturin build --release --locked --quiet --interpreter python3.11 --out dist --target "$target" $options
done << END
x86_64-unknown-linux-gnu --zig --compatibility manylinux_2_28
aarch64-unknown-linux-gnu --zig --compatibility manylinux_2_28
x86_64-unknown-linux-musl --zig --compatibility musllinux_1_2
x86_64-apple-darwin --zig
aarch64-apple-darwin --zig
x86_64-pc-windows-gnu
END
abi3audit --strict dist/*-abi3-*.whl
ls dist/*.whl
