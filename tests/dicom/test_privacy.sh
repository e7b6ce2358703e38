#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests that no output contains data of a DICOM series that identify a person, a place or a time. make_series writes
# identifying values into every attribute that may have one. This test searches each output of each command on valid
# series for these values, byte by byte; test_faults.sh does so for broken series. Only the list of series may contain
# the description and the UID by which a series is chosen.
# Covers: REQ-DICOM-PRIVACY
. "${srcdir:-.}/tests/dicom/lib.sh"

# The search must find the values that make_series writes.
series ct dims=12,12,8
checks=$((checks + 1))
while read -r text; do
    grep -qaF "$text" ct/IM5 || fail "make_series does not plant '$text'"
done <planted

for format in nrrd nii nii.gz txt stl ply png; do
    says export ct --out "ct.$format"
    [ ! -e "ct.$format" ] || searched "ct.$format"
done
for format in nrrd nii.gz txt; do
    says import ct --out "bone.$format" --json
    [ -e "bone.$format" ] || fail "no bone.$format: $(cat err)"
    searched "bone.$format"
done
says import ct --out bone.nrrd
says import ct --out bone.nrrd --backend ref
says segment ct --out labels.nrrd --json
searched labels.nrrd
lists ct --json
lists ct
says info bone.nrrd --json
says info bone.nrrd
says info labels.nrrd
says ream --bone ct --tool builtin:peg --path builtin:peg-hole --at -8,22,-28 --axis 1,0,0 --out reamed.nrrd --record s.session --debrief d.html --json
for file in reamed.nrrd s.session d.html; do [ ! -e $file ] || searched $file; done

# Tests several series of several patients.
rm -rf ct
series ct number=3 description=first
series ct number=4 description=second prefix=b patient=2 study=2
says import ct --out bone.nrrd
lists ct
lists ct --json
says import ct --series 4 --out bone.nrrd --json
searched bone.nrrd
finish
