#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the verdicts of osteon diff for grids with one deliberate difference each.
# Covers: REQ-CLI-DIFF
. "${srcdir:-.}/tests/app/lib.sh"

# grid NAME DENSITY [NX NY NZ SPACING]: makes a bone from an awk expression of i, j, k
grid() {
    ct_text "${3:-20}" "${4:-18}" "${5:-16}" "${6:-0.5}" "$2" >text.txt
    run 0 import text.txt --spacing "${6:-0.5}" --threshold 1 --out "$1.nrrd"
}

# check_pattern NAME B: checks that diff of a and B reports the pattern
check_pattern() {
    run 1 diff a.nrrd "$2.nrrd" --json || return
    check "$2: equal" "$(value equal)" false
    checks=$((checks + 1))
    grep -q "\"name\": \"$1\"" out || fail "$2: diff does not report the pattern $1, but$(grep '"text"' out)"
}

# check_no_pattern NAME B: checks that diff of a and B does not report the pattern
check_no_pattern() {
    run 1 diff a.nrrd "$2.nrrd" --json
    checks=$((checks + 1))
    grep -q "\"name\": \"$1\"" out && fail "$2: diff reports the pattern $1, which does not apply"
}

# The body is asymmetric, and each of its voxels has a different density from its neighbours.
body='(i >= 3 && i < 15 && j >= 4 && j < 13 && k >= 2 && k < 13) ? 200 + i + 20 * j + 3 * k * k : 0'
grid a "$body"
run 0 diff a.nrrd a.nrrd
grep -q '^equal:' out || fail "diff of a bone with itself does not report equal: $(cat out)"

grid hole "(i == 7 && j > 5) ? 0 : ($body)"
check_pattern only-removed hole
check "hole: removed voxels" "$(value classes.0.voxels)" $((7 * 11))
check "hole: added voxels" "$(value classes.1.voxels)" 0
check "hole: first differing voxel and its density" "$(value voxels.0.ijk.0) $(value voxels.0.ijk.1) $(value voxels.0.ijk.2) $(value voxels.0.b)" "7 6 2 0"
check_no_pattern boundary-layer hole
check_no_pattern speckle hole
check_no_pattern shift hole

grid grown "(i == 2 && j >= 4 && j < 13 && k >= 2 && k < 13) ? 300 : ($body)"
check_pattern only-added grown
check_pattern boundary-layer grown
grid peeled "(i == 3) ? 0 : ($body)"
check_pattern boundary-layer peeled
grid lighter "(($body) > 0) ? ($body) - 7 : 0"
check_pattern offset lighter
check "lighter: changed voxels" "$(value classes.2.voxels)" $((12 * 9 * 11))
grid cut "(($body) >= 500) ? ($body) : 0"
check_pattern threshold cut
grid specks "(i % 4 == 3 && j % 4 == 0 && k % 4 == 2) ? 0 : ($body)"
check_pattern speckle specks
grid moved "(i >= 5 && i < 17 && j >= 3 && j < 12 && k >= 2 && k < 13) ? 200 + (i - 2) + 20 * (j + 1) + 3 * k * k : 0"
check_pattern shift moved
grep -q '(2, -1, 0)' out || fail "moved: diff does not report the displacement (2, -1, 0): $(grep text out)"
check_no_pattern axis-swap moved

# Exchanging x and z also changes the dimensions. This must be distinguished from a grid that
# differs only in its dimensions.
grid turned '(k >= 3 && k < 15 && j >= 4 && j < 13 && i >= 2 && i < 13) ? 200 + k + 20 * j + 3 * i * i : 0' 16 18 20
check_pattern axis-swap turned
check "turned: number of different voxels (null, because the dimensions differ)" "$(value different_voxels)" null
grid other "$body" 21 18 16
check_pattern geometry other
check_no_pattern axis-swap other
grid wider "$body" 20 18 16 0.6
check_pattern geometry wider
check "wider: differing voxels" "$(value different_voxels)" 0
grid flipped '(i >= 5 && i < 17 && j >= 4 && j < 13 && k >= 2 && k < 13) ? 200 + (19 - i) + 20 * j + 3 * k * k : 0'
check_pattern axis-swap flipped

# Swapping the two bytes of 513 (0x0201) gives 258 (0x0102).
grid a '(i > 3 && i < 9 && j > 2) ? 258 : 0'
grid swapped '(i > 3 && i < 9 && j > 2) ? 513 : 0'
check_pattern byte-order swapped

# Tests a grid in which complete chunks are lost.
grid a '(i >= 4 && j >= 4 && k >= 4) ? 300 : 0' 40 36 34
grid lost '(i >= 4 && j >= 4 && k >= 4 && !(i >= 32 && j < 32 && k < 32)) ? 300 : 0' 40 36 34
check_pattern lost-chunk lost
check "lost: number of lost chunks and index of the first" "$(value chunks) $(value chunks.0.chunk.0)" "[1] 1"

# Tests types of files that cannot be compared, and invalid files.
run 0 voxelize builtin:peg --out peg.nrrd
run 0 voxelize builtin:peg --voxel 0.6 --out peg6.nrrd
run 0 diff peg.nrrd peg.nrrd
run 1 diff peg.nrrd peg6.nrrd
refuse 2 'is a tool' diff a.nrrd peg.nrrd
refuse 2 'text.csv' diff a.nrrd text.csv

# The page must be complete and self-contained, and must also be written for equal grids.
grid a "$body"
run 1 diff a.nrrd hole.nrrd --html page.html --limit 5
checks=$((checks + 1))
grep -q '</html>' page.html || fail "the page has no end tag"
grep -qE 'src="(http|file|/)' page.html && fail "the page needs other files"
check "rows of removed voxels in the page" "$(grep -c ' mm</td>.*<td>removed</td>' page.html)" 5
if "$osteon" devices | grep -q '^  png *yes'; then
    check "pictures in the page" "$(grep -c 'data:image/png;base64,' page.html)" 4
    run 1 diff hole.nrrd a.nrrd --html page.html # nothing is removed, so there is no view of it
    check "pictures in the page" "$(grep -c 'data:image/png;base64,' page.html)" 3
    run 0 diff peg.nrrd peg.nrrd --html page.html
    check "pictures in the page of a tool" "$(grep -c 'data:image/png;base64,' page.html)" 3
fi
run 0 diff a.nrrd a.nrrd --html page.html
refuse 2 '.html' diff a.nrrd a.nrrd --html page.pdf

# Notes must be reported and have no effect on the verdict.
run 0 import text.txt --spacing 0.5 --threshold 100 --out noted.nrrd
run 0 import text.txt --spacing 0.5 --threshold 1 --out plain.nrrd
run 0 diff noted.nrrd plain.nrrd --json
check "key and values of the differing note" "$(value notes.0.key) $(value notes.0.a) $(value notes.0.b)" "threshold 100 1"
finish
