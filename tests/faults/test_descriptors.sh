#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes one open or read of a command fail, because there is no descriptor or because of an I/O
# error. The status must be the status without the fault, or 2 or 3 with a message, and files must
# be right or absent. For osteon verify each call fails in turn, and the status must never be 1,
# which would mean that a bundle was changed. For other verbs that read files, randomly chosen calls
# fail, and the seed is printed; with OST_TEST_LONG=1 each call fails in turn. OST_TEST_ONLY=TEXT
# selects the commands that contain TEXT.
# Covers: REQ-REGULAR-FILES
. "${srcdir:-.}/tests/app/lib.sh"
. "$source_folder/tests/faults/lib.sh"

run 0 validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out bundle --quiet
runs=0
for errno in 24 5; do
    OST_FAIL_ERRNO=$errno walk_over --kind open -- verify "$scratch/bundle"
done
walk_over --kind read -- verify "$scratch/bundle"

make_inputs
sample 1

# each ARGUMENT...: runs `walk` on a command whose opens fail with EMFILE and with EIO
each() {
    OST_FAIL_ERRNO=24 walk_over --kind open --loose .session -- "$@"
    OST_FAIL_ERRNO=5 walk_over --kind open --loose .session -- "$@"
}
for kind in nrrd nii.gz txt; do
    each import "$in/ct.$kind" --out o.$kind
done
each voxelize "$in/peg.ply" --voxel 1 --out o.nrrd
each ream --bone "$in/bone.nrrd" --tool "$in/reamer.nrrd" --path builtin:glenoid-ream --rate 100 --out o.nrrd --record o.session
each replay "$in/today.session" --verify --out o.nrrd
each diff "$in/bone.nrrd" "$in/reamed.nrrd" --json
each render "$in/bone.nrrd" --tool "$in/reamer.nrrd" --size 64x48 --out o.png
each export "$in/today.session" --out o.csv
each export "$in/bone.nrrd" --out o.stl
for file in ct.nii.gz bone.nrrd peg.ply today.session; do
    each info "$in/$file" --digest --json
done
each compare cpu --only import/0
finish
