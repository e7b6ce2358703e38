#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the grids of the thesis: Tables 3.1 and 3.2 for its five models, and its reamer at three
# resolutions. The verbs phantom and import make the models, and the verbs tool and voxelize make
# the reamers. The digests must be the same on every backend of OST_TEST_BACKENDS
# (tests/backends.h). The two largest models run with OST_TEST_LONG=1.
# Covers: AR-CUB-1, AR-CHK-1, AR-TOOL-2, REQ-TABLES
. "${srcdir:-.}/tests/app/lib.sh"

backends=${OST_TEST_BACKENDS:-ref cpu:threads=2 cpu:isa=scalar,threads=3}
first=${backends%% *}

# model KIND RECT CUBIC CHUNKS: checks the dimensions of a model
model() {
    run 0 phantom "$1" --out model.nrrd --json || return
    check "$1: dimensions of the CT" "$(value dims.0) $(value dims.1) $(value dims.2)" "$2"
    for backend in $backends; do
        run 0 import model.nrrd --out bone.nrrd --json --backend "$backend" || return
        check "$1: rect dims" "$(value rect_dims.0) $(value rect_dims.1) $(value rect_dims.2)" "$2"
        check "$1: cubic dims" "$(value cubic_dims.0) $(value cubic_dims.1) $(value cubic_dims.2)" "$3"
        check "$1: chunk dims" "$(value chunk_dims.0) $(value chunk_dims.1) $(value chunk_dims.2)" "$4"
        digests="$(value stages.0.sha256) $(value stages.1.sha256) $(value stages.2.sha256) $(value file_sha256)"
        [ "$backend" = "$first" ] && expected_digests=$digests
        check "$1: digests by $backend" "$digests" "$expected_digests"
    done
    echo "$1: $(value active_chunks) of $(value chunks) chunks active"
}

model glenoid "49 81 41" "49 81 88" "2 3 3"
model scapula "256 234 201" "256 234 428" "8 8 14"
model trabecular "156 156 313" "156 156 313" "5 5 10"
if [ "${OST_TEST_LONG:-0}" = 1 ]; then
    model trabecular2 "314 316 360" "314 316 360" "10 10 12"
    model foam "314 320 604" "314 320 604" "10 10 19"
fi

reamer() {
    for backend in $backends; do
        run 0 voxelize reamer.stl --voxel "$1" --out reamer.nrrd --json --backend "$backend" || return
        check "dimensions of the reamer at $1" "$(value dims.0) $(value dims.1) $(value dims.2)" "$2"
        check "leaking rows of the reamer at $1" "$(value leaking_rows)" 0
        [ "$backend" = "$first" ] && expected_digests=$(value sha256)
        check "reamer at $1: digest by $backend" "$(value sha256)" "$expected_digests"
    done
}
run 0 tool reamer --out reamer.stl
need_part assimp "no meshes without assimp"
reamer 1 "38 38 23"
reamer 0.75 "50 50 30"
reamer 0.5 "73 74 43"
finish
