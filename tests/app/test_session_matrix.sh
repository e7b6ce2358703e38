#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Records five minutes of a simulated operation with a force. Replays it on the reference, with
# every instruction set and 1 to 3 threads, and on every OpenCL device. Each tick and the bone must
# be equal.
#
#   OST_SESSION_SECONDS=N   another duration (default 300)
#
# The test takes minutes, so it is skipped without OST_TEST_LONG=1.
# Covers: REQ-REPLAY
[ "${OST_TEST_LONG:-0}" = 1 ] || { echo "skipped: runs only with OST_TEST_LONG=1"; exit 77; }
. "${srcdir:-.}/tests/app/lib.sh"
seconds=${OST_SESSION_SECONDS:-300}

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
# The operation consists of the hole and the reaming. After the end of these paths, the simulated
# operator stays at the last pose for the remaining time.
run 0 sim --headless --no-clock --bone bone.nrrd --device sim:tremor=300,friction=60 --tool builtin:peg --path builtin:peg-hole \
    --tool builtin:reamer --path builtin:glenoid-ream --seconds "$seconds" --record long.session --json
check "ticks of the operation" "$(value ticks)" $((seconds * 1000))
[ "$(value removed_voxels)" -gt 1000 ] || [ "$seconds" -lt 10 ] || fail "$(value removed_voxels) voxels were removed, expected more than 1000"
grid=$(value sha256)

replay_on() {
    run 0 replay long.session --verify --backend "$1" --json || return
    check "replay on $1: equal, ticks, digest" "$(value equal) $(value ticks) $(value sha256)" "true $((seconds * 1000)) $grid"
}
replay_on ref
"$osteon" devices --json >devices.json 2>/dev/null
i=0
while isa=$("$json_get" backends.0.isas.$i <devices.json 2>/dev/null); do
    for threads in 1 2 3; do
        replay_on "cpu:isa=$isa,threads=$threads"
    done
    i=$((i + 1))
done
[ $i -gt 0 ] || fail "osteon devices lists no instruction set"
"$osteon" devices | grep -q "^  cl *yes" && replay_on cl
finish
