#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes one allocation of a command fail, for every verb. The command must end by itself, with the
# status that it has without the fault, or with 2 or 3 and a message. Its files must be right or
# absent, and no other file may remain. By default, randomly chosen allocations fail, and the seed
# is printed. With OST_TEST_LONG=1 each allocation fails in turn (200 for a campaign, which takes
# seconds). OST_TEST_ONLY=TEXT selects the commands that contain TEXT.
#
# The allocations of some libraries are excluded, because these libraries crash or end the program
# if an allocation fails: assimp, the run-time libraries of OpenMP, the drivers of OpenGL and
# OpenCL, libgcc_s, in which LLVM registers the code that it generates for OpenGL, and libcrypto
# (version 3.0.19, for about one in a hundred of the 4,700 allocations at its start).
# Covers: REQ-OUT-OF-MEMORY
. "${srcdir:-.}/tests/app/lib.sh"
. "$source_folder/tests/faults/lib.sh"

make_inputs
sample 2
ream="--bone $in/bone.nrrd --tool $in/reamer.nrrd --path builtin:glenoid-ream --rate 100 --threads 2"

walk_over -- phantom glenoid --spacing 1.5 --out o.nrrd
walk_over -- phantom glenoid --spacing 1.5 --out o.txt
walk_over -- tool reamer --out o.stl
walk_over -- tool burr --out o.ply
walk_over -- import "$in/ct.nrrd" --out o.nrrd --json
walk_over -- import "$in/ct.nii.gz" --out o.nii.gz
walk_over -- import "$in/ct.txt" --out o.txt
walk_over -- segment "$in/ct.nrrd" --fill --out o.nrrd --json
walk_over -- import "$in/ct.nrrd" --mask "$in/ct.nrrd" --mask-fill --out o.nrrd
walk_over -- voxelize builtin:peg --voxel 1 --out o.nrrd
walk_over -- voxelize "$in/peg.ply" --voxel 1 --out o.nrrd
walk_over -- ream $ream --out o.nrrd --json
walk_over --loose .session -- ream $ream --out o.nrrd --record o.session
walk_over -- replay "$in/today.session" --verify --out o.nrrd
walk_over -- replay "$in/today.session" --debrief o.html
walk_over --loose .session -- sim --headless --device script --no-clock --no-pin --seconds 0.05 --bone "$in/bone.nrrd" \
    --tool "$in/reamer.nrrd" --out o.nrrd --record o.session
walk_over -- diff "$in/bone.nrrd" "$in/reamed.nrrd" --json
walk_over -- diff "$in/bone.nrrd" "$in/reamed.nrrd" --html o.html
walk_over -- render "$in/bone.nrrd" --tool "$in/reamer.nrrd" --size 64x48 --out o.png
walk_over -- export "$in/today.session" --out o.csv
for kind in nrrd nii.gz txt stl ply png; do
    walk_over -- export "$in/bone.nrrd" --out o.$kind
done
walk_over -- export "$in/reamed.nrrd" --before "$in/bone.nrrd" --view en-face --size 200 --threads 2 --out o.png
for file in ct.txt ct.nii.gz bone.nrrd reamer.nrrd peg.ply today.session; do
    walk_over -- info "$in/$file" --digest --json
done
walk_over -- info "$in/today.session" --repair o.session
walk_over --loose-output -- devices --json
runs=1
[ -z "${OST_TEST_LONG:-}" ] || runs=200
walk_over --loose bundle -- validate --cpu-only --only mesh --jobs 1 --out bundle
sample 2
walk_over -- compare cpu --only import/0
walk_over -- validate --export-cases cases --only import/0
# A row that cannot run must be reported, and the other rows must run.
walk_over --loose-output -- bench --quick --suite tick --filter tick
finish
