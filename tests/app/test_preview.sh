#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the option --preview of osteon import and osteon segment. It writes one picture of 1600 x
# 1000 pixels, whose bytes must depend neither on the backend nor on the number of threads nor on
# the folder of the CT. tests/app/test_preview checks what the pictures show.
# Covers: REQ-PREVIEW
. "${srcdir:-.}/tests/app/lib.sh"

run 0 phantom glenoid --out ct.nrrd
refuse 2 "must end in .png" import ct.nrrd --out bone.nrrd --preview p.jpg
refuse 2 "cannot write" import ct.nrrd --out bone.nrrd --preview absent/p.png
if ! "$osteon" devices | grep -q '^  png *yes'; then
    refuse 3 "without libpng" import ct.nrrd --out bone.nrrd --preview p.png
    check "files after a refused command" "$(ls)" "$(printf 'ct.nrrd\nerr\nout')"
    finish
fi

# size PNG: prints the width and the height in the header of the file
size() {
    od -An -tu1 -j16 -N8 "$1" | awk '{ print $3 * 256 + $4, $7 * 256 + $8 }'
}

run 0 import ct.nrrd --out bone.nrrd
plain=$(cksum <bone.nrrd)
run 0 import ct.nrrd --out bone.nrrd --preview p.png --threads 1 --json
check "name of the picture" "$(value preview)" p.png
check "size of the picture" "$(size p.png)" "1600 1000"
check "checksum of a bone written with --preview and without" "$(cksum <bone.nrrd)" "$plain"
first=$(cksum <p.png)
mkdir elsewhere
cp ct.nrrd elsewhere/other.nrrd
export OSTEON_ISA=scalar
run 0 import elsewhere/other.nrrd --out elsewhere/bone.nrrd --preview q.png --threads 3 --quiet
unset OSTEON_ISA
check "checksum of the picture with other threads, from another folder and with --quiet" "$(cksum <q.png)" "$first"
run 0 import ct.nrrd --out bone.nrrd --preview q.png --backend ref
check "checksum of the picture with the backend ref" "$(cksum <q.png)" "$first"
run 0 import ct.nrrd --out bone.nrrd --preview q.png --threshold 400
[ "$(cksum <q.png)" != "$first" ] || fail "the picture is the same with another threshold"
checks=$((checks + 1))

# Every type of CT must have a picture: a text file, a built-in CT, a bone, an empty CT, and a CT without
# orientation.
run 0 export ct.nrrd --out ct.txt
run 0 import ct.txt --out bone.nrrd --preview text.png
run 0 import builtin:glenoid --out bone.nrrd --preview builtin.png
run 0 import bone.nrrd --out again.nrrd --preview bone.png
run 0 import ct.nrrd --out empty.nrrd --threshold 30000 --preview empty.png
run 0 import ct.nrrd --out crop.nrrd --crop 5:40,5:60,5:30 --spacing 1 --cubic 0.8 --preview crop.png
printf 'NRRD0004\ntype: int16\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 2\nencoding: text\n\n' >bare.nrrd
awk 'BEGIN { for (i = 0; i < 64; i++) print i * 20 }' >>bare.nrrd
run 0 import bare.nrrd --out bone.nrrd --preview bare.png
run 0 segment bare.nrrd --out labels.nrrd --min-volume 0 --preview bare2.png
for name in text builtin bone empty crop bare bare2; do
    check "size of the picture of $name" "$(size $name.png)" "1600 1000"
done

# Tests a segmentation, with a part cut away, and an import of one label.
at=$("$osteon" info ct.nrrd --json | "$json_get" meta.glenoid_at_mm | tr ' ' ,)
run 0 segment ct.nrrd --out labels.nrrd
plain=$(cksum <labels.nrrd)
run 0 segment ct.nrrd --out labels.nrrd --preview s.png --json
check "name of the picture" "$(value preview)" s.png
check "checksum of labels written with --preview and without" "$(cksum <labels.nrrd)" "$plain"
run 0 segment ct.nrrd --out labels.nrrd --cut-ball "$at,6" --preview cut.png
[ "$(cksum <s.png)" != "$(cksum <cut.png)" ] || fail "the picture with a cut equals the picture without a cut"
checks=$((checks + 1))
run 0 import ct.nrrd --mask labels.nrrd:1 --out bone.nrrd --preview mask.png
check "sizes of the pictures" "$(size s.png) $(size cut.png) $(size mask.png)" "1600 1000 1600 1000 1600 1000"

# The CT may come from a pipe, and one of the two outputs may be standard output.
run 0 import ct.nrrd --out bone.nrrd --preview p.png
"$osteon" import - --out -.nrrd --preview q.png <ct.nrrd | cat >piped.nrrd
check "checksum of a bone written to a pipe and to a file" "$(cksum <piped.nrrd)" "$(cksum <bone.nrrd)"
"$osteon" import - --out bone.nrrd --preview -.png <ct.nrrd | cat >q.png
check "checksum of a picture written to a pipe and to a file" "$(cksum <q.png)" "$(cksum <p.png)"
refuse 2 "another output already" import ct.nrrd --out -.nrrd --preview -.png

# If the CT cannot be read, neither output file may remain.
mkdir none && cd none || exit 99
head -c 2000 ../ct.nrrd >short.nrrd
refuse 2 "short.nrrd" import short.nrrd --out bone.nrrd --preview p.png
refuse 2 "short.nrrd" segment short.nrrd --out labels.nrrd --preview p.png
check "files after a CT that cannot be read" "$(ls)" "$(printf 'err\nout\nshort.nrrd')"
finish
