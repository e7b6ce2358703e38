#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests validation/try-patch. A patch that changes a result must be detected, located and
# reproduced by the command that try-patch prints. A patch that changes no result must not be
# detected. A patch that does not apply or compile must be refused. The tree and the build must
# not change.
# Covers: REQ-TRY-PATCH
. "${srcdir:-.}/tests/app/lib.sh"

for tool in python3 patch make diff; do
    command -v $tool >/dev/null || { echo "skipped: no $tool"; exit 77; }
done
[ -f "$build/config.status" ] && [ -f "$build/osteon" ] || { echo "skipped: no build folder"; exit 77; }

file=src/cpu/import/ct.c
before=$(cksum "$source_folder/$file" "$build/osteon")

# make_patch NAME FROM TO: makes NAME.patch, which replaces FROM by TO in the file
make_patch() {
    mkdir -p a/src/cpu/import b/src/cpu/import
    cp "$source_folder/$file" a/$file
    check "$1: lines to change" "$(grep -cF -- "$2" a/$file)" 1
    awk -v from="$2" -v to="$3" '{
        at = index($0, from)
        if (at) $0 = substr($0, 1, at - 1) to substr($0, at + length(from))
        print
    }' a/$file >b/$file
    diff -u a/$file b/$file >"$1.patch"
}

# run_try_patch STATUS ARGUMENT...: runs try-patch and checks its exit status
run_try_patch() {
    expected=$1
    shift
    "$source_folder/validation/try-patch" --build "$build" --jobs 1 --keep "$scratch" --only import/0 --backends cpu:threads=1 "$@" >out 2>err
    check "try-patch $*: status" $? "$expected"
}

# check_text TEXT FILE: checks that FILE contains TEXT
check_text() {
    checks=$((checks + 1))
    grep -qF -- "$1" "$2" || fail "'$1' is not in: $(cat "$2")"
}

make_patch noticed 'report->duplicates++;' 'report->duplicates += 2;'
run_try_patch 0 noticed.patch
check_text 'noticed.patch: NOTICED by case import/0 at stage rect on cpu:threads=1' out
check_text 'class report-only; duplicates' out
again=$(sed -n 's/^  again: //p; s/^  reduced to .*: \(.* validate --case .*\)/\1/p' out | head -n 1)
sh -c "$again" >again.out 2>&1
check "the printed command: $again" $? 1

make_patch message 'out of memory to place %d samples' 'out of memory to put %d samples'
run_try_patch 1 message.patch
check_text 'NOT NOTICED: tier smoke, seed 1, --only import/0; equal on cpu:threads=1' out

make_patch broken 'report->duplicates++;' 'report->duplicates = no_such_name;'
run_try_patch 2 broken.patch
check_text 'broken.patch: does not compile: ' err
check_text 'no_such_name' err
check "lines for what does not compile" "$(wc -l <err | tr -d ' ')" 1

sed 's/report->duplicates++;/report->duplicates--;/' noticed.patch >stale.patch
run_try_patch 2 stale.patch
check_text 'stale.patch: does not apply: ' err
run_try_patch 2 stale.patch --keep "$scratch/new/folder"
check_text 'stale.patch: does not apply: ' err
run_try_patch 2 stale.patch --keep "$scratch/stale.patch/folder"
check_text '/stale.patch/folder: cannot be made: ' err
check "lines for a folder that cannot be made" "$(wc -l <err | tr -d ' ')" 1
run_try_patch 2 absent.patch
check_text 'absent.patch: is no file' err
"$source_folder/validation/try-patch" --build "$scratch" noticed.patch 2>err
check "no build folder: status" $? 2
check_text 'is no build folder of osteon' err

check "checksums of the source file and of the program" "$(cksum "$source_folder/$file" "$build/osteon")" "$before"
finish
