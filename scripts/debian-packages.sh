#!/usr/bin/env bash
# debian-packages.sh PACKAGE ... — install what is missing where that is allowed, else print the line to run and fail.
set -euo pipefail

command -v dpkg-query >/dev/null || {
    echo "the packages $* of Debian 12 are needed; this system has no dpkg" >&2
    exit 1
}
missing=()
for package in "$@"; do
    status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=()
elif sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    echo "Debian packages are needed; run:" >&2
    echo "  sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}" >&2
    exit 1
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=600 "$@" </dev/null >"$log" 2>&1 || {
        cat "$log" >&2
        exit 1
    }
}
echo "installing ${missing[*]}"
apt update
apt install -y --no-install-recommends "${missing[@]}"
