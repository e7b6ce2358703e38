#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests slices that are not on an equidistant and straight grid, and slices that are ignored. With each option, the
# voxels of the result must follow a formula. The densities are linear in the position, so linear interpolation
# reproduces them wherever all neighbours exist. The test compares bones, because the options belong to import. The
# voxels of the bones are cubes of 0.5 mm, like those of the series, so that they are not resampled again.
# Covers: REQ-DICOM, AR-DCM-2, AR-DCM-3, AR-DCM-4, AR-DCM-5
. "${srcdir:-.}/tests/dicom/lib.sh"

# imports OPTIONS WORD...: imports a series whose densities are above the threshold of 1
imports() {
    options=$1
    shift
    rm -rf ct bone.nrrd
    series ct "$@" || return
    # shellcheck disable=SC2086 # words
    run 0 import ct $options --threshold 1 --out bone.nrrd
}

# Tests missing slices, and a displaced slice whose densities are those of its position, 1 + 20 z.
imports --even-slices smooth=10 intercept=1 drop=2
formula smooth=10 intercept=1 >expected
same_bone "a missing slice" bone.nrrd
imports --even-slices dims=8,6,9 smooth=10 intercept=1 drop=2 drop=5 drop=6 drop=7 syntax=jpeg-ls
formula dims=8,6,9 smooth=10 intercept=1 >expected
same_bone "missing slices" bone.nrrd
imports --even-slices smooth=10 intercept=1,11,21,31,41 values=0,3000 drop=2 multiframe=1
formula smooth=10 intercept=1,11,21,31,41 >expected
same_bone "a missing frame" bone.nrrd
imports --even-slices smooth=10 intercept=1,11,24,31,41 move=2:0.15
# The stored value contains 10 k, of which only the part of the position must remain.
formula smooth=10 intercept=1,11,21,31,41 >expected
awk '{ if ($3 == -29) { i = ($1 + 10.25) / 0.5; j = ($2 - 20.5) / 0.5; before = 10 * (i + j + 1) + 11; after = 10 * (i + j + 2) + 24
    v = (before * 0.15 + after * 0.5) / 0.65; low = int(v); if (v - low > 0.5) low++; $4 = low } print }' expected >moved
mv moved expected
same_bone "a slice that is displaced along z" bone.nrrd

# Tests a tilted gantry: slice k is displaced by k * tilt along the columns. Voxel Y of the straight grid is
# pixel Y - k * tilt / 0.5 of slice k, and the density 10 (i + j + k) + 1 becomes 10 (i + Y + k - k * tilt /
# 0.5) + 1.
# sheared TILT: prints the voxels between the first and the last row of each slice
sheared() {
    awk -v OFMT=%.12g -v tilt="$1" 'BEGIN {
        for (k = 0; k < 5; k++) for (Y = -20; Y < 40; Y++) for (i = 0; i < 8; i++) {
            j = Y - k * tilt / 0.5
            if (j >= 0 && j <= 5) print -10.25 + 0.5 * i, 20.5 + 0.5 * Y, -30 + 0.5 * k, 10 * (i + j + k) + 1
        }
    }' >expected
}
for tilt in 0.5 -0.5 0.25 -0.25 0.1; do
    imports --untilt smooth=10 intercept=1 tilt=$tilt
    sheared $tilt
    same_bone "a gantry tilted by $tilt mm for each slice" bone.nrrd
done
imports '--untilt --even-slices' smooth=10 intercept=1 tilt=0.5 drop=1 syntax=rle
# Slice 1 has bone where slices 0 and 2 have bone. Elsewhere it is a mixture with air, which is below the
# threshold.
sheared 0.5
awk '$3 != -29.5 || ($2 >= 21.5 && $2 <= 23)' expected >both && mv both expected
same_bone "a missing slice of a tilted gantry" bone.nrrd
imports --untilt smooth=10 intercept=1 shift=2:0.5,-1,0
awk 'BEGIN {
    for (k = 0; k < 5; k++) for (j = 0; j < 6; j++) for (i = 0; i < 8; i++)
        print -10.25 + 0.5 * (i + (k == 2)), 20.5 + 0.5 * (j - 2 * (k == 2)), -30 + 0.5 * k, 10 * (i + j + k) + 1
}' | sort -k3,3g -k2,2g -k1,1g >expected
same_bone "a slice that is displaced in its plane" bone.nrrd

# Ignored data must not change any voxel.
formula intercept=1 >expected
cp expected plain
for words in 'double=2:0 double=4:0' 'thickness=3' '+ prefix=loc dims=9,7,2 columns=0,0,-1 set=*:ImageType=ORIGINAL\PRIMARY\LOCALIZER'; do
    rm -rf ct bone.nrrd
    # shellcheck disable=SC2086 # words
    series ct intercept=1 ${words%%+*}
    # shellcheck disable=SC2086 # words
    [ "${words#+}" = "$words" ] || series ct ${words#+}
    run 0 import ct --threshold 1 --out bone.nrrd
    cp plain expected
    same_bone "$words" bone.nrrd
done

# Tests densities beyond int16.
imports --clamp bits=16 values=0,65535 slope=2 intercept=-100
formula bits=16 values=0,65535 slope=2 intercept=-100 | awk '{ if ($4 > 32767) $4 = 32767; if ($4 < 1) $4 = 0; print }' >expected
same_bone "--clamp" bone.nrrd
finish
