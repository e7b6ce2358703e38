#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon segment, which divides a CT into bones, and osteon import --mask, which makes a bone
# from one of them.
# Covers: REQ-SEGMENT, REQ-MASK, REQ-MASK-NAMES, REQ-SELECT, REQ-CUT-HEAD, AR-SEG-6
. "${srcdir:-.}/tests/app/lib.sh"

# Most tests use a small CT. It contains two blocks of 500 HU, one of 4 x 4 x 4 voxels and one of
# 3 x 4 x 4 voxels. A bridge of one voxel at x = 6, y = 3, z = 3 connects them. All other voxels are
# soft tissue of 50 HU.
# nrrd TYPE FORMULA: prints an NRRD in text form with 12 x 7 x 7 voxels of 2 mm and its origin at
# (10, 20, 30) mm. FORMULA is an awk expression of i, j and k that gives the value of a voxel.
nrrd() {
    printf 'NRRD0004\ntype: %s\ndimension: 3\nsizes: 12 7 7\nspace: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (10,20,30)\nencoding: text\n\n' "$1"
    awk "BEGIN { for (k = 0; k < 7; k++) for (j = 0; j < 7; j++) for (i = 0; i < 12; i++) { v = $2; print v } }"
}
inside='(j >= 1 && j <= 4 && k >= 1 && k <= 4)'
dense="($inside && (i >= 2 && i <= 5 || i >= 7 && i <= 9) || i == 6 && j == 3 && k == 3)"
nrrd int16 "$dense ? 500 : 50" >ct.nrrd

run 0 segment ct.nrrd --out joined.nrrd --min-volume 0 --at 16,22,32 --json
check "blocks with the bridge: components, voxels, label at a position" "$(value components) $(value segments.0.voxels) $(value label_at)" "1 113 1"
run 0 segment ct.nrrd --out labels.nrrd --min-volume 0 --cut-ball 22,26,36,0.5 --at 26,24,34 --json
check "--cut-ball at the bridge: components, voxels, label at a position" "$(value components) $(value segments.0.voxels) $(value segments.1.voxels) $(value label_at)" "2 64 48 2"
check "box and volume of the second component" "$(value segments.1.box_lo.0) $(value segments.1.box_hi.0) $(value segments.1.volume_mm3)" "7 10 384"
plane=plane.nrrd
"$osteon" devices | grep -q "^  nifti *yes" && plane=plane.nii.gz
run 0 segment ct.nrrd --out "$plane" --cut-plane 24,0,0,1,0,0 --at 300,0,0 --json
check "--cut-plane: components, voxels, label at a position" "$(value components) $(value segments.0.voxels) $(value label_at)" "1 65 -1"
run 0 segment ct.nrrd --out large.nrrd --min-volume 400 --cut-ball 22,26,36,0.5 --json
check "components with a greater smallest size" "$(value components)" 1
run 0 segment ct.nrrd --out none.nrrd --threshold 501
grep -q "ct.nrrd: no bone of [0-9.]* mm3 or more reaches 501 HU; pass a lower --threshold or --min-volume" err || fail "the error does not state that no bone is large enough: $(cat err)"
run 0 import labels.nrrd --out none.nrrd
grep -q "labels.nrrd: no voxel has 120 HU or more; the bone is empty; the CT is a label map: pass it to --mask" err ||
    fail "the warning does not state that the CT is a label map: $(cat err)"
run 0 info labels.nrrd --json
check "facts about the segmentation" "$(value meta.segment_threshold) $(value meta.segment_min_voxels) $(value meta.segment_ball_1)" "120 1 22,26,36,0.5"
# Tests --separate. The bridge is a neck with a radius of 2 mm between blocks with radii of 4 mm. The two voxels next to
# the bridge have equal heights. The voxel of the right block is nearer to its marker, so the bridge belongs to the
# right block.
run 0 segment ct.nrrd --out two.nrrd --min-volume 0 --separate 1.5 --json
check "--separate at the bridge: components, voxels" "$(value components) $(value segments.0.voxels) $(value segments.1.voxels)" "2 64 49"
run 0 info two.nrrd --json
check "fact segment_separate_mm" "$(value meta.segment_separate_mm)" 1.5
run 0 segment ct.nrrd --out one.nrrd --min-volume 0 --separate 3 --json
check "components with a greater depth of --separate" "$(value components)" 1
# Tests the selection of bones by segment and by import.
run 0 segment ct.nrrd --out right.nrrd --min-volume 0 --cut-ball 22,26,36,0.5 --bone 28,26,36 --json
check "--bone at a position: components, components found, voxels" "$(value components) $(value components_found) $(value segments.0.voxels)" "1 2 48"
run 0 info right.nrrd --json
check "fact segment_bone_1" "$(value meta.segment_bone_1)" "28,26,36"
run 0 segment ct.nrrd --out left.nrrd --min-volume 0 --cut-ball 22,26,36,0.5 --bone largest --json
check "--bone largest: components, voxels" "$(value components) $(value segments.0.voxels)" "1 64"
run 0 segment ct.nrrd --out both.nrrd --min-volume 0 --cut-ball 22,26,36,0.5 --bone largest --bone 28,26,36 --json
check "components with two selected bones" "$(value components)" 2
# Tests --growth: soft tissue that is connected to a component is added to the component.
run 0 segment ct.nrrd --out grown.nrrd --growth 50 --json
check "voxels with --growth" "$(value segments.0.voxels)" 588
# Tests --fill on two holes: one contains only soft tissue, the other also contains air.
nrrd int16 "$inside && i >= 2 && i <= 9 && !(j >= 2 && j <= 3 && k >= 2 && k <= 3 && (i == 4 || i == 7)) ? 500 : i == 7 && j == 2 && k == 2 ? -900 : 50" >holes.nrrd
run 0 segment holes.nrrd --out filled.nrrd --fill --json
check "--fill of the hole without air: voxels, filled voxels" "$(value segments.0.voxels) $(value segments.0.filled)" "120 4"
run 0 segment holes.nrrd --out filled.nrrd --fill --air -1000 --json
check "--fill of both holes: filled voxels" "$(value segments.0.filled)" 8

# In the bone of a label, the voxels with this label must have their densities, and all other voxels
# must be empty.
# check_bone FORMULA: compares bone.nrrd with the voxels of 120 HU or more of a formula of i, j and k
check_bone() {
    run 0 export bone.nrrd --out bone.txt
    awk 'BEGIN { for (k = 0; k < 7; k++) for (j = 0; j < 7; j++) for (i = 0; i < 12; i++) { v = '"$1"'; print 10 + 2 * i, 20 + 2 * j, 30 + 2 * k, (v >= 120 ? v : 0) } }' >expected
    checks=$((checks + 1))
    grep -v '^#' bone.txt | cmp -s - expected || fail "the bone differs from the formula $1: $(grep -v '^#' bone.txt | diff - expected | head -4 | tr '\n' ' ')"
}
run 0 import ct.nrrd --mask labels.nrrd:2 --out bone.nrrd --json
check "mask of label 2: voxels of the mask, removed, filled, labels" "$(value mask_voxels) $(value mask_removed) $(value mask_filled) $(value meta.mask_labels)" "48 65 0 2"
check_bone "$inside && i >= 7 && i <= 9 ? 500 : 0"
run 0 import ct.nrrd --mask labels.nrrd --out bone.nrrd --json
check "mask of all labels: voxels of the mask, removed, labels" "$(value mask_voxels) $(value mask_removed) $(value meta.mask_labels)" "112 1 all"
run 0 import ct.nrrd --mask labels.nrrd:1,2 --out bone.nrrd --json
check "mask of labels 1 and 2: removed voxels, labels" "$(value mask_removed) $(value meta.mask_labels)" "1 1,2"
run 0 import holes.nrrd --mask filled.nrrd:1 --mask-fill --out bone.nrrd --json
check "filled voxels of a mask" "$(value mask_filled)" 8
check_bone "$inside && i >= 2 && i <= 9 ? (j >= 2 && j <= 3 && k >= 2 && k <= 3 && (i == 4 || i == 7) ? 120 : 500) : 0"
# Tests a mask from another program, with voxels of one byte and a position that deviates by a
# hundredth of a voxel.
nrrd uint8 'i > 5 ? 71 : 3' | sed 's/(10,20,30)/(10.02,20,30)/' >other.nrrd
run 0 import ct.nrrd --mask other.nrrd:71 --out bone.nrrd --json
check "mask of another program: voxels of the mask, removed" "$(value mask_voxels) $(value mask_removed)" "294 64"
# Import with the options of segment must give the same bone as import with the label map that
# segment writes.
run 0 import ct.nrrd --min-volume 0 --cut-ball 22,26,36,0.5 --bone 28,26,36 --out bone.nrrd --json
check "selection by import: voxels, removed, components, fact segment_ball_1" "$(value bone_voxels) $(value bone_removed) $(value components) $(value meta.segment_ball_1)" "48 65 1 22,26,36,0.5"
check_bone "$inside && i >= 7 && i <= 9 ? 500 : 0"
run 0 import ct.nrrd --min-volume 0 --separate 1.5 --bone largest --out bone.nrrd --json
check "separation by import: voxels, fact segment_separate_mm" "$(value bone_voxels) $(value meta.segment_separate_mm)" "64 1.5"
check_bone "$inside && i >= 2 && i <= 5 ? 500 : 0"
run 0 import holes.nrrd --fill --air -1000 --out bone.nrrd --json
check "filled voxels by import" "$(value bone_filled)" 8
check_bone "$inside && i >= 2 && i <= 9 ? (j >= 2 && j <= 3 && k >= 2 && k <= 3 && (i == 4 || i == 7) ? 120 : 500) : 0"
run 0 import ct.nrrd --growth 50 --out bone.nrrd --json
check "growth by import: voxels, filled voxels" "$(value bone_voxels) $(value bone_filled)" "588 475"
run 0 import ct.nrrd --spacing 4 --bone 46,32,42 --cut-ball 34,32,42,0.5 --out bone.nrrd --json
check "voxels of a bone selected with other spacings" "$(value bone_voxels)" 48
run 0 import ct.nrrd --mask labels.nrrd:2 --bone largest --out bone.nrrd --json
check "mask and selection: voxels of the mask, of the bone" "$(value mask_voxels) $(value bone_voxels)" "48 48"
# Tests names: the segments of 3D Slicer in the header of an NRRD, and files of names.
add_segments() { sed 's/^encoding: text$/encoding: text\nSegment0_Name:=Scapula, right\nSegment0_LabelValue:=71\nSegment1_LabelValue:=3\nSegment1_Name:=humerus\nSegment2_Name:=Humerus\nSegment2_LabelValue:=4/'; }
add_segments <other.nrrd >named.seg.nrrd
refuse 2 "named.seg.nrrd: the labels 3 and 4 are both named 'humerus'" import ct.nrrd --mask named.seg.nrrd:humerus --out b.nrrd
sed -i '/^Segment2_/d' named.seg.nrrd
run 0 import ct.nrrd --mask named.seg.nrrd:HUMERUS --out bone.nrrd --json
check "mask by the name of a segment: voxels, label, name" "$(value mask_voxels) $(value meta.mask_labels) $(value meta.mask_names)" "294 3 HUMERUS"
run 0 import ct.nrrd --mask named.seg.nrrd:humerus,71 --out bone.nrrd --json
check "mask by a name and a number: voxels, labels" "$(value mask_voxels) $(value meta.mask_labels)" "588 71,3"
refuse 2 "named.seg.nrrd: no label is named 'clavicle'; its labels are Scapula, right, humerus" import ct.nrrd --mask named.seg.nrrd:clavicle --out b.nrrd
refuse 2 "other.nrrd: no label is named 'humerus', because the file has no names" import ct.nrrd --mask other.nrrd:humerus --out b.nrrd
cp other.nrrd a:b.nrrd
run 0 import ct.nrrd --mask a:b.nrrd --out bone.nrrd --json
run 0 import ct.nrrd --mask a:b.nrrd:71 --out bone.nrrd --json
check "voxels of a mask whose file name contains a colon" "$(value mask_voxels)" 294
printf 'label,name\r\n3,humerus\r\n71,scapula\r\n' >names.csv
printf '# table\n3 humerus 1 2 3 255\n71\tscapula\n' >names.txt
printf '# ITK-SNAP\n    3   255    0    0        1  1  1    "humerus"\n   71   0  255    0        1  1  1    "scapula"\n' >names.label
printf '{"3": "humerus", "71": "scapula"}' >names.json
printf '{"humerus": 3, "scapula": 71}' >values.json
for file in names.csv names.txt names.label names.json values.json; do
    run 0 import ct.nrrd --mask other.nrrd:scapula --mask-names $file --out bone.nrrd --json
    check "label and name with the file $file" "$(value meta.mask_labels) $(value meta.mask_names)" "71 scapula"
done
printf '3 humerus\nscapula 71\n' >wrong.txt
refuse 2 "wrong.txt:2: 'scapula 71'; expected the value and the name" import ct.nrrd --mask other.nrrd:scapula --mask-names wrong.txt --out b.nrrd
printf 'scapula\n' >wrong.txt
refuse 2 "wrong.txt: the file contains no label names" import ct.nrrd --mask other.nrrd:scapula --mask-names wrong.txt --out b.nrrd
printf '{"scapula": 32768}' >wrong.json
refuse 2 "wrong.json: 'scapula'; expected names of labels from 0 to 32767" import ct.nrrd --mask other.nrrd:scapula --mask-names wrong.json --out b.nrrd
printf '{"scapula"' >wrong.json
refuse 2 "wrong.json:1: " import ct.nrrd --mask other.nrrd:scapula --mask-names wrong.json --out b.nrrd
printf '3 a\0b\n' >wrong.txt
refuse 2 "wrong.txt: not a text file" import ct.nrrd --mask other.nrrd:scapula --mask-names wrong.txt --out b.nrrd
refuse 2 "mask-names needs --mask" import ct.nrrd --mask-names names.txt --out b.nrrd
sed 's/^dimension: 3/dimension: 4/; s/^sizes: /sizes: 2 /' named.seg.nrrd >layers.seg.nrrd
refuse 2 "layers.seg.nrrd:3: a segmentation in layers, because segments overlap; in 3D Slicer, export it" import ct.nrrd --mask layers.seg.nrrd:humerus --out b.nrrd
# Tests the table of labels in a NIfTI extension, as TotalSegmentator writes it. The extension has code 0 and is
# inserted before the voxels.
if "$osteon" devices | grep -q "^  nifti *yes"; then
    run 0 export other.nrrd --out plain.nii
    xml='<CaretExtension><LabelTable><Label Key="3" Red="1"><![CDATA[humerus]]></Label><Label Key="71"><![CDATA[scapula_right]]></Label></LabelTable></CaretExtension>'
    offset=$(od -An -t f4 -j 108 -N 4 plain.nii | awk '{ printf "%d", $1 }')
    { # 348 bytes of header with the new offset, the extender, an extension of 192 bytes, the voxels
        head -c 108 plain.nii
        printf '\0\0\010\104' # 544 as a float
        tail -c +113 plain.nii | head -c 236
        printf '\1\0\0\0\300\0\0\0\0\0\0\0'
        printf '%-184s' "$xml"
        tail -c +$((offset + 1)) plain.nii
    } >named.nii
    run 0 import ct.nrrd --mask named.nii:scapula_right --out bone.nrrd --json
    check "mask by a name of TotalSegmentator: voxels, label" "$(value mask_voxels) $(value meta.mask_labels)" "294 71"
    refuse 2 "named.nii: no label is named 'rib'; its labels are humerus, scapula_right" import ct.nrrd --mask named.nii:rib --out b.nrrd
fi
# Tests a label map on a part of the lattice of the CT, one on a larger lattice, and one with
# different axes.
nrrd uint8 1 | head -n $((9 + 3 * 7 * 7)) | sed 's/sizes: 12 7 7/sizes: 3 7 7/; s/(10,20,30)/(24,20,30)/' >part.nrrd
run 0 import ct.nrrd --mask part.nrrd --out bone.nrrd --json
check "label map on a part of the lattice: voxels of the mask, removed" "$(value mask_voxels) $(value mask_removed)" "147 65"
check_bone "$inside && i >= 7 && i <= 9 ? 500 : 0"
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 14 9 8\nspace: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (6,18,30)\nencoding: text\n\n'
  awk 'BEGIN { for (k = 0; k < 8; k++) for (j = 0; j < 9; j++) for (i = 0; i < 14; i++) print (i - 2 >= 7) }'; } >around.nrrd
run 0 import ct.nrrd --mask around.nrrd --out bone.nrrd --json
check "label map on a larger lattice: voxels of the mask, removed" "$(value mask_voxels) $(value mask_removed)" "245 65"
check_bone "$inside && i >= 7 && i <= 9 ? 500 : 0"
nrrd uint8 'i <= 4' | sed 's/left-posterior/right-anterior/; s/(2,0,0) (0,2,0)/(2,0,0) (0,-2,0)/; s/(10,20,30)/(-32,-20,30)/' >flipped.nrrd
run 0 import ct.nrrd --mask flipped.nrrd --out bone.nrrd --json
check "label map with other axes: voxels of the mask, removed" "$(value mask_voxels) $(value mask_removed)" "245 65"
check_bone "$inside && i >= 7 && i <= 9 ? 500 : 0"
# The mask applies to the complete CT. The option --crop then selects a part of it.
run 0 import ct.nrrd --mask other.nrrd:71 --crop 0:12,0:7,0:4 --out cropped.nrrd --json
check "mask and --crop: active voxels, removed" "$(value active_voxels) $(value mask_removed)" "37 64" # 3 layers of 12 voxels and the bridge

# Tests a humeral head that touches the glenoid. The shoulder consists of the scapula with the same seed and a humerus.
# The voxels of the scapula phantom are the expected result. Its grid is a part of the grid of the shoulder.
run 0 phantom scapula --spacing 0.94,0.94,2 --out scapula.nrrd
run 0 phantom shoulder --spacing 0.94,0.94,2 --out shoulder.nrrd
run 0 segment scapula.nrrd --out truth.nrrd --json
truth=$(value segments.0.voxels)
run 0 segment shoulder.nrrd --out joined.nrrd --json
check "components of the shoulder without separation" "$(value components)" 1
glenoid=-148.723,-18.868,54.133
# check_scapula WHAT PURITY LOSS: checks that at least PURITY % of the voxels of right.nrrd belong to the scapula, and
# that at most LOSS % of the scapula are missing in right.nrrd
check_scapula() {
    labelled=$(value segments.0.voxels)
    run 0 import scapula.nrrd --mask right.nrrd --out bone.nrrd --json
    right=$((truth - $(value mask_removed)))
    checks=$((checks + 1))
    [ $((100 * right)) -ge $((labelled * $2)) ] && [ $((100 * (truth - right))) -le $((truth * $3)) ] ||
        fail "$1: $right of $labelled labelled voxels belong to the scapula, which has $truth voxels"
}
run 0 segment shoulder.nrrd --out right.nrrd --cut-head auto --bone $glenoid --json
ball=$(value head_ball)
# The header of the phantom contains the centre of the head, (-170.931, -29.923, 65.207) mm. The radius of the head is 24 mm
# in the mean shape, which is 27.8 mm in this bone.
echo "$ball" | awk -F , '{ d = ($1 + 170.931) ^ 2 + ($2 + 29.923) ^ 2 + ($3 - 65.207) ^ 2; exit !(d < 0.5 ^ 2 && $4 > 28.3 && $4 < 29.3) }' || fail "the centre or the radius of the proposed head is wrong: $ball"
check_scapula "scapula with --cut-head" 99 1
cp right.nrrd by_head.nrrd
run 0 segment shoulder.nrrd --out right.nrrd --cut-ball "$ball" --bone $glenoid --json
run 0 diff by_head.nrrd right.nrrd # --cut-ball with the printed ball must give the same labels as --cut-head
run 0 segment shoulder.nrrd --out right.nrrd --cut-head -165,-25,70 --bone $glenoid --json
check "head found from a given position" "$(value head_ball)" "$ball"
run 0 segment shoulder.nrrd --out right.nrrd --separate 2 --bone $glenoid --json
check_scapula "scapula with --separate" 98 20 # the acromion is separated from the scapula
run 0 import shoulder.nrrd --cut-head auto --bone $glenoid --out bone.nrrd --json
check "facts segment_head_ball and segment_bone_1" "$(value meta.segment_head_ball) $(value meta.segment_bone_1)" "$ball $glenoid"
refuse 2 "cut-head: no spherical surface" segment ct.nrrd --out b.nrrd --cut-head auto

# Errors must be reported in one line.
refuse 2 "no voxel has a selected label; its labels are 3, 71" import ct.nrrd --mask other.nrrd:9 --out b.nrrd
nrrd uint8 0 >void.nrrd
refuse 2 "every voxel has label 0" import ct.nrrd --mask void.nrrd --out b.nrrd
nrrd uint8 1 | sed 's/sizes: 12 7 7/sizes: 7 12 7/' >turned.nrrd
refuse 2 "turned.nrrd: 7 x 12 x 7 voxels that are neither a part of the 12 x 7 x 7 voxels of ct.nrrd nor contain them" import ct.nrrd --mask turned.nrrd --out b.nrrd
nrrd uint8 1 | sed 's/(10,20,30)/(10,21,30)/' >moved.nrrd
refuse 2 "moved.nrrd: its grid does not align with ct.nrrd: along y its voxels are 2 mm apart from 21 mm on" import ct.nrrd --mask moved.nrrd --out b.nrrd
nrrd uint8 1 | sed 's/(2,0,0)/(2.1,0,0)/' >wide.nrrd
refuse 2 "along x its voxels are 2.1 mm apart" import ct.nrrd --mask wide.nrrd --out b.nrrd
nrrd float 'i == 3 ? 0.5 : 1' >parts.nrrd
refuse 2 "parts.nrrd: is not a label map" import ct.nrrd --mask parts.nrrd --out b.nrrd
refuse 2 "expected at most 128 labels from 0 to 32767 or names" import ct.nrrd --mask labels.nrrd:1,,2 --out b.nrrd
refuse 2 "expected at most 128 labels from 0 to 32767 or names" import ct.nrrd --mask labels.nrrd:40000 --out b.nrrd
refuse 2 "expected FILE or FILE:LABEL" import ct.nrrd --mask :1 --out b.nrrd
refuse 2 "nowhere.nrrd" import ct.nrrd --mask nowhere.nrrd:1 --out b.nrrd
refuse 2 "mask-fill needs --mask" import ct.nrrd --mask-fill --out b.nrrd
printf '0 0 0 500\n1 0 0 500\n0 1 0 500\n0 0 1 500\n' >ct.txt
refuse 2 "ct.txt: is a text; a mask needs a CT as NRRD, NIfTI or MetaImage" import ct.txt --mask labels.nrrd --out b.nrrd
refuse 2 "cut-ball '1,2,3': expected X,Y,Z,RADIUS" segment ct.nrrd --out b.nrrd --cut-ball 1,2,3
refuse 2 "cut-ball '1,2,3,0': expected X,Y,Z,RADIUS" segment ct.nrrd --out b.nrrd --cut-ball 1,2,3,0
refuse 2 "cut-plane '1,2,3,0,0,0': expected X,Y,Z,NX,NY,NZ" segment ct.nrrd --out b.nrrd --cut-plane 1,2,3,0,0,0
refuse 2 "a ball of 2000 mm" segment ct.nrrd --out b.nrrd --cut-ball 1,2,3,2000
refuse 2 "growth 130: expected at most the threshold, 120" segment ct.nrrd --out b.nrrd --growth 130
refuse 2 "separate 66: expected a depth from 0.001 to 65 mm" segment ct.nrrd --out b.nrrd --separate 66
refuse 2 "bone 'left': expected largest, all or a position" segment ct.nrrd --out b.nrrd --bone left
refuse 2 "bone 200,26,36: no bone within 10 mm; the nearest one is 172.0 mm away, at (28, 26, 36) mm" segment ct.nrrd --out b.nrrd --bone 200,26,36
refuse 2 "no bone of 8 mm3 or more reaches 501 HU" import ct.nrrd --min-volume 0 --threshold 501 --bone all --out b.nrrd
refuse 2 "growth from 130 HU on; expected 1 to the threshold, 120" import ct.nrrd --growth 130 --out b.nrrd
refuse 2 "cut-head 'left': expected auto or a position" segment ct.nrrd --out b.nrrd --cut-head left
refuse 2 "ct.txt: is a text; a mask needs" import ct.txt --bone largest --out b.nrrd
refuse 2 "options that select a bone need a file" import builtin:glenoid --bone largest --out b.nrrd
refuse 2 "--mask and options" import builtin:glenoid --mask labels.nrrd --out b.nrrd
refuse 2 "min-volume '-1': expected a volume" segment ct.nrrd --out b.nrrd --min-volume -1
refuse 2 "ct.txt" segment ct.txt --out b.nrrd
[ ! -e b.nrrd ] || fail "a refused command left b.nrrd"
finish
