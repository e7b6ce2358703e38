#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests that outputs are complete or absent, and that equal grids give equal files, even if an
# output replaces an input.
# Covers: REQ-CLI-ATOMIC, AR-FILE-1
. "${srcdir:-.}/tests/app/lib.sh"

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd

# The chunk size, the number of threads and the absence of compression must not change any byte.
for chunk in 16 32 64; do
    run 0 import ct.nrrd --chunk $chunk --threads 1 --backend ref --out bone$chunk.nrrd
    cmp -s bone.nrrd bone$chunk.nrrd || fail "the bone imported with chunks of $chunk differs from bone.nrrd"
    run 0 ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --chunk $chunk --out reamed$chunk.nrrd
    cmp -s reamed16.nrrd reamed$chunk.nrrd || fail "the bone reamed with chunks of $chunk differs from reamed16.nrrd"
done
run 0 import ct.nrrd --compress --out small1.nrrd
sleep 1
run 0 import ct.nrrd --compress --out small2.nrrd
cmp -s small1.nrrd small2.nrrd || fail "two compressed files of the same grid differ"
run 0 diff bone.nrrd small1.nrrd

# When a bone is imported again, its threshold must not change.
run 0 import ct.nrrd --threshold 400 --out dense.nrrd
run 0 import dense.nrrd --out dense2.nrrd
cmp -s dense.nrrd dense2.nrrd || fail "a bone of threshold 400 HU differs after it was imported again"

# An output must not replace a file that another argument names, whatever the spelling of its name.
cp bone.nrrd same.nrrd
ln -s same.nrrd link.nrrd
ln same.nrrd hard.nrrd
peg_hole="--tool builtin:peg --path builtin:peg-hole"
for out in same.nrrd ./same.nrrd link.nrrd hard.nrrd; do
    refuse 2 "--out $out: argument 'same.nrrd' names the same file" ream --bone same.nrrd $peg_hole --out $out
    refuse 2 "argument '--bone=same.nrrd' names the same file" ream --out=$out $peg_hole --bone=same.nrrd
done
refuse 2 "argument 'ct.nrrd' names the same file" import ct.nrrd --out ct.nrrd
refuse 2 "argument 'same.nrrd:1' names the same file" import ct.nrrd --mask same.nrrd:1 --out same.nrrd
refuse 2 "argument 'same.nrrd' names the same file" export same.nrrd --out same.nrrd
refuse 2 "--out and --preview both name x.png" import ct.nrrd --out x.png --preview x.png
cmp -s bone.nrrd same.nrrd || fail "a refused output changed the file"
run 0 ream --record same.session --bone bone.nrrd $peg_hole --out reamed.nrrd
refuse 2 "--repair same.session: argument 'same.session' names the same file" info same.session --repair same.session
run 0 ream --bone bone.nrrd $peg_hole --out same.nrrd
cmp -s same.nrrd reamed32.nrrd || fail "ream does not replace a file that no other argument names"

# Every file format of the volume must give the same grid.
for form in nrrd nii.gz txt; do
    [ $form = nii.gz ] && ! "$osteon" devices | grep -q '^  nifti *yes' && continue
    run 0 export ct.nrrd --out form.$form
    run 0 import form.$form --out from_$form.nrrd
    run 0 diff bone.nrrd from_$form.nrrd
done

# A failure must leave existing files unchanged and create no other files.
printf '0 0 0 500\n1 0 0 oops\n' >broken.txt
cp bone.nrrd kept.nrrd
refuse 2 'broken.txt:2' import broken.txt --out kept.nrrd
cmp -s bone.nrrd kept.nrrd || fail "a failed import changed the existing output"
(
    ulimit -f 8
    "$osteon" import ct.nrrd --out limited.nrrd >/dev/null 2>limit_err
    echo $? >limit_status
)
check "exit status if the file size is limited" "$(cat limit_status)" 2
[ -e limited.nrrd ] && fail "an incomplete output remains"
check "temporary files after a failure" "$(ls -A | grep '\.part$')" ""
if [ -w /dev/full ]; then
    ln -s /dev/full full.nrrd
    run 2 import ct.nrrd --out full.nrrd
    grep -qE 'No space left|disk is full' err || fail "the error does not state that the device is full: $(cat err)"
    refuse 2 '/dev/full: the name must end in .nrrd, .nii, .nii.gz or .txt' import ct.nrrd --out /dev/full
fi

# If the command is killed at any moment, the file must be complete or absent, and no temporary file
# may remain.
run 0 export ct.nrrd --out whole.txt
for delay in 0.01 0.03 0.05 0.08 0.12 0.2; do
    "$osteon" export ct.nrrd --out killed.txt --quiet &
    sleep $delay
    kill -TERM $! 2>/dev/null
    wait $! 2>/dev/null
    [ -e killed.txt ] && ! cmp -s killed.txt whole.txt && fail "an incomplete output remains after SIGTERM"
    rm -f killed.txt
done
check "temporary files after SIGTERM" "$(ls -A | grep '\.part$')" ""
finish
