#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One open or read of osteon verify fails, each in turn (no descriptor, an I/O error): the status is
# the one without the fault, or 2 with a message; never 1, the status of a bundle that was changed.
# Covers: REQ-REGULAR-FILES
. "${srcdir:-.}/tests/app/lib.sh"

library=$build/.libs/fault_inject.so
walk=$build/tests/faults/walk
[ -r "$library" ] || { echo "skipped: built without shared libraries"; exit 77; }
[ -z "${OST_SAN_CFLAGS:-}" ] || { echo "skipped: a sanitizer's runtime must be the first library"; exit 77; }
export OCL_ICD_VENDORS="$scratch/none"
mkdir "$OCL_ICD_VENDORS"
run 0 validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out bundle --quiet
for errno in 24 5; do
    checks=$((checks + 1))
    OST_FAIL_ERRNO=$errno "$walk" --kind open --runs 0 "$library" "$osteon" verify "$scratch/bundle" || fail "verify, opens fail with errno $errno"
done
checks=$((checks + 1))
"$walk" --kind read --runs 0 "$library" "$osteon" verify "$scratch/bundle" || fail "verify, reads fail"
finish
