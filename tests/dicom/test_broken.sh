#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Inverts bits of one file of a series, in each transfer syntax, and truncates the file at random positions. Each
# import must end soon, either with status 0, or with status 2, one line and no output, and never by a signal. The
# test prints its seed; OST_TEST_SEED repeats a run, and OST_TEST_LONG makes 200 files of each type.
# Covers: REQ-DICOM-CHILD
. "${srcdir:-.}/tests/dicom/lib.sh"

seed=${OST_TEST_SEED:-$(od -An -N3 -tu4 /dev/urandom | tr -d ' ')}
runs=6
[ -z "${OST_TEST_LONG:-}" ] || runs=200
echo "seed $seed"

# import_broken WORD...: imports a broken series
import_broken() {
    rm -rf ct bone.nrrd
    series ct dims=16,12,3 "$@" || return
    timeout 60 "$osteon" import ct --out bone.nrrd >out 2>err </dev/null
    status=$?
    checks=$((checks + 1))
    case $status in
    0) ;;
    2)
        [ "$(wc -l <err)" -eq 1 ] || fail "$*: standard error does not have one line: $(cat err)"
        [ ! -e bone.nrrd ] || fail "$*: a refused series left a bone"
        ;;
    *) fail "$*: status $status: $(head -c 300 err)" ;;
    esac
    if grep -qaE 'PLANTED|19010203|19730405' out err; then
        fail "$*: the output contains an identifying value: $(cat err)"
    fi
}

for kind in implicit explicit big deflated rle jpeg-sv1 jpeg-ls jpeg2000 'explicit multiframe=1' 'jpeg2000 multiframe=1'; do
    run=0
    while [ $run -lt $runs ]; do
        seed=$((seed + 1))
        # shellcheck disable=SC2086 # words
        import_broken syntax=$kind "flip=*:$seed*$((1 + run % 8 * 3))"
        # shellcheck disable=SC2086 # words
        [ $((run % 3)) -ne 0 ] || import_broken syntax=$kind "cut=*:$((seed * 7919 % 2500))"
        run=$((run + 1))
    done
done
finish
