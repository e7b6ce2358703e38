#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Nothing that identifies a person, a place or a time leaves a DICOM series. make_series plants such values in every
# attribute that may have one; here, each output of each command on valid and broken series is searched for them, byte
# by byte. Only the list of series contains the description and the UID by which a series is chosen.
# Covers: REQ-DICOM-PRIVACY
. "${srcdir:-.}/tests/dicom/lib.sh"

printf '%s\n' PLANTED 19010203 19730405 053107 098Y 2.25.777776 2.25.777771 2.25.777772 2.25.777773 >planted

# searched FILE...: searches files, unpacked if they are compressed, and their names
searched() {
    for file in "$@"; do
        checks=$((checks + 1))
        case $file in
        *.gz) gunzip -c "$file" ;;
        *) cat "$file" ;;
        esac >content
        echo "$file" >>content
        if grep -qaFf planted content; then
            fail "$file contains a planted value: $(grep -aFf planted content | head -c 300)"
        fi
    done
}

# says ARGUMENT...: runs a command with any status and searches what it prints
says() {
    "$osteon" "$@" >out 2>err </dev/null
    searched out err
}

# lists ARGUMENT...: the same for the list of series, which contains UIDs of series
lists() {
    "$osteon" info "$@" >list.out 2>err </dev/null
    sed -E 's/(UID |"uid": ")2\.25\.777772[0-9]+/\1/' list.out >out
    searched out err
}

# The search must find what make_series plants.
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

# Every fault, with its messages.
sed '/^#/d' "$source_folder/tests/dicom/faults.list" >list
while IFS='|' read -r fault series options slice status answer; do
    rm -rf ct bone.nrrd
    printf '%s\n' "$series" | sed 's/ + /\n/' >parts
    while read -r part; do
        # shellcheck disable=SC2086 # words
        series ct $part
    done <parts
    # shellcheck disable=SC2086 # words
    says import ct $options --out bone.nrrd
    [ ! -e bone.nrrd ] || searched bone.nrrd
    lists ct --json
done <list

# Several series of several patients.
rm -rf ct
series ct number=3 description=first
series ct number=4 description=second prefix=b patient=2 study=2
says import ct --out bone.nrrd
lists ct
lists ct --json
says import ct --series 4 --out bone.nrrd --json
searched bone.nrrd
finish
