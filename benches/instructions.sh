#!/usr/bin/env bash
# Counts the instructions of one small render with each method and compares them with benches/instructions.txt.
#
#   benches/instructions.sh            fails where a count is more than 5 % above the stored one, or below it
#   benches/instructions.sh --update   stores what it counts, with the compiler's version
#
# Counts do not depend on what else the machine does. They do depend on the compiler, and need valgrind and a processor with
# AVX2: without the compiler of the stored counts, or one of these, it says so and passes.
set -euo pipefail
cd "$(dirname "$0")/.."
stored=benches/instructions.txt
tolerance=5

skip() {
    echo "INSTRUCTION COUNTS SKIPPED: $1." >&2
    exit 0
}

compiler=$(rustc --version)
counted_with=$(sed -n 's/^# compiler: //p' "$stored")
command -v valgrind >/dev/null || skip "valgrind is not installed"
grep -qw avx2 /proc/cpuinfo 2>/dev/null || skip "the processor has no AVX2, for which the stored counts are"
if [[ ${1:-} != --update && $compiler != "$counted_with" ]]; then
    skip "the compiler is $compiler, the stored counts are of $counted_with; benches/instructions.sh --update stores new ones"
fi

cargo build --quiet --release -p mlt-benches --example fixed_render
program=${CARGO_TARGET_DIR:-target}/release/examples/fixed_render

count() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$1" 2>&1 >/dev/null |
        sed -n 's/.*refs: *\([0-9,]*\).*/\1/p' | tr -d ,
}

start_up=$(count none)
counts=$(for method in pt bdpt mlt mmlt pssmlt; do
    echo "$method $(($(count "$method") - start_up))"
done)

if [[ ${1:-} == --update ]]; then
    {
        echo "# Instructions of examples/fixed_render, start-up left out."
        echo "# compiler: $compiler"
        echo "$counts"
    } >"$stored"
    cat "$stored"
    exit 0
fi

status=0
while read -r method now; do
    before=$(awk -v method="$method" '$1 == method { print $2 }' "$stored")
    change=$(awk -v now="$now" -v before="$before" 'BEGIN { printf "%+.1f", 100 * (now / before - 1) }')
    verdict=ok
    if awk -v change="$change" -v most=$tolerance 'BEGIN { exit !(change > most || change < -most) }'; then
        verdict="more than $tolerance %: explain it, then benches/instructions.sh --update"
        status=1
    fi
    printf '%-8s %12d instructions, %s %%: %s\n' "$method" "$now" "$change" "$verdict"
done <<<"$counts"
exit $status
