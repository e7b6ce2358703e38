#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests proposed landmarks: import --landmarks auto, the file for 3D Slicer, version and inclination
# in the output of info, and the picture. The expected values are those with which the phantom is
# generated.
# Covers: REQ-ANATOMY
. "${srcdir:-.}/tests/app/lib.sh"
needs PNG

# near WHAT "X Y Z" "X Y Z" MOST: checks that two points are at most MOST apart
near() {
    checks=$((checks + 1))
    echo "$2 $3" | tr ',' ' ' | awk -v most="$4" '
        { d = ($1 - $4)^2 + ($2 - $5)^2 + ($3 - $6)^2; exit !(NF == 6 && d <= most * most) }' ||
        fail "$1: '$2' is not within $4 of '$3'"
}

run 0 phantom scapula --side left --spacing 1 --out ct.nrrd
run 0 info ct.nrrd --json
at=$(value meta.glenoid_at_mm)
axis=$(value meta.glenoid_axis)
trigonum=$(value meta.trigonum_mm)
inferior=$(value meta.inferior_angle_mm)
version=$(value version_deg)
inclination=$(value inclination_deg)
# The phantom's face is generated with a rotation of 2 degrees backward and 5 degrees upward, each
# varied by up to 2 degrees.
near "generated version and inclination" "$version $inclination 0" "2 5 0" 3
run 0 info ct.nrrd --set at= --set axis= --set side= --set trigonum= --set inferior-angle= --json
check "angles without landmarks" "$(value version_deg 2>/dev/null)" ""

run 0 import ct.nrrd --landmarks auto --landmarks-out points.mrk.json --out bone.nrrd
check "warnings of a complete scapula" "$(wc -c <err | tr -d ' ')" 0
grep -q 'landmarks proposed, not measured' out || fail "the report does not say that the landmarks are proposed"
run 0 import ct.nrrd --landmarks auto --out bone.nrrd --json
has landmarks_proposed.rim_share landmarks_proposed.axis_spread_deg version_deg inclination_deg
run 0 info bone.nrrd --json
has meta.landmarks_proposed
check "side with landmarks" "$(value meta.side)" left
near "position of the glenoid" "$(value meta.glenoid_at_mm)" "$at" 2.5
near "axis of the glenoid" "$(value meta.glenoid_axis)" "$axis" 0.06
near "position of the trigonum" "$(value meta.trigonum_mm)" "$trigonum" 6
near "position of the inferior angle" "$(value meta.inferior_angle_mm)" "$inferior" 6
near "version and inclination" "$(value version_deg) $(value inclination_deg) 0" "$version $inclination 0" 4
proposed=$(value meta.glenoid_at_mm)
axis=$(value meta.glenoid_axis)

# When the file for 3D Slicer is read, it must give the same facts.
run 0 import ct.nrrd --landmarks points.mrk.json --out read.nrrd
run 0 info read.nrrd --json
check "position of the glenoid read from the file" "$(value meta.glenoid_at_mm)" "$proposed"
near "axis of the glenoid read from the file" "$(value meta.glenoid_axis)" "$axis" 0.000001
check "landmarks_proposed after landmarks were read from a file" "$(value meta.landmarks_proposed 2>/dev/null)" ""
# Options must override proposals.
run 0 import ct.nrrd --landmarks auto --trigonum 1,2,3 --out set.nrrd
run 0 info set.nrrd --json
check "position of the trigonum given by the option" "$(value meta.trigonum_mm)" "1 2 3"

# If the CT ends 6 mm above the tip of the scapula, the proposal must be made with a warning.
run 0 import ct.nrrd --crop 0:121,0:110,8:201 --landmarks auto --out short.nrrd
checks=$((checks + 1))
grep -q 'lies at the end of the CT' err || fail "there is no warning that the scapula ends at the end of the CT: $(cat err)"

# The picture with the landmarks must differ from the picture without landmarks.
run 0 render bone.nrrd --view en-face --size 320x240 --out plain.png
run 0 render bone.nrrd --view en-face --size 320x240 --overlay landmarks --out marked.png
checks=$((checks + 1))
cmp -s plain.png marked.png && fail "--overlay landmarks changes no pixel"
run 0 import ct.nrrd --out bare.nrrd
refuse 2 'needs a bone with landmarks' render bare.nrrd --size 32x32 --overlay landmarks --out x.png

run 0 phantom glenoid --out glenoid.nrrd
refuse 2 'no glenoid was found: ' import glenoid.nrrd --landmarks auto --out x.nrrd
[ -e x.nrrd ] && fail "a refused import left a file"
refuse 2 '--landmarks-out needs --landmarks' import ct.nrrd --landmarks-out a.mrk.json --out x.nrrd
refuse 2 'mrk.json' import ct.nrrd --landmarks auto --landmarks-out a.csv --out x.nrrd

finish
