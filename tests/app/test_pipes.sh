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
    cat ct.$form | "$osteon" import - --out pipe.nrrd --quiet || fail "import refuses a pipe with $form"
    cmp -s file.nrrd pipe.nrrd || fail "the bone from a pipe with $form differs from that of the file"
    "$osteon" import - --out redirected.nrrd --quiet <ct.$form || fail "import refuses standard input redirected from $form"
    cmp -s file.nrrd redirected.nrrd || fail "the bone from redirected $form differs from that of the file"
    cat ct.$form | "$osteon" import /dev/stdin --out pipe.nrrd --quiet || fail "import refuses /dev/stdin with $form"
    cmp -s file.nrrd pipe.nrrd || fail "the bone from /dev/stdin with $form differs from that of the file"
    cat ct.$form | "$osteon" import /dev/fd/9 --out pipe.nrrd --quiet 9<&0 || fail "import refuses /dev/fd/9 with $form"
    cmp -s file.nrrd pipe.nrrd || fail "the bone from /dev/fd/9 with $form differs from that of the file"
done
cat bone.nrrd | "$osteon" info - --digest --json >out || fail "info refuses a pipe"
check "solid voxels of info with a pipe and with the file" "$("$json_get" solid_voxels <out)" "$("$osteon" info bone.nrrd --digest --json | "$json_get" solid_voxels)"

# refused_pipe TEXT ARGUMENT...: checks that a command whose standard input is a pipe with a NRRD file
# ends with status 2
refused_pipe() {
    text=$1
    shift
    checks=$((checks + 1))
    cat ct.nrrd | timeout 20 "$osteon" "$@" >out 2>err
    status=$?
    [ $status -eq 2 ] || fail "osteon $*: status $status, expected 2"
    grep -qF -- "$text" err || fail "osteon $*: standard error '$(cat err)' does not contain '$text'"
}
refused_pipe "save it to a file first" ream --bone - --tool builtin:peg --path builtin:peg-hole --out o.nrrd
refused_pipe "save it to a file first" import ct.nrrd --mask /dev/stdin --out o.nrrd
refused_pipe "--set needs a file" info - --set side=left
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspacings: 1 1 1\ndata file: ct.txt\n' >d.nhdr
checks=$((checks + 1))
cat d.nhdr | "$osteon" import - --out o.nrrd 2>err && fail "import accepts a header from a pipe that refers to a data file"
grep -q "a header from a pipe has no folder" err || fail "wrong error for a header from a pipe that refers to a data file: $(cat err)"
checks=$((checks + 1))
printf '' | "$osteon" import - --out o.nrrd 2>err && fail "import accepts an empty pipe"
[ "$(wc -l <err)" -eq 1 ] || fail "the error for an empty pipe is not one line: $(cat err)"
checks=$((checks + 1))
"$osteon" import - --out o.nrrd 2>err </dev/zero && fail "import accepts a device as standard input"
grep -q "expected a pipe" err || fail "wrong error for a device as standard input: $(cat err)"
checks=$((checks + 1))
"$osteon" import - --out o.nrrd 2>err <&- && fail "import accepts a closed standard input"
# If there is no folder for the copy of the pipe, nothing may be read.
checks=$((checks + 1))
cat ct.nrrd | TMPDIR=$scratch/none "$osteon" import - --out o.nrrd 2>err && fail "import accepts a pipe although the folder for its copy does not exist"
grep -qF "$scratch/none" err || fail "the error does not contain the missing folder: $(cat err)"
[ ! -e o.nrrd ] || fail "a refused import left o.nrrd"

# --------------------------------------------------------------------- output
for form in nrrd txt stl; do
    run 0 export bone.nrrd --out file.$form
    "$osteon" export bone.nrrd --out -.$form | cat >pipe.$form
    cmp -s file.$form pipe.$form || fail "standard output differs from file.$form"
done
"$osteon" export ct.nrrd --out -.txt | "$osteon" import - --out through.nrrd --quiet
run 0 import ct.txt --out file.nrrd
cmp -s file.nrrd through.nrrd || fail "the bone that two commands write through a pipe differs from that of the file"
[ ! -e ./-.txt ] || fail "a file named -.txt was written"
refuse 2 "both write standard output" export bone.nrrd --out -.nrrd --json
refuse 2 "-: expected a format as well, such as -.nrrd for standard output" export bone.nrrd --out -
finish
