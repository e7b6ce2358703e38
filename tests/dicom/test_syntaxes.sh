#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests series in each transfer syntax, pixel format and orientation. The values and positions must be exactly those
# that series.h states. For a lossy syntax they must be within its error, and there must be a warning. By default, each
# pixel format is tested with one syntax per decoding function, and each axis of a slice is tested once. OST_TEST_LONG=1
# tests all pixel formats in every syntax, and every pair of axes.
# Covers: REQ-DICOM, AR-DCM-1
. "${srcdir:-.}/tests/dicom/lib.sh"

# imports WORD...: writes the series and compares every voxel
imports() {
    rm -rf ct
    series ct "$@" || return
    formula "$@" >expected
    same_voxels "$*" ct
}

long=${OST_TEST_LONG:-0}
lossless="implicit explicit big deflated rle jpeg jpeg-sv1 jpeg-ls jpeg2000"
for syntax in $lossless; do
    imports syntax=$syntax
    imports syntax=$syntax bits=16 values=0,33791
    imports syntax=$syntax bits=16 signed=1 values=-32000,32000 intercept=0
    imports syntax=$syntax bits=8 allocated=8 values=0,255 dims=7,5,3
    case $long$syntax in 1* | 0explicit | 0rle | 0jpeg-ls | 0jpeg2000) imports syntax=$syntax multiframe=1 ;; esac
done
# Signed pixels of 12 bits must be sign-extended. The encoders of DCMTK store all 16 bits.
for syntax in implicit explicit big deflated rle jpeg2000; do
    imports syntax=$syntax signed=1 values=-2048,2047 intercept=0
done
# Bits that are not stored are ignored, wherever they are.
all="implicit explicit big deflated rle"
[ "$long" = 1 ] || all="explicit big rle"
for syntax in $all; do
    imports syntax=$syntax junk=1
    imports syntax=$syntax junk=1 signed=1 values=-2048,2047 intercept=0
    imports syntax=$syntax junk=1 bits=10 high=12 values=0,1023
done
# Tests frames in several fragments, with and without a table of offsets. (RLE has one fragment per
# frame.)
for syntax in jpeg-sv1 jpeg-ls jpeg2000; do
    for offsets in 0 1; do
        imports syntax=$syntax dims=64,48,3 fragment=1 offsets=$offsets
    done
    imports syntax=$syntax dims=64,48,3 multiframe=1 offsets=0
    imports syntax=$syntax dims=64,48,3 multiframe=1 fragment=1
done

# Tests lossy syntaxes: JPEG of the highest quality, NEAR 2, and 80 dB. DCMTK changes both the values and the
# intercept.
# near ERROR WORD...: checks that every voxel deviates by at most ERROR
near() {
    most=$1
    shift
    rm -rf ct
    series ct "$@" || return
    formula "$@" >expected
    checks=$((checks + 1))
    voxels_of ct || fail "$*: $(cat err)"
    paste -d' ' voxels expected | awk -v most="$most" '
        { d = $4 - $8; if (d < 0) d = -d; if (d > greatest) greatest = d; if ($1 != $5 || $2 != $6 || $3 != $7) bad = 1 }
        END { print greatest + 0; exit bad || NR < 240 || greatest > most }' >greatest || fail "$*: an error of $(cat greatest)"
    grep -q 'compressed with loss' err || fail "$*: no warning: $(cat err)"
}
near 3 syntax=jpeg-baseline bits=8 allocated=8 values=0,255 smooth=5
near 3 syntax=jpeg-extended smooth=50
near 2 syntax=jpeg-ls-near smooth=50
near 3 syntax=jpeg2000-lossy smooth=50

# Tests rescaling by slice, padding as air, and the positions of voxels in every orientation along
# the axes.
imports slope=1,2,0.5 intercept=-1024,0,10.25
imports padding=0
imports padding=63,2000
imports padding=-2000,-1900 signed=1 bits=16 values=-1024,3000 intercept=0
imports spacing=0.46875,0.703125,1.25
if [ "$long" != 1 ]; then
    for axes in 1,0,0:0,0,-1 -1,0,0:0,1,0 0,1,0:0,0,1 0,-1,0:1,0,0 0,0,1:-1,0,0 0,0,-1:0,-1,0; do
        imports rows=${axes%:*} columns=${axes#*:} spacing=0.5,0.75,1.25
    done
    finish
fi
for rows in 1,0,0 -1,0,0 0,1,0 0,-1,0 0,0,1 0,0,-1; do
    for columns in 1,0,0 -1,0,0 0,1,0 0,-1,0 0,0,1 0,0,-1; do
        [ "${rows#-}" = "${columns#-}" ] || [ "$(echo $rows | tr -d -)" = "$(echo $columns | tr -d -)" ] ||
            imports rows=$rows columns=$columns spacing=0.5,0.75,1.25
    done
done
finish
