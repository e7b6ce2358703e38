#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the files that osteon export writes for other programs: the removed bone as a mesh, the coordinate system
# stated in a mesh file, label maps, MetaImage, and a text file without empty voxels. Every file is read again.
#
# Covers: REQ-EXPORT
. "${srcdir:-.}/tests/app/lib.sh"
needs ASSIMP

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 tool peg --out peg.stl
run 0 ream --bone bone.nrrd --tool peg.stl --path builtin:peg-hole --out drilled.nrrd --json
removed=$("$json_get" removed_voxels <out)

# ------------------------------------------------------------ what was removed
# The expected number of removed voxels is that of osteon ream, which does not compare the two files.
for form in stl ply obj; do
    run 0 export drilled.nrrd --before bone.nrrd --out removed.$form --json
    check "removed voxels in $form" "$("$json_get" removed_voxels <out)" "$removed"
    volume=$("$json_get" volume_mm3 <out)
    run 0 info removed.$form --json
    check "open edges of removed.$form" "$("$json_get" open_edges <out)" 0
    # The coordinates of STL and PLY are float32, so the volume is equal to 0.1 per cent.
    check "volume of removed.$form" "$(awk "BEGIN { print ($volume / $("$json_get" volume_mm3 <out) - 1) ^ 2 < 1e-6 }")" 1
done
run 0 export drilled.nrrd --before bone.nrrd --out removed.nrrd
run 0 info removed.nrrd --digest --json
check "solid voxels of removed.nrrd" "$("$json_get" solid_voxels <out)" "$removed"
refuse 2 "nothing was removed" export bone.nrrd --before bone.nrrd --out none.stl
refuse 2 "differ in dims, spacing or origin" export ct.nrrd --before removed.nrrd --out none.stl
[ ! -e none.stl ] || fail "a refused export left none.stl"

# -------------------------------------------------------------- the mesh's frame
# 3D Slicer searches for this text in the 80 bytes of an STL and in the comments of a PLY and an OBJ.
run 0 export bone.nrrd --out bone.stl
run 0 export bone.nrrd --out bone.ply
run 0 export bone.nrrd --out bone.obj
check "coordinate system stated in the STL" "$(head -c 80 bone.stl | tr -d '\0' | grep -c 'SPACE=LPS')" 1
check "coordinate system stated in the PLY" "$(head -4 bone.ply | grep -a -c '^comment SPACE=LPS$')" 1
check "coordinate system stated in the OBJ" "$(head -1 bone.obj | grep -c '^#.*SPACE=LPS')" 1
# A tool has no position in the patient, so its file must not state a coordinate system.
check "coordinate systems stated in the STL of a tool" "$(head -c 80 peg.stl | grep -a -c 'SPACE')" 0
run 0 tool burr --out burr.obj
run 0 voxelize burr.obj --voxel 0.5 --out burr.nrrd

# ------------------------------------------------------------------- label maps
run 0 info bone.nrrd --digest --json
solid=$("$json_get" solid_voxels <out)
for form in nrrd nii.gz mha; do
    case $form in nii.gz) grep -q '^#define HAVE_NIFTI 1' "$build/config.h" || continue ;; esac
    run 0 export bone.nrrd --labels --out labels.$form
    run 0 import bone.nrrd --mask labels.$form:1 --out masked.nrrd --json
    check "voxels of labels.$form" "$("$json_get" mask_voxels <out)" "$solid"
done
check "fields Segment0_LabelValue in labels.nrrd" "$(grep -a -c '^Segment0_LabelValue:=1$' labels.nrrd)" 1
check "fields Segment0_Name in labels.nrrd" "$(grep -a -c '^Segment0_Name:=' labels.nrrd)" 1
check "fields of a second segment in labels.nrrd" "$(grep -a -c '^Segment1_' labels.nrrd)" 0
# Readers recognise a label map by these fields and do not interpolate it.
run 0 import labels.nrrd --threshold 1 --out back.nrrd --json
check "info reports a label map" "$("$json_get" labels <out)" true
refuse 2 "--labels needs" export bone.nrrd --labels --out labels.txt

# ------------------------------------------------------------------- MetaImage
run 0 export bone.nrrd --out bone.mha
run 0 import bone.mha --out again.nrrd
cmp -s bone.nrrd again.nrrd || fail "a bone that was exported as .mha and imported differs from the original"

# -------------------------------------------------------- text without empty voxels
run 0 export bone.nrrd --omit-empty --out sparse.txt
check "lines of sparse.txt" "$(grep -v -c '^#' sparse.txt)" "$solid"
run 0 import sparse.txt --out sparse.nrrd --json
check "voxels of sparse.txt" "$("$json_get" active_voxels <out)" "$solid"
refuse 2 "--omit-empty needs" export bone.nrrd --omit-empty --out sparse.nrrd
finish
