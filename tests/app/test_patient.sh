#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the facts about the patient (side, orientation, glenoid and landmarks): their sources, that
# every verb preserves and uses them, and that a contradiction is an error.
# Covers: REQ-PATIENT
. "${srcdir:-.}/tests/app/lib.sh"
needs ASSIMP NIFTI PNG

# check_warning TEXT: checks that the last command's standard error contains TEXT
check_warning() {
    checks=$((checks + 1))
    grep -qF -- "$1" err || fail "standard error does not contain the warning '$1': $(cat err)"
}

# check_no_warning WHAT: checks that the last command printed no warning
check_no_warning() {
    check "bytes of warnings for $1" "$(wc -c <err | tr -d ' ')" 0
}

# ------------------------------------------------------------- orientation
# Makes a CT of 4 x 4 x 4 voxels of 10 mm without orientation, in which only voxel number 1 is dense.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 10 10 10\nencoding: text\n\n'
    awk 'BEGIN { for (i = 0; i < 64; i++) print i == 1 ? 200 : 0 }'
} >plain.nrrd
assumed='its orientation is assumed to be LPS'
run 0 import plain.nrrd --out assumed.nrrd --json
check_warning "$assumed"
check "assumed orientation of the CT" "$(value orientation_assumed) $(value meta.orientation)" "true assumed LPS"
# Every use of the written files, as a volume and as a bone, must repeat the warning.
run 0 info assumed.nrrd --json
check_warning "$assumed"
check "orientation_assumed of info" "$(value orientation_assumed)" true
run 0 export assumed.nrrd --out assumed.nii.gz
check_warning "$assumed"
run 0 import assumed.nii.gz --out again.nrrd
check_warning "$assumed"
run 0 export assumed.nrrd --out assumed.txt
run 0 import assumed.txt --out again.nrrd
check_warning "$assumed"
run 0 diff assumed.nrrd again.nrrd
check_warning "$assumed"
run 0 render assumed.nrrd --size 32x32 --out x.png
check_warning "$assumed"
refuse 2 'import the CT itself with --orientation RAS' import assumed.nrrd --orientation RAS --out x.nrrd
# An orientation given by an option is stored as a fact, without a warning. Along the file's x,
# voxel 1 becomes voxel 2 from the left, at -10 mm.
run 0 import plain.nrrd --orientation RAS --out stated.nrrd --json
check_no_warning "an orientation given by an option"
check "orientation given by an option" "$(value orientation_assumed) $(value orientation) $(value meta.orientation)" "false RAS stated RAS"
check "origin with the orientation given by an option" "$(value origin_mm.0) $(value origin_mm.1) $(value origin_mm.2)" "-30 -30 0"
run 0 info stated.nrrd
check_no_warning "a bone whose orientation was given by an option"
refuse 2 'its header states where its axes point' import stated.nrrd --orientation RAS --out x.nrrd
refuse 2 'expected three letters' import plain.nrrd --orientation RASP --out x.nrrd
refuse 2 'expected three letters' import plain.nrrd --orientation RAL --out x.nrrd
refuse 2 'positions in a text CT are always LPS' import assumed.txt --orientation RAS --out x.nrrd
refuse 2 'is an NRRD file; --form needs a NIfTI file' import plain.nrrd --form sform --out x.nrrd

# -------------------------------------------------------------------- side
# Tests the right phantom without its facts: position, axis and side must be requested or computed.
run 0 phantom glenoid --out phantom.nrrd
run 0 info phantom.nrrd --json
at=$(value meta.glenoid_at_mm | tr ' ' ',')
cp phantom.nrrd bare.nrrd
run 0 info bare.nrrd --set at= --set axis= --set side= --set trigonum= --set inferior-angle= --json
check "facts after they were removed" "$(value meta.side 2>/dev/null)$(value meta.glenoid_at_mm 2>/dev/null)" ""
run 0 import bare.nrrd --out bone.nrrd
check_no_warning "a bone without facts"
ream="--tool builtin:peg --voxel 1 --path builtin:peg-hole --out reamed.nrrd"
refuse 2 "the glenoid's position and axis are not set" ream --bone bone.nrrd $ream
refuse 2 "the glenoid's axis is not set" ream --bone bone.nrrd --at "$at" $ream
run 0 ream --bone bone.nrrd --at "$at" --axis 1,0,0 $ream
run 0 ream --bone bone.nrrd --at "$at" --axis 1,0,0 --side right $ream
refuse 2 'the side is left, but the axis' ream --bone bone.nrrd --at "$at" --axis 1,0,0 --side left $ream
refuse 2 'the side is not set, and the axis' ream --bone bone.nrrd --at "$at" --axis 0.1,1,0 $ream
run 0 ream --bone bone.nrrd --at "$at" --axis 0.1,1,0 --side left $ream
refuse 2 "the side is not set: pass --side" export bone.nrrd --view lateral --size 32 --out x.png
run 0 export bone.nrrd --view lateral --side left --size 32 --out x.png

# -------------------------------------------------- facts stored with a bone
run 0 import bare.nrrd --at "$at" --axis 1,0,0 --trigonum 0,0.5,1 --inferior-angle -5,2.25,-110 --out stored.nrrd --json
check "side derived from the axis" "$(value meta.side)" right
check "axis of the glenoid" "$(value meta.glenoid_axis)" "1 0 0"
check "position of the trigonum" "$(value meta.trigonum_mm)" "0 0.5 1"
run 0 ream --bone stored.nrrd $ream --record stored.session --debrief stored.html
run 0 sim --headless --bone stored.nrrd --no-clock --seconds 0.01 --tool builtin:peg
run 0 render stored.nrrd --view en-face --size 32x32 --out x.png
run 0 replay stored.session --debrief again.html
checks=$((checks + 1))
grep -q 'right' again.html || fail "the debrief does not contain the side"
facts='glenoid_at_mm glenoid_axis side trigonum_mm inferior_angle_mm'
run 0 info stored.nrrd --json
for fact in $facts; do value "meta.$fact"; done >expected
run 0 import stored.nrrd --cubic 1 --out stored2.nrrd
run 0 export stored2.nrrd --out stored3.nii.gz
run 0 import stored3.nii.gz --out stored4.nrrd --compress
run 0 export stored4.nrrd --out stored5.txt
run 0 import stored5.txt --out stored6.nrrd
for file in reamed.nrrd stored2.nrrd stored3.nii.gz stored4.nrrd stored6.nrrd; do
    run 0 info $file --json
    for fact in $facts; do value "meta.$fact"; done >got
    cmp -s expected got || fail "the facts of $file differ from the expected facts: $(cat got)"
done
# Tests contradictions, and points outside the bone.
refuse 2 'contradicts stored.nrrd, whose header has side right' ream --bone stored.nrrd --side left $ream
refuse 2 'contradicts stored.nrrd, whose header has side right' import stored.nrrd --side left --out x.nrrd
refuse 2 'correct the side or the axis' import bare.nrrd --at "$at" --axis 1,0,0 --side left --out x.nrrd
refuse 2 'lies outside the grid' import bare.nrrd --at 9,9,900 --axis 1,0,0 --out x.nrrd
ras=$(echo "$at" | awk -F, '{ printf "%s,%s,%s", -$1, -$2, $3 }')
refuse 2 'it is probably in RAS' import bare.nrrd --at "$ras" --axis 1,0,0 --out x.nrrd

# ---------------------------------------------------------------- landmarks
l=$(echo "$at" | awk -F, '{ printf "%s,%s", -$1, -$2 }')
s=${at##*,}
axis_ras=$(echo "$at" | awk -F, '{ printf "%s,%s,%s", -$1 - 20, -$2, $3 }')
{
    printf '# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n'
    printf '# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n'
    printf '1,%s,0,0,0,1,1,1,0,%s,,\n' "$l,$s" Glenoid "$axis_ras" Axis 0,-0.5,1 TS 5,-2.25,-110 'inferior angle' 1,2,3 'odd one'
} >f.fcsv
run 0 import bare.nrrd --landmarks f.fcsv --out stored7.nrrd --json
check_warning "unknown label 'odd one' ignored"
for fact in $facts; do value "meta.$fact"; done >got
cmp -s expected got || fail "the facts from the landmarks differ from the expected facts: $(cat got)"
printf 'glenoid,%s\n' "$at" >f.csv
run 0 import bare.nrrd --landmarks f.csv --axis 1,0,0 --out stored8.nrrd --json
check "side and axis if --axis is given in addition to --landmarks" "$(value meta.side) $(value meta.glenoid_axis)" "right 1 0 0"
printf 'axis,1,2,3\n' >g.csv
refuse 2 "which the file does not have" import bare.nrrd --landmarks g.csv --out x.nrrd
refuse 2 'f.csv:2' import bare.nrrd --landmarks "$(printf 'glenoid,1,2\n' >>f.csv; echo f.csv)" --out x.nrrd
[ ! -e x.nrrd ] || fail "a refused import left x.nrrd"
# A fact in the CT's header that cannot be parsed is refused before the bone is written.
for bad in "glenoid_at_mm:=1 abc 3|; expected three numbers X,Y,Z in millimetres" \
    "glenoid_at_mm:=1 2 20.03m|; expected three numbers X,Y,Z in millimetres" \
    "glenoid_at_mm:=1 2 9000|; expected numbers from -8000 to 8000 mm" \
    "trigonum_mm:=1 2|; expected three numbers X,Y,Z in millimetres" \
    "glenoid_axis:=1 0 0 0|; expected three numbers X,Y,Z" \
    "glenoid_axis:=0 0 0| is not a direction" "side:=up|; expected left or right"; do
    fact=${bad%%|*}
    sed "s/^encoding/osteon_$fact\n&/" plain.nrrd >bad.nrrd
    refuse 2 "bad.nrrd: ${fact%%:*}: '${fact#*:=}'${bad#*|}" import bad.nrrd --orientation LPS --out x.nrrd
    [ ! -e x.nrrd ] || fail "an import that was refused for '$fact' wrote x.nrrd"
done

# --------------------------------------------------------------- info --set
run 0 import bare.nrrd --out set.nrrd --compress
run 0 info set.nrrd --digest --json
digest=$(value sha256)
run 0 info set.nrrd --set "at=$at" --set axis=1,0,0 --set "trigonum=0,0.5,1" --set inferior-angle=-5,2.25,-110 --digest --json
check "digest after --set" "$(value sha256)" "$digest"
for fact in $facts; do value "meta.$fact"; done >got
cmp -s expected got || fail "the facts after --set differ from the expected facts: $(cat got)"
cp set.nrrd kept.nrrd
refuse 2 'correct the side or the axis' info set.nrrd --set side=left
refuse 2 "set side=up: expected left or right" info set.nrrd --set side=up
refuse 2 'expected KEY=VALUE' info set.nrrd --set threshold=3
refuse 2 'expected KEY=VALUE' info set.nrrd --set side
refuse 2 "set at=1,2: expected three numbers X,Y,Z in millimetres" info set.nrrd --set at=1,2
refuse 2 "set at=1,2,20.03m: expected three numbers" info set.nrrd --set at=1,2,20.03m
refuse 2 "set axis=0,0,0: expected three numbers X,Y,Z, not all of them 0" info set.nrrd --set axis=0,0,0
refuse 2 'lies outside the grid' info set.nrrd --set at=1,2,3000
cmp -s set.nrrd kept.nrrd || fail "a refused --set changed the file"
run 0 info set.nrrd --set trigonum= --set side= --set axis=0,1,0 --json
check "facts that --set removed" "$(value meta.trigonum_mm 2>/dev/null)$(value meta.side 2>/dev/null)" ""
run 0 export kept.nrrd --out set.nii.gz
run 0 info set.nii.gz --set trigonum=1,2,3 --json
check "facts of a NIfTI file after --set" "$(value meta.trigonum_mm) $(value meta.side)" "1 2 3 right"
refuse 2 "pass these values to 'osteon import'" info stored5.txt --set side=right
ls -a | grep -q '\.part$' && fail "--set left a part file"

# ------------------------------------------------------- thresholds and units
run 0 import bare.nrrd --threshold 200 --out bone200.nrrd
refuse 2 'was cut at 200 HU: values below it are not stored' import bone200.nrrd --threshold 120 --out x.nrrd
refuse 2 'was cut at 200 HU: values below it are not stored' ream --bone bone200.nrrd --threshold 199 --at "$at" --axis 1,0,0 $ream
run 0 import bone200.nrrd --threshold 200 --out x.nrrd
run 0 import bone200.nrrd --threshold 300 --out x.nrrd
run 0 import bone200.nrrd --out x.nrrd
check "bytes of warnings for an allowed threshold" "$(wc -c <err | tr -d ' ')" 0
# 28 voxels of 0.1 mm are 2.8 mm long; 28 voxels of 99 mm are 2.8 m long.
volume_of_spacing() {
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 28 2 2\nspace: LPS\nspace directions: (%s,0,0) (0,%s,0) (0,0,%s)\nencoding: text\n\n' "$1" "$1" "$1"
    awk 'BEGIN { for (i = 0; i < 112; i++) print 200 }'
}
volume_of_spacing 0.1 >small.nrrd
run 0 import small.nrrd --out x.nrrd
check_warning '2.8 mm across, too small'
check_warning '28 mm if its lengths are centimetres, or 71.1 mm if its lengths are inches'
run 0 tool peg --length 2.8 --diameter 1 --out small.stl
run 0 voxelize small.stl --voxel 0.1 --out x.nrrd
check_warning 'small.stl: the mesh is 2.8 mm across when its lengths are taken as millimetres: it would be 28 mm if its lengths are centimetres'
run 0 voxelize small.stl --voxel 0.1 --unit mm --out x.nrrd
check_no_warning "a small mesh whose unit is confirmed"
volume_of_spacing 99 >fits.nrrd
run 0 import fits.nrrd --out x.nrrd
check_no_warning "a CT of 2.8 m"

# ------------------------------------------------- before an operation begins
# Makes a block with its face at x = 23.5 mm, and a second block with a head in front of its face
# that extends to x = 17.5 mm. The inward axis is +x.
ct_text 40 24 24 1 '(i < 24 ? 0 : 500)' >block.txt
ct_text 40 24 24 1 '(i < 24 ? (i < 18 ? 400 : 0) : 500)' >headed.txt
run 0 import block.txt --out block.nrrd --at 23.5,12,12 --axis 1,0,0
run 0 import headed.txt --out headed.nrrd --at 23.5,12,12 --axis 1,0,0
peg="--tool builtin:peg --voxel 1 --path builtin:peg-hole"
run 0 ream --bone block.nrrd $peg --out x.nrrd --strict --json
check_no_warning "an operation with no bone in the way"
check "an operation with no bone in the way" "$(value front_mm3) $(value overlap_voxels) $(value near_side_voxels)" "0 0 0"
removed=$(value removed_voxels)
run 0 ream --bone headed.nrrd $peg --out x.nrrd --json
check_warning "of bone lie in front of the glenoid's face, in the way of builtin:peg"
check_warning 'builtin:peg overlaps'
[ "$(value overlap_voxels)" -gt 0 ] || fail "the peg begins in the head, but overlap_voxels is 0"
[ "$(value near_side_voxels)" -gt 100 ] || fail "the head was cut, but near_side_voxels is $(value near_side_voxels), expected more than 100"
check "removed voxels except those of the head, and removed voxels without a head" "$(($(value removed_voxels) - $(value near_side_voxels)))" "$removed"
check "near_side_mm3 and near_side_voxels (1 mm3 each)" "$(value near_side_mm3)" "$(value near_side_voxels)"
run 0 ream --bone headed.nrrd $peg --out x.nrrd
checks=$((checks + 1))
grep -q "on the near side of the glenoid's face: [1-9]" out || fail "the output does not contain the number of voxels on the near side: $(cat out)"
rm -f x.nrrd x.session
refuse 2 'of bone lie in front' ream --bone headed.nrrd $peg --out x.nrrd --record x.session --strict
[ ! -e x.nrrd ] && [ ! -e x.session ] || fail "ream refused with --strict left an output"
run 0 info block.nrrd --set side= --set axis=-1,0,0
run 0 ream --bone block.nrrd $peg --out x.nrrd
check_warning 'the axis is probably reversed'
refuse 2 'does not point into bone' sim --headless --no-clock --seconds 0.01 --bone block.nrrd --tool builtin:peg --voxel 1 --strict
run 0 import block.txt --out nowhere.nrrd --at 8,12,12 --axis 1,0,0
run 0 ream --bone nowhere.nrrd $peg --out x.nrrd
check_warning 'check --at and --axis'

# ----------------------------------------------------------- left and right
# The left phantom is the mirrored right phantom. On both sides the plan's axis points less to the
# posterior than the phantom's own axis, by the same angle, so the planned face is rotated more to
# the posterior. The retroversion must be greater than the phantom's 2 degrees, and equal on both
# sides.
for side in left right; do
    sign=$([ $side = left ] && echo -)
    run 0 phantom scapula --spacing 1,1,1 --side $side --out ct.nrrd
    run 0 import ct.nrrd --out bone.nrrd
    run 0 ream --bone bone.nrrd --axis ${sign}0.97,0.2,0.1 --tool builtin:peg --path builtin:peg-hole --tool builtin:reamer \
        --path builtin:glenoid-ream --out x.nrrd --debrief x.html --json
    check "the metrics of the $side scapula use its landmarks" "$(value metrics.scapular)" true
    echo "$(value removed_mm3) $(value metrics.version_planned_deg) $(value metrics.inclination_planned_deg) $(value metrics.version_deg)" \
        "$(value metrics.inclination_deg)" >$side
done
checks=$((checks + 1))
paste -d' ' left right | awk '{
    for (i = 1; i <= 5; i++) { d = $i - $(i + 5); if (d < 0) d = -d; if (d > (i == 1 ? 0.002 * $1 : i < 4 ? 1e-6 : 0.05)) bad = 1 }
    exit bad || $1 < 500 || $2 < 8 || $2 > 20
}' || fail "the results of the left and of the right scapula are not mirror images: $(cat left right)"

finish
