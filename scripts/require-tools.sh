#!/usr/bin/env bash
# require-tools.sh PYTHON — what must be there before anything is built; says what is missing and how to get it.
set -euo pipefail
python=$1
cd "$(dirname "$0")/.."

fail() {
    printf 'trueloop cannot be set up: %s\n' "$1" >&2
    exit 1
}

at_least() { # WANTED FOUND
    [ "$(printf '%s\n' "$1" "$2" | sort -V | head -n 1)" = "$1" ]
}

command -v "$python" >/dev/null || fail "$python is missing. On Debian run as root:  apt-get install -y python3 python3-venv"
version=$("$python" -c 'import platform; print(platform.python_version())')
at_least 3.11 "$version" || fail "Python 3.11 or newer is needed, $python is $version. Name another:  make PYTHON=python3.12 …"
"$python" -c 'import ensurepip, venv' 2>/dev/null || scripts/debian-packages.sh python3-venv || true
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "$python makes no virtual environments. On Debian run as root:  apt-get install -y python3-venv"

command -v cargo >/dev/null || fail "cargo is missing. Install a Rust toolchain: https://rustup.rs"
wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
version=$(cargo --version | cut -d ' ' -f 2)
at_least "$wanted" "$version" || fail "Rust $wanted or newer is needed, cargo is $version. With rustup run:  rustup update"
command -v cc >/dev/null || scripts/debian-packages.sh gcc libc6-dev || true
command -v cc >/dev/null || fail "Rust needs a C linker, cc. On Debian run as root:  apt-get install -y gcc libc6-dev"
