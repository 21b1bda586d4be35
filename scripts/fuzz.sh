#!/usr/bin/env bash
# Fuzzes the reader, runner and editor of NC programs, and the reader of real-time images: fuzz.sh TIME, in seconds, shared by
# the targets. The programs of tests/programs and a good image are the seeds. cargo-fuzz is installed where it is missing; no
# sanitizer, so the stable toolchain does.
set -euo pipefail
time=$1
cd "$(dirname "$0")/.."
cargo fuzz --version > /dev/null 2>&1 || cargo install --quiet --locked cargo-fuzz
export RUSTC_BOOTSTRAP=1 # the coverage counters are an unstable flag

declare -A seeds=([nc-program]=$PWD/tests/programs [rtec]=$PWD/crates/rtec/fuzz/seeds)
targets=() # crate/target
for crate in nc-program rtec; do
    cd "crates/$crate"
    cargo fuzz build --sanitizer none > /dev/null 2>&1 || cargo fuzz build --sanitizer none # a failure is told
    mapfile -t -O ${#targets[@]} targets < <(cargo fuzz list | sed "s|^|$crate/|")
    cd ../..
done
for each in "${targets[@]}"; do
    crate=${each%/*} target=${each#*/}
    cd "crates/$crate"
    mkdir -p "fuzz/corpus/$target"
    echo "fuzzing $target of $crate"
    log=$(mktemp)
    cargo fuzz run --sanitizer none "$target" "fuzz/corpus/$target" "${seeds[$crate]}" -- \
        -max_total_time=$((time / ${#targets[@]})) -timeout=10 -max_len=4096 -print_final_stats=1 > "$log" 2>&1 ||
        { tail -n 40 "$log" >&2; exit 1; }
    grep -E 'stat::number_of_executed_units|^Done' "$log"
    cd ../..
done
echo "correcting up to 1,000 finish programs drawn by chance"
.venv/bin/python -m tests.loops.test_everyday_programs 1000 "$time"
