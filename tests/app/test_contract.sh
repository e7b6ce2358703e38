#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the interface for scripts: the keys of --json, a single JSON object on standard output
# without other text, and --quiet.
# Covers: REQ-CLI-JSON
. "${srcdir:-.}/tests/app/lib.sh"

# The output must consist only of the JSON object: json_get accepts nothing after it, and the text
# for readers must be absent.
run 0 devices --json
has backends.0.name backends.0.available backends.0.reason backends.0.threads backends.0.isa backends.0.isas.0 backends.1.threads
run 0 phantom glenoid --out glenoid.nrrd --json
has dims.2 spacing_mm.2 seed sha256
check "glenoid's dims" "$(value dims.0) $(value dims.1) $(value dims.2)" "49 81 41"
check "glenoid's spacing" "$(value spacing_mm.0) $(value spacing_mm.1) $(value spacing_mm.2)" "0.47 0.47 1"
run 0 tool reamer --out reamer.stl --json
has triangles bounds_mm.0.0 bounds_mm.1.2
check "reamer's bounds" "$(value bounds_mm.0.0) $(value bounds_mm.1.0) $(value bounds_mm.1.2)" "-18 17.4 20.3"
run 0 tool peg --out peg.ply --json
has triangles bounds_mm
run 0 import glenoid.nrrd --out bone.nrrd --json
has rect_dims rect_spacing_mm cubic_dims chunk_dims chunks active_chunks active_voxels chunk_bytes stages.0.name stages.0.time_ms \
    stages.0.sha256 file_sha256
check "stages" "$(value stages.0.name) $(value stages.1.name) $(value stages.2.name)" "rect cubic chunks"
check "file_sha256" "$(value file_sha256)" "$(sha256sum bone.nrrd | cut -d' ' -f1)"
bone_voxels=$(value active_voxels)
chunks_digest=$(value stages.2.sha256)
run 0 info bone.nrrd --json
has kind dims spacing_mm meta.threshold meta.glenoid_at_mm
check "kind of a bone" "$(value kind)" bone
run 0 info bone.nrrd --digest --json
check "digest of info and of import" "$(value sha256)" "$chunks_digest"
check "solid voxels of info and bone voxels of import" "$(value solid_voxels)" "$bone_voxels"

need_part assimp "no meshes without assimp"
run 0 voxelize reamer.stl --voxel 1 --out reamer.nrrd --json
has dims solid_voxels triangles dropped_triangles leaking_rows sha256 time_ms
tool_digest=$(value sha256)
run 0 info reamer.nrrd --digest --json
check "kind of a tool" "$(value kind)" tool
check "digest of info and of voxelize" "$(value sha256)" "$tool_digest"
run 0 info reamer.stl --json
check "kind of a mesh" "$(value kind)" mesh
# Shafts of built-in tools do not cut. The burr cuts with its sphere of 6 mm, which has 905 voxels
# of 0.5 mm. The reamer cuts with everything except its hub. The complete peg cuts.
run 0 voxelize builtin:burr --voxel 0.5 --out burr.nrrd --json
check "the burr has 881 to 929 cutting voxels" "$(awk -v n="$(value cutting_voxels)" 'BEGIN { print (n > 880 && n < 930) }')" 1
check "the shaft of the burr has 431 to 559 voxels that do not cut" "$(awk -v n="$(value solid_voxels)" -v m="$(value cutting_voxels)" 'BEGIN { print (n - m > 430 && n - m < 560) }')" 1
run 0 voxelize builtin:peg --voxel 0.5 --out peg.nrrd --json
check "cutting voxels and solid voxels of the peg" "$(value cutting_voxels)" "$(value solid_voxels)"
run 0 tool reamer --out whole.stl
run 0 voxelize whole.stl --voxel 0.5 --out whole.nrrd --json
solid=$(value solid_voxels)
run 0 voxelize builtin:reamer --voxel 0.5 --out parts.nrrd --json
check "solid voxels of the reamer and of its two meshes" "$(value solid_voxels)" "$solid"
check "80 to 95 % of the reamer's voxels cut" "$(awk -v n="$(value cutting_voxels)" -v m="$solid" 'BEGIN { print (n < 0.95 * m && n > 0.8 * m) }')" 1
run 0 tool peg --out peg.stl
run 0 voxelize peg.stl --voxel 0.5 --out peg2.nrrd --json
peg_digest=$(value sha256)
run 0 voxelize builtin:peg --voxel 0.5 --out peg.nrrd --json
check "digest of a built-in tool and of its mesh file" "$(value sha256)" "$peg_digest"

# Tests the main workflow in one command: drilling the hole, then reaming.
run 0 ream --bone bone.nrrd --tool peg.ply --path builtin:peg-hole --tool reamer.nrrd --path builtin:glenoid-ream --out reamed.nrrd --json
has ticks removals removed_voxels removed_mm3 removed_by_class.0.name removed_by_class.0.voxels removed_by_class.0.mm3 tick_us.p50 tick_us.p99 \
    tick_us.max sha256 file_sha256
removed=$(value removed_voxels)
[ "$removed" -gt 0 ] || fail "drilling and reaming removed no voxel"
check "active voxels before minus removed voxels, and active voxels after" "$(($(value active_voxels_before) - removed))" "$(value active_voxels)"
sum=0
for class in 0 1 2; do sum=$((sum + $(value removed_by_class.$class.voxels))); done
check "sum of the classes and number of removed voxels" "$sum" "$removed"
run 1 diff bone.nrrd reamed.nrrd --json
has equal different_voxels chunks.0.chunk chunks.0.different_voxels classes.0.name classes.0.voxels voxels.0.ijk
check "voxels that differ according to diff, and voxels that ream removed" "$(value different_voxels)" "$removed"
check "first class of diff and its voxels" "$(value classes.0.name) $(value classes.0.voxels)" "removed $removed"
run 0 diff bone.nrrd bone.nrrd --json
check "diff of a file with itself: equal, different voxels, chunks" "$(value equal) $(value different_voxels) $(value chunks)" "true 0 [0]"
run 0 export reamed.nrrd --out reamed.stl --json
has triangles volume_mm3
# The same command, directly from the CT and with built-in tools, must give the same grid.
run 0 ream --bone glenoid.nrrd --tool builtin:peg --path builtin:peg-hole --tool builtin:reamer --voxel 0.5 --out direct.nrrd \
    --path builtin:glenoid-ream --json
[ "$(value removed_voxels)" -gt 0 ] || fail "ream with a CT as input removed no voxel"

# Tests path files: the output of info, and a tool that never comes near the bone.
printf 't_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,5000,0,0,1,0,0,0\n0.001,5000,0,0,1,0,0,0\n' >far.csv
run 0 info far.csv --json
check "kind and ticks of a path file" "$(value kind) $(value ticks)" "path 2"
run 0 ream --bone bone.nrrd --tool reamer.nrrd --path far.csv --out far.nrrd
grep -q 'no bone was removed' err || fail "there is no warning that no bone was removed: $(cat err)"
run 0 diff bone.nrrd far.nrrd
refuse 2 'uses tool' ream --bone bone.nrrd --tool reamer.nrrd --path bad.csv --out x.nrrd <<X
$(printf 't_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool\n0,0,0,0,1,0,0,0,3\n' >bad.csv)
X

# For a bone without a glenoid, --at and --axis are required.
ct_text 20 20 20 0.5 '(i > 4 && i < 15) ? 500 : 0' >block.txt
refuse 2 'pass --at X,Y,Z and --axis X,Y,Z' ream --bone block.txt --tool builtin:peg --path builtin:peg-hole --out x.nrrd
refuse 2 'pass --axis X,Y,Z' ream --bone block.txt --tool builtin:peg --path builtin:peg-hole --at 2,5,5 --out x.nrrd
run 0 ream --bone block.txt --tool builtin:peg --path builtin:peg-hole --at 2,5,5 --axis 1,0,0 --out x.nrrd --json
[ "$(value removed_voxels)" -gt 0 ] || fail "the peg removed no voxel of a block"

# --quiet prints nothing.
run 0 import glenoid.nrrd --out quiet.nrrd --quiet
check "output with --quiet" "$(cat out err)" ""
finish
