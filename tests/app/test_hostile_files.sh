#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Passes inputs that are not regular files to every reader of the command: a pipe without a writer,
# a folder, an endless device, a link to itself, and a missing file. Each command must end soon,
# with status 2 and one line that contains the name of the file.
# Covers: REQ-REGULAR-FILES
. "${srcdir:-.}/tests/app/lib.sh"

mkfifo pipe
mkdir folder
ln -s loop loop
ln -s /dev/zero zero

run 0 phantom glenoid --spacing 2 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 tool peg --out peg.ply
run 0 validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out bundle --quiet
mkdir dump
head -c 32 /dev/zero >key && chmod 600 key

# check_end STATUS STREAM FILE ARGUMENT...: checks that the command ends in time with this status, and
# that the file STREAM (out or err) contains the name FILE
check_end() {
    expected=$1
    stream=$2
    file=$3
    shift 3
    checks=$((checks + 1))
    timeout 20 "$osteon" "$@" >out 2>err </dev/null
    status=$?
    # A folder may contain a DICOM series, which a build without DCMTK cannot read.
    if [ "${kind:-}" = folder ] && grep -q 'built without DCMTK' err; then
        grep -q '^#define HAVE_DCMTK 1' "$build/config.h" || expected=3
    fi
    [ $status -eq "$expected" ] || fail "osteon $*: status $status, expected $expected: $(head -c 300 err)"
    checks=$((checks + 1))
    grep -qF -- "$file" "$stream" || fail "osteon $*: '$(head -c 300 "$stream")' does not contain the name $file"
}

# The name is passed in place of a file, with the suffix that selects the tested reader.
for kind in pipe folder zero loop absent; do
    for suffix in nrrd nhdr nii nii.gz hdr txt stl obj ply 3ds csv session; do
        rm -f "it.$suffix"
        [ $kind = absent ] || ln -s $kind "it.$suffix"
    done
    check_end 2 err it.nrrd import it.nrrd --out o.nrrd
    check_end 2 err it.nhdr import it.nhdr --out o.nrrd
    check_end 2 err it.nii import it.nii --out o.nrrd
    check_end 2 err it.txt import it.txt --out o.nrrd
    for mesh in stl obj ply 3ds; do check_end 2 err it.$mesh voxelize it.$mesh --out o.nrrd; done
    check_end 2 err it.txt info it.txt --digest
    check_end 2 err it.session info it.session
    check_end 2 err it.session replay it.session
    check_end 2 err it.nrrd render it.nrrd --out o.png
    check_end 2 err it.nrrd export it.nrrd --out o.txt
    check_end 2 err it.nrrd diff it.nrrd bone.nrrd
    check_end 2 err it.nrrd diff bone.nrrd it.nrrd
    check_end 2 err it.csv ream --bone bone.nrrd --tool builtin:peg --path it.csv --out o.nrrd
    check_end 2 err it.stl ream --bone bone.nrrd --tool it.stl --path builtin:peg-hole --out o.nrrd
    check_end 2 err it.nrrd ream --bone it.nrrd --tool builtin:peg --path builtin:peg-hole --out o.nrrd
    check_end 2 err it.csv sim --headless --bone bone.nrrd --device motion:it.csv
    check_end 2 err $kind sim --headless --bone bone.nrrd --device null --force-params $kind
    check_end 2 err $kind sim --headless --bone bone.nrrd --device udp:key=$kind
    check_end 2 err $kind validate --case $kind --backends cpu
    check_end 2 err it.nrrd validate --only user --cpu-only --ct it.nrrd --tool builtin:peg --path builtin:peg-hole
    check_end 2 err $kind verify $kind
    check_end 2 err $kind import ct.nrrd --backend plugin:$kind --out o.nrrd
    # Tests a NRRD header whose data file is not a regular file.
    printf 'NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nendian: little\nspacings: 1 1 1\ndata file: %s\n' "$kind" >points.nhdr
    check_end 2 err $kind import points.nhdr --out o.nrrd
    # Replaces a file of a bundle, a file of a shard and a file of a dump.
    for name in manifest.json audit.log protocol.json cases.jsonl report.html; do
        rm -rf damaged
        cp -r bundle damaged
        rm "damaged/$name"
        [ $kind = absent ] || cp -PR $kind "damaged/$name"
        # If a file is missing, osteon verify must report that the bundle is incomplete (status 2). If it is not a
        # regular file, osteon verify must report the name of the file (status 1).
        case $kind in
        absent) check_end 2 err damaged verify damaged ;;
        *) check_end 1 out "$name" verify damaged ;;
        esac
        case $name in
        protocol.json | cases.jsonl)
            check_end 2 err "damaged/$name" diff damaged bundle
            check_end 2 err "damaged/$name" diff bundle damaged
            ;;
        esac
        rm -rf some
        mkdir some
        mv damaged some/1
        check_end 2 err some validate --merge some --out merged
    done
    rm -f dump/dump.json
    [ $kind = absent ] || ln -s "../$kind" dump/dump.json
    check_end 2 err dump.json compare dump
done
checks=$((checks + 1))
[ ! -e o.nrrd ] && [ ! -e o.png ] && [ ! -e merged ] || fail "a command wrote an output although its input is not a regular file"

# A link to a file and standard input redirected from a file must be accepted.
ln -s ct.nrrd link.nrrd
run 0 import link.nrrd --out again.nrrd
cmp -s bone.nrrd again.nrrd || fail "the bone imported through a link differs from the bone imported from the file"
"$osteon" info /dev/stdin <ct.nrrd >out 2>err || fail "info refuses a redirected file: $(cat err)"
# A pipe as standard input must be refused with advice if it is given as an option's value instead of
# the operand (test_pipes.sh tests the other cases).
cat ct.nrrd | "$osteon" ream --bone /dev/stdin --tool builtin:peg --path builtin:peg-hole --out o.nrrd >out 2>err
check "exit status if the input of an option is a pipe" $? 2
grep -q "save it to a file first" err || fail "the error for a pipe contains no advice: $(cat err)"
finish
