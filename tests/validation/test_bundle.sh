#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests bundles of evidence: they are written completely or not at all, verified offline, and
# identical for repeated runs and for shards; every changed byte is detected.
# Covers: REQ-EVIDENCE
. "${srcdir:-.}/tests/app/lib.sh"

one='cpu:isa=scalar,threads=1'

# Makes a bundle with the eight import cases of the smoke tier.
run 0 validate --only import/ --backends "$one" --out b --json
check "campaign of eight cases: equal" "$(value equal)" true
check "campaign of eight cases: evidence" "$(value evidence)" false
check "number of cases" "$(value cases)" 8
run 0 verify b --rerun --json
check "verify: valid" "$(value valid)" true
check "verify --rerun: rerun" "$(value rerun)" true
refuse 2 "exists" validate --only import/ --backends "$one" --out b
refuse 2 "no case of tier smoke has a name that starts with" validate --only nothing --out c
refuse 2 "must be I/N" validate --shard 3/2 --out c
refuse 2 "plonk" validate --backends plonk --out c
refuse 2 "--worker needs --trace or --dump" validate --worker ref
refuse 2 "not a folder" verify nowhere
# If only the reference runs, nothing is compared, and no file may state that anything is equal.
run 3 validate --only import/0 --backends ref --out alone
check "error of a campaign with only the reference" "$(cat err)" "osteon validate: nothing was compared: no backend other than the reference ran a case that the reference accepted"
check "verdict printed by a campaign with only the reference" "$(sed -n 's/^  verdict  *//p' out)" "NOT COMPARED (a reduced run: no evidence)"
check "verdict in the bundle with only the reference" "$("$json_get" verdict <alone/results.json)" "NOT COMPARED"
"$osteon" verify alone >out 2>err
check "verify of the bundle with only the reference: exit status, output" "$? $(cut -d, -f1 out)" "0 alone: valid; it says NOT COMPARED"
mkdir empty
run 2 verify empty
grep -q "manifest.json is missing" out || fail "wrong message for an empty folder: $(cat out)"
[ ! -e c ] || fail "a refused campaign left the folder c"
check "unfinished folders next to the bundle" "$(find . -maxdepth 1 -name '*.part-*' | wc -l | tr -d ' ')" 0

# check_detected STATUS WHAT NAME: checks that verify reports the folder x as changed (1) or incomplete (2)
# and names the file NAME. For every file, the first byte, the middle byte and the last byte are
# changed.
check_detected() {
    checks=$((checks + 1))
    "$osteon" verify x >out 2>err
    status=$?
    [ $status -eq "$1" ] || fail "$2: verify ended with $status, expected $1"
    grep -q -- "$3" out || fail "$2: the output '$(cat out)' does not contain the name $3"
}
for file in $(cd b && find . -type f | sed 's,^\./,,'); do
    size=$(wc -c <b/"$file" | tr -d ' ')
    for at in 0 $((size / 2)) $((size - 1)); do
        rm -rf x
        cp -r b x
        # One bit of the byte is flipped.
        byte=$(od -An -tu1 -j "$at" -N 1 b/"$file" | tr -d ' ')
        # shellcheck disable=SC2059 # a deliberate octal escape
        printf "\\$(printf %03o $((byte ^ 1)))" | dd of=x/"$file" bs=1 seek="$at" conv=notrunc 2>/dev/null
        # A change in the manifest may be reported under the name of another file.
        case $file in manifest.json) names=. ;; *) names=$file ;; esac
        check_detected 1 "a changed bit in byte $at of $file" "$names"
    done
    rm -rf x
    cp -r b x
    rm x/"$file"
    check_detected 2 "the removed file $file" "$file"
done
rm -rf x
cp -r b x
echo hello >x/more.txt
check_detected 1 "an added file" more.txt
rm -rf x
cp -r b x
{ sed -n 2p b/audit.log; sed -n 1p b/audit.log; sed -n '3,$p' b/audit.log; } >x/audit.log
check_detected 1 "exchanged first lines of the log" audit.log
rm -rf x
cp -r b x
ln -sf /dev/zero x/README.md
# osteon validate writes no symbolic links, so the bundle counts as changed (1). The link's target
# must not be read.
check_detected 1 "a link to a device" "README.md is a symbolic link"
rm -rf x
cp -r b x
mkdir x/signatures
run 0 verify x # signatures are not in the manifest; test_sign.sh tests them
echo "a signature over manifest.json" >x/signatures/manifest.json.minisig
check_detected 1 "a file in signatures/ that is not an envelope" signatures/manifest.json.minisig

# A backend may lack optional functions, and its bundle is still valid. The OpenCL backend, for
# example, lacks sampling.
if "$osteon" validate --only import/0 --backends cl --out optional >out 2>err; then
    run 0 verify optional
fi

# If a case's cubic grid is too far from the origin to be resampled again, it has no grid at that stage.
run 0 validate --only reach/0 --backends "$one" --out lone --quiet
run 0 verify lone

# The same cases are run again, first completely and then in shards.
run 0 validate --only import/ --backends "$one" --out again --quiet
mkdir shards
for i in 1 2; do run 0 validate --only import/ --backends "$one" --shard $i/2 --out shards/$i --quiet; done
refuse 2 "contains bundles of 1 of 2 shards" validate --merge "$(mkdir half && cp -r shards/1 half/ && echo half)" --out whole
run 0 validate --merge shards --out whole --quiet
run 0 verify whole
for other in again whole; do
    for file in $(cd b && find . -type f | sed 's,^\./,,' | grep -v '^\(audit.log\|environment.json\|times.json\|junit.xml\|report.html\|manifest.json\)$'); do
        checks=$((checks + 1))
        cmp -s "b/$file" "$other/$file" || fail "$other/$file differs from the file of the first run"
    done
    check "results_root of $other" "$("$json_get" results_root <$other/manifest.json)" "$("$json_get" results_root <b/manifest.json)"
    check "files of $other" "$(cd $other && find . -type f | sort)" "$(cd b && find . -type f | sort)"
done
run 0 validate --only import/ --backends "$one" --seed 2 --out other --quiet
rm -r shards/2
cp -r other shards/2
refuse 2 "another campaign" validate --merge shards --out mixed
finish
