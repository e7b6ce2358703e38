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
    grep -qaF "$text" ct/IM5 || fail "make_series does not write '$text'"
done <identifying

for format in nrrd nii nii.gz txt stl ply png; do
    run_searched export ct --out "ct.$format"
    [ ! -e "ct.$format" ] || search_files "ct.$format"
done
for format in nrrd nii.gz txt; do
    run_searched import ct --out "bone.$format" --json
    [ -e "bone.$format" ] || fail "bone.$format was not written: $(cat err)"
    search_files "bone.$format"
done
run_searched import ct --out bone.nrrd
run_searched import ct --out bone.nrrd --backend ref
run_searched segment ct --out labels.nrrd --json
search_files labels.nrrd
list_searched ct --json
list_searched ct
run_searched info bone.nrrd --json
run_searched info bone.nrrd
run_searched info labels.nrrd
run_searched ream --bone ct --tool builtin:peg --path builtin:peg-hole --at -8,22,-28 --axis 1,0,0 --out reamed.nrrd --record s.session --debrief d.html --json
for file in reamed.nrrd s.session d.html; do [ ! -e $file ] || search_files $file; done

# Tests several series of several patients.
rm -rf ct
series ct number=3 description=first
series ct number=4 description=second prefix=b patient=2 study=2
run_searched import ct --out bone.nrrd
list_searched ct
list_searched ct --json
run_searched import ct --series 4 --out bone.nrrd --json
search_files bone.nrrd
finish
