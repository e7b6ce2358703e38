#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes one allocation, open or read of a campaign fail, in the process that compares or in a
# worker. Then either the bundle must be complete with the verdict EQUAL, or there must be no bundle
# and the status must be 2 or 3 with a message. The status must never be 1, because a worker without
# memory, descriptors or files is no evidence about its backend. The faults are chosen at random,
# and the seed is printed. With OST_TEST_LONG=1, all faults of a worker are tested, and 100 faults
# of each type in the process that compares.
# Covers: REQ-OUT-OF-MEMORY
. "${srcdir:-.}/tests/app/lib.sh"
. "$source_folder/tests/faults/lib.sh"

one='cpu:isa=scalar,threads=1'
# These files contain times or the environment. The lists of software must be complete, or there
# must be no bundle.
varying=audit.log:environment.json:junit.xml:manifest.json:report.html:times.json

# walk_campaign KIND PROCESSES ARGUMENT...: makes calls of type KIND fail in the processes that OST_FAIL_IN=PROCESSES
# selects (--quiet selects the process that compares)
walk_campaign() {
    kind=$1
    processes=$2
    shift 2
    walk_over --kind $kind --in "$processes" --loose $varying -- validate --jobs 1 --backends "ref;$one" --quiet --out bundle "$@"
}

# Makes each allocation for the lists of software fail. No list may lack a library or have a
# different digest.
checks=$((checks + 1))
"$walk" --runs 0 "$library" "$build/tests/faults/write_software" || fail "a failed allocation was not handled by write_software"

# A worker's first allocations fail before its options are read; its exit status must still
# report that.
for k in 1 2 3; do
    checks=$((checks + 1))
    LD_PRELOAD=$library OST_FAIL_ALLOC=$k OST_FAIL_FROM=1 "$osteon" validate --worker "$one" --trace trace --only import/0 2>err
    status=$?
    [ $status -eq 4 ] || [ $status -eq 127 ] || fail "a worker whose allocations fail from number $k on: status $status, expected 4 or 127"
done
checks=$((checks + 1))
LD_PRELOAD=$library OST_FAIL_PATH=trace OST_FAIL_OPEN=1 "$osteon" validate --worker "$one" --trace trace --only import/0 2>err
status=$?
[ $status -eq 4 ] || fail "a worker that cannot open its trace: status $status, expected 4: $(cat err)"

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
