#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Runs the complete smoke tier on every available backend, twice in a single run and once in three
# shards that are merged. The bundles must be byte-identical except for the files with times and
# machines (a bundle's README.md lists them).
#
#   one run == another run == shards 1/3, 2/3, 3/3 --merge-->
#
# test_bundle.sh tests the same with a few cases. This test takes minutes, so it runs only with
# OST_TEST_LONG=1. OST_TEST_TIER selects another tier.
# Covers: REQ-EVIDENCE REQ-SHARDS
. "${srcdir:-.}/tests/app/lib.sh"
[ -n "${OST_TEST_LONG:-}" ] || { echo "skipped: runs only with OST_TEST_LONG=1"; exit 77; }
tier=${OST_TEST_TIER:-smoke} only=
"$osteon" devices --json >out 2>err
"$osteon" validate --backends cl --only mesh/0 >out 2>err || only=--cpu-only

# varying BUNDLE: prints the files that may differ, as listed in the bundle.
varying() {
    sed -n '/^## What differs/,$s/^| \([a-z.]*\) |.*/\1/p' "$1/README.md" | grep '\.'
}
# shellcheck disable=SC2086 # an empty variable must give no argument
{
    run 0 validate --tier "$tier" $only --out one --quiet
    run 0 validate --tier "$tier" $only --out two --quiet
    mkdir shards
    for i in 1 2 3; do run 0 validate --tier "$tier" $only --shard $i/3 --out shards/$i --quiet; done
}
run 0 validate --merge shards --out merged --quiet
check "files that may differ" "$(varying one | tr '\n' ' ')" "audit.log times.json environment.json junit.xml report.html manifest.json "
for other in two merged; do
    check "files of $other" "$(cd $other && find . -type f | sort)" "$(cd one && find . -type f | sort)"
    same=0 bytes=0
    for file in $(cd one && find . -type f | sed 's,^\./,,' | sort); do
        varying one | grep -qx "$file" && continue
        checks=$((checks + 1))
        if cmp -s "one/$file" "$other/$file"; then
            same=$((same + 1)) bytes=$((bytes + $(wc -c <"one/$file")))
        else
            fail "$other/$file differs from the file of the first run"
        fi
    done
    check "results_root of $other" "$("$json_get" results_root <$other/manifest.json)" "$("$json_get" results_root <one/manifest.json)"
    run 0 verify $other --quiet
    echo "$other: $same files of $bytes bytes are those of the first run; results_root $("$json_get" results_root <$other/manifest.json)"
done
finish
