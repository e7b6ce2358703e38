#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests a folder with several series: they are listed, and one of them is chosen by number, description or UID. Nested
# folders, names of any form, files that are not DICOM and a DICOMDIR must have no effect.
# Covers: REQ-DICOM-CHOICE
. "${srcdir:-.}/tests/dicom/lib.sh"

series ct number=3 description='thin bone' kernel=B70s
series ct number=4 prefix=a. description='thick soft' dims=9,6,4 spacing=0.5,0.5,2 kernel=B31s
series ct/deeper/still number=5 prefix='a b' description='thin bone' dims=7,6,4

refuse 2 'ct: contains 3 series that are volumes (numbers 3, 4, 5)' import ct --out x.nrrd
run 0 info ct
for text in 'thin bone' 'thick soft' B70s B31s; do
    checks=$((checks + 1))
    grep -qF "$text" out || fail "the list does not contain '$text': $(cat out)"
done
formula dims=9,6,4 spacing=0.5,0.5,2 >expected
for choice in 4 'thick soft' 2.25.7777721004; do
    run 0 info ct --series "$choice" --json
    check "dims of series $choice" "$(value dims.0) $(value dims.1) $(value dims.2)" "9 6 4"
done
refuse 2 'thin bone' import ct --series 'thin bone' --out x.nrrd
refuse 2 '77' import ct --series 77 --out x.nrrd
[ ! -e x.nrrd ] || fail "a refused import left x.nrrd"

# Tests one series among other files, in nested folders, with misleading names.
rm -rf ct
series ct/one prefix=x.nrrd drop=1 drop=3
series ct/two/three prefix='slice;*' drop=0 drop=2 drop=4
printf 'nothing\n' >ct/README
printf 'DICM' >ct/DICM
head -c 200 /dev/zero >ct/two/zeros
mkdir ct/empty
ln -s .. ct/two/up
ln -s nowhere ct/two/broken
formula >expected
same_voxels "nested folders" ct
# Other entries of the folder must not be opened: a pipe would block the reader.
mkfifo ct/pipe
ln -s /dev/zero ct/zero
checks=$((checks + 1))
timeout 60 "$osteon" export ct --out voxels.txt >out 2>err || fail "a pipe in the folder: status $?: $(cat err)"

# A DICOMDIR has the same meaning as its folder, whose files it lists.
series index dims=8,6,1 prefix=D remove=*:PixelData remove=*:Rows set=*:SOPClassUID=1.2.840.10008.1.3.10
mv index/D5 ct/DICOMDIR
same_voxels "a folder with a DICOMDIR" ct
same_voxels "a DICOMDIR" ct/DICOMDIR

# A single file is read alone: all frames of a multi-frame image are read, but a slice of a series
# of files is refused.
series multi multiframe=1
same_voxels "a file with several frames" multi/IM5
refuse 2 'a volume needs at least two slices' export ct/one/x.nrrd5 --out x.nrrd

# Tests folders that are nested too deeply, and an empty folder.
deep=deep/1/2/3/4/5/6/7/8/9/10/11/12/13/14/15/16/17/18
mkdir -p $deep
refuse 2 'folders deep' export deep --out x.nrrd
refuse 2 'the folder contains no file' export ct/empty --out x.nrrd
[ ! -e x.nrrd ] || fail "a refused export left x.nrrd"
finish
