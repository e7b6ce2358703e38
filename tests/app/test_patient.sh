#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The patient's side, orientation, glenoid and landmarks: where they come from,
# that every verb keeps and uses them, and that a contradiction is an error.
# Covers: REQ-PATIENT
. "${srcdir:-.}/tests/app/lib.sh"

# warned TEXT: in the last command's standard error
warned() {
    checks=$((checks + 1))
    grep -qF -- "$1" err || fail "no warning '$1' in: $(cat err)"
}

quiet() {
    check "warnings of $1" "$(wc -c <err | tr -d ' ')" 0
}

# ------------------------------------------------------------- orientation
# A CT of 4 x 4 x 4 voxels of 10 mm without orientation, one dense voxel: number 1.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 10 10 10\nencoding: text\n\n'
    awk 'BEGIN { for (i = 0; i < 64; i++) print i == 1 ? 200 : 0 }'
} >plain.nrrd
assumed='its orientation is assumed to be LPS'
run 0 import plain.nrrd --out assumed.nrrd --json
warned "$assumed"
check "assumed" "$(value orientation_assumed) $(value meta.orientation)" "true assumed LPS"
# Every use of what was written says so again, as a volume and as a bone.
run 0 info assumed.nrrd --json
warned "$assumed"
check "info" "$(value orientation_assumed)" true
run 0 export assumed.nrrd --out assumed.nii.gz
warned "$assumed"
run 0 import assumed.nii.gz --out again.nrrd
warned "$assumed"
run 0 export assumed.nrrd --out assumed.txt
run 0 import assumed.txt --out again.nrrd
warned "$assumed"
run 0 diff assumed.nrrd again.nrrd
warned "$assumed"
run 0 render assumed.nrrd --size 32x32 --out x.png
warned "$assumed"
refuse 2 'import the CT itself with --orientation RAS' import assumed.nrrd --orientation RAS --out x.nrrd
# Stated, it is a fact, and nothing is said. Voxel 1 of the file's x is voxel 2 from the left: at -10 mm.
run 0 import plain.nrrd --orientation RAS --out stated.nrrd --json
quiet "a stated orientation"
check "stated" "$(value orientation_assumed) $(value orientation) $(value meta.orientation)" "false RAS stated RAS"
check "its origin" "$(value origin_mm.0) $(value origin_mm.1) $(value origin_mm.2)" "-30 -30 0"
run 0 info stated.nrrd
quiet "a bone of stated orientation"
refuse 2 'its header states where its axes point' import stated.nrrd --orientation RAS --out x.nrrd
refuse 2 'expected three letters' import plain.nrrd --orientation RASP --out x.nrrd
refuse 2 'expected three letters' import plain.nrrd --orientation RAL --out x.nrrd
refuse 2 'the positions of a text are LPS' import assumed.txt --orientation RAS --out x.nrrd
refuse 2 'is a NRRD; --form is for NIfTI' import plain.nrrd --form sform --out x.nrrd

finish
