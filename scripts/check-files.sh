#!/usr/bin/env bash
# What no linter sees: lock files name the public registries alone, and no committed file knows one machine's folders, or
# holds both sides of a merge.
set -euo pipefail
cd "$(dirname "$0")/.."
status=0

if grep -q '"resolved"' web/package-lock.json; then
    echo "web/package-lock.json holds addresses: it is written by npm with web/.npmrc, which leaves them out" >&2
    status=1
fi

hosts=$(grep -ohE '[a-z+]+://[^/" ]+' uv.lock Cargo.lock | sed 's/^[a-z]*+//' | sort -u |
    grep -vxE 'https://(pypi\.org|files\.pythonhosted\.org|github\.com|index\.crates\.io)' || true)
if [ -n "$hosts" ]; then
    printf 'a lock file names a host that is not a public registry:\n%s\n' "$hosts" >&2
    status=1
fi

paths=$(git grep -nIE '(^|[^[:alnum:]_.$}])/(home|root|Users|wor[k])/' || true)
if [ -n "$paths" ]; then
    printf 'a committed file names a folder of one machine:\n%s\n' "$paths" >&2
    status=1
fi

marks=$(git grep -nIE '^[[:space:]]*(<{7}|>{7}) ' || true)
if [ -n "$marks" ]; then
    printf 'a merge was left half done:\n%s\n' "$marks" >&2
    status=1
fi
exit $status
