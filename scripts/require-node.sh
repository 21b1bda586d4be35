#!/usr/bin/env bash
# Node 20.19 or newer and npm, which the pages are built with; installed where that is allowed and the system has them.
set -euo pipefail
cd "$(dirname "$0")/.."

found() {
    command -v npm >/dev/null && node --eval '
        const [major, minor] = process.versions.node.split(".").map(Number);
        process.exit(major > 20 || (major === 20 && minor >= 19) ? 0 : 1)' 2>/dev/null
}
found || scripts/debian-packages.sh nodejs npm
found || {
    echo "the pages need Node 20.19 or newer; this system has $(node --version 2>/dev/null || echo none): https://nodejs.org" >&2
    exit 1
}
