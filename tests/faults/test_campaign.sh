#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One allocation, open or read of a campaign fails, in the process that compares or in a worker.
# Then the bundle is complete and says EQUAL, or there is none and the status is 2 or 3 with a
# message. The status is never 1: a worker without memory, descriptors or files is no evidence
# about its backend. Some faults are drawn with the printed seed; with OST_TEST_LONG=1 all of a
# worker and 100 of each kind of the process that compares.
# Covers: REQ-OUT-OF-MEMORY
. "${srcdir:-.}/tests/app/lib.sh"
. "$source_folder/tests/faults/lib.sh"

one='cpu:isa=scalar,threads=1'
# Files that contain times or the environment. The lists of software are complete, or there is
# no bundle.
varying=audit.log:environment.json:junit.xml:manifest.json:report.html:times.json

# walk_campaign KIND PROCESSES ARGUMENT...: K-th calls of KIND fail in the processes that OST_FAIL_IN=PROCESSES selects
# (--quiet: the one that compares)
walk_campaign() {
    kind=$1
    processes=$2
    shift 2
    walk_over --kind $kind --in "$processes" --loose $varying -- validate --jobs 1 --backends "ref;$one" --quiet --out bundle "$@"
}

# Fails each allocation of the lists of software: no list may lack a library or have another
# digest.
checks=$((checks + 1))
"$walk" --runs 0 "$library" "$build/tests/faults/write_software" || fail "the lists of software"

# A worker's first allocations fail before its options are read; its exit status must still
# report that.
for k in 1 2 3; do
    checks=$((checks + 1))
    LD_PRELOAD=$library OST_FAIL_ALLOC=$k OST_FAIL_FROM=1 "$osteon" validate --worker "$one" --trace trace --only import/0 2>err
    status=$?
    [ $status -eq 4 ] || [ $status -eq 127 ] || fail "a worker without memory from allocation $k on: status $status"
done
checks=$((checks + 1))
LD_PRELOAD=$library OST_FAIL_PATH=trace OST_FAIL_OPEN=1 "$osteon" validate --worker "$one" --trace trace --only import/0 2>err
status=$?
[ $status -eq 4 ] || fail "a worker that can open no trace: status $status: $(cat err)"

sample 2
for worker in ref "$one"; do
    for kind in alloc open read; do
        walk_campaign $kind "$worker" --only import/0
    done
done
runs=1
[ -z "${OST_TEST_LONG:-}" ] || runs=100
for kind in alloc open read; do
    walk_campaign $kind --quiet --only import/0
done
echo '{"osteon_case": 1, "id": "mesh/0", "tier": "smoke", "seed": "1"}' >case.json
sample 1
walk_campaign open "$one" --case "$scratch/case.json"
walk_campaign read "$one" --case "$scratch/case.json"
finish
