#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes every fault of faults.list in a series of its own. Exit status and message must be those in the table of
# docs/reference/dicom.md. A message about a slice must begin with the name of the slice's file, and a refused series
# must leave no output. Every row of the table must have a fault in the list or in the tests that are named below. For
# faults that do not depend on the transfer syntax, the syntax changes from line to line; with OST_TEST_LONG, such a
# fault is made in every syntax. No message and no output may contain a value that identifies a person.
# Covers: REQ-DICOM-FAULTS, REQ-DICOM-PRIVACY
. "${srcdir:-.}/tests/dicom/lib.sh"

# words TEXT: prints a string without blanks at its ends
words() {
    printf '%s\n' "$1" | sed 's/^ *//; s/ *$//'
}

# make_fault FAULT SERIES OPTIONS SLICE STATUS: makes a fault and checks the result
make_fault() {
    rm -rf ct bone.nrrd
    printf '%s\n' "$2" | sed 's/ + /\n/' >parts
    while read -r part; do
        # shellcheck disable=SC2086 # words
        series ct $part
    done <parts
    # shellcheck disable=SC2086 # words
    timeout 60 "$osteon" import ct $3 --threshold 1 --out bone.nrrd >out 2>err </dev/null
    check "$1 ($2): status" $? "$5"
    documented "$1"
    checks=$((checks + 2))
    if [ "$5" -eq 0 ]; then
        [ -s bone.nrrd ] || fail "$1 ($2): no bone was written"
    else
        [ ! -e bone.nrrd ] || fail "$1 ($2): a refused series left a bone"
        [ "$(wc -l <err)" -eq 1 ] || fail "$1 ($2): standard error does not have one line: $(cat err)"
    fi
    [ -z "$4" ] || grep -q "^osteon import: ct/$(slice_file "$4")B\?: " err ||
        fail "$1 ($2): '$(cat err)' does not begin with $(slice_file "$4")"
    search_files out err
    [ ! -e bone.nrrd ] || search_files bone.nrrd
    list_searched ct --json
}

syntaxes='explicit implicit big deflated rle jpeg jpeg-sv1 jpeg-ls jpeg2000'
sed '/^#/d' "$source_folder/tests/dicom/faults.list" >list
line=0
while IFS='|' read -r fault series options slice status; do
    line=$((line + 1))
    case $series in
    *syntax=* | *photometric=* | *cut=* | *Rows=* | *Bits* | *NumberOfFrames=*) some= ;;
    *) some=$(echo "$syntaxes" | cut -d' ' -f $((line % 9 + 1))) ;;
    esac
    [ -z "$some" ] || [ -z "${OST_TEST_LONG:-}" ] || some=$syntaxes
    for syntax in ${some:-as-listed}; do
        [ "$syntax" = as-listed ] || set -- "$(printf '%s\n' "$series " | sed "s/^/ syntax=$syntax /; s/ + / + syntax=$syntax /")"
        [ "$syntax" != as-listed ] || set -- "$series"
        make_fault "$(words "$fault")" "$1" "$options" "$(words "$slice")" "$(words "$status")"
    done
done <list

# test_child.sh makes the faults of the parser. The other faults need a different build.
sed 's/ *|.*//' list >made
cat >>made <<'ROWS'
the parser crashes
the parser hangs
the parser needs too much memory
the parser answers nonsense
JPEG 2000 without OpenJPEG
built without DCMTK
ROWS
awk -F' [|] ' '/^## /{ on = $0 == "## Faults" } on && /^[|] / && ++row > 1 { sub(/^[|] /, ""); print $1 }' \
    "$source_folder/docs/reference/dicom.md" >rows
checks=$((checks + 2))
[ "$(wc -l <rows)" -gt 30 ] || fail "docs/reference/dicom.md has no table of faults"
grep -vxFf made rows >missing && fail "no test makes these faults: $(paste -s -d ';' missing)"
finish
