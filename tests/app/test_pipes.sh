#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests pipes: as input ("-", /dev/stdin, /dev/fd/N) and as output (-.nrrd, -.txt, -.stl). Data read from a
# pipe must give the same bone as the file, and data written to a pipe must have the same bytes as the file.
#
# Covers: REQ-PIPES
. "${srcdir:-.}/tests/app/lib.sh"

run 0 phantom glenoid --spacing 2 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 export ct.nrrd --out ct.txt
run 0 export ct.nrrd --out ct.mha
forms='nrrd txt mha'
if grep -q '^#define HAVE_NIFTI 1' "$build/config.h"; then
    run 0 export ct.nrrd --out ct.nii.gz
    forms="$forms nii.gz"
fi

# ---------------------------------------------------------------------- input
for form in $forms; do
    run 0 import ct.$form --out file.nrrd
    cat ct.$form | "$osteon" import - --out pipe.nrrd --quiet || fail "a pipe of $form"
    cmp -s file.nrrd pipe.nrrd || fail "a pipe of $form gives another bone"
    "$osteon" import - --out redirected.nrrd --quiet <ct.$form || fail "a redirected $form"
    cmp -s file.nrrd redirected.nrrd || fail "a redirected $form gives another bone"
    cat ct.$form | "$osteon" import /dev/stdin --out pipe.nrrd --quiet || fail "/dev/stdin with $form"
    cmp -s file.nrrd pipe.nrrd || fail "/dev/stdin with $form gives another bone"
    cat ct.$form | "$osteon" import /dev/fd/9 --out pipe.nrrd --quiet 9<&0 || fail "/dev/fd/9 with $form"
    cmp -s file.nrrd pipe.nrrd || fail "/dev/fd/9 with $form gives another bone"
done
cat bone.nrrd | "$osteon" info - --digest --json >out || fail "info of a pipe"
check "voxels of a pipe" "$("$json_get" solid_voxels <out)" "$("$osteon" info bone.nrrd --digest --json | "$json_get" solid_voxels)"

# refused_pipe TEXT ARGUMENT...: checks that a command whose standard input is a pipe with a NRRD file
# ends with status 2
refused_pipe() {
    text=$1
    shift
    checks=$((checks + 1))
    cat ct.nrrd | timeout 20 "$osteon" "$@" >out 2>err
    status=$?
    [ $status -eq 2 ] || fail "osteon $*: status $status"
    grep -qF -- "$text" err || fail "osteon $*: '$(cat err)' does not say '$text'"
}
refused_pipe "save it to a file first" ream --bone - --tool builtin:peg --path builtin:peg-hole --out o.nrrd
refused_pipe "save it to a file first" import ct.nrrd --mask /dev/stdin --out o.nrrd
refused_pipe "--set needs a file" info - --set side=left
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspacings: 1 1 1\ndata file: ct.txt\n' >d.nhdr
checks=$((checks + 1))
cat d.nhdr | "$osteon" import - --out o.nrrd 2>err && fail "a pipe names a file"
grep -q "a header from a pipe has no folder" err || fail "a pipe that names a file: $(cat err)"
checks=$((checks + 1))
printf '' | "$osteon" import - --out o.nrrd 2>err && fail "an empty pipe is a CT"
[ "$(wc -l <err)" -eq 1 ] || fail "an empty pipe: $(cat err)"
checks=$((checks + 1))
"$osteon" import - --out o.nrrd 2>err </dev/zero && fail "a device is a CT"
grep -q "expected a pipe" err || fail "a device: $(cat err)"
checks=$((checks + 1))
"$osteon" import - --out o.nrrd 2>err <&- && fail "a closed input is a CT"
# If there is no folder for the copy of the pipe, nothing may be read.
checks=$((checks + 1))
cat ct.nrrd | TMPDIR=$scratch/none "$osteon" import - --out o.nrrd 2>err && fail "a pipe without a folder for its copy"
grep -qF "$scratch/none" err || fail "a folder that is missing: $(cat err)"
[ ! -e o.nrrd ] || fail "a refused pipe made a file"

# --------------------------------------------------------------------- output
for form in nrrd txt stl; do
    run 0 export bone.nrrd --out file.$form
    "$osteon" export bone.nrrd --out -.$form | cat >pipe.$form
    cmp -s file.$form pipe.$form || fail "standard output differs from file.$form"
done
"$osteon" export ct.nrrd --out -.txt | "$osteon" import - --out through.nrrd --quiet
run 0 import ct.txt --out file.nrrd
cmp -s file.nrrd through.nrrd || fail "two commands in a pipe give another bone"
[ ! -e ./-.txt ] || fail "a file -.txt was made"
refuse 2 "both write standard output" export bone.nrrd --out -.nrrd --json
refuse 2 "-.nrrd writes standard output" export bone.nrrd --out -
finish
