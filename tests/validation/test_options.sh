#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests options and outputs of a campaign: the division of every kind of work among threads, the
# time limit of a backend, junit.xml, and results that verify computes again.
# Covers: REQ-VAL-THREADS, REQ-VAL-LIMIT, REQ-JUNIT, REQ-RERUN
. "${srcdir:-.}/tests/app/lib.sh"

# The smoke tier has a backend for each number of threads, and each of these backends divides
# every kind of work among its threads.
run 0 validate --cpu-only --only import/0 --out b --json
for threads in 2 3 7; do
    checks=$((checks + 1))
    grep -q "\"name\": \"cpu:isa=[a-z0-9]*,threads=$threads,grain=1\"" b/protocol.json || fail "the protocol has no backend with $threads threads and grain 1"
    run 0 validate --backends "cpu:isa=scalar,threads=$threads,grain=1" --only operation/0 --json
    for kind in 'scatter' 'copy of a grid' 'conversion to chunks' 'upload of a bone' 'digest' 'sort of triangles' 'voxelization' 'download of a tool' 'removal and collision'; do
        checks=$((checks + 1))
        grep -q "\"$kind on $threads threads\": *[1-9]" out || fail "work of kind $kind was not divided among $threads threads"
    done
done

# Conflicting options, and files that a worker cannot use.
refuse 2 "--cpu-only cannot be combined with --backends" validate --cpu-only --backends cl --only import/0
refuse 2 "--faults-only cannot be combined with --out" validate --faults-only --faults 1 --out none
refuse 2 "--from and --to need --worker" validate --from 3 --only import/0
refuse 2 "--from 5: must not be greater than --to 2" validate --worker ref --trace t --from 5 --to 2
refuse 2 "--worker needs --trace or --dump" validate --worker ref
refuse 2 "--trace needs --worker" validate --trace t
refuse 2 "nodir/t: cannot write: No such file or directory" validate --worker ref --trace nodir/t --only import/0
refuse 2 "gone: cannot open: No such file or directory" validate --worker ref --trace t --given gone --only import/0
echo hello >text
refuse 2 "text: not a trace" validate --worker ref --trace t --given text --only import/0
refuse 2 "gone/b: cannot make the folder: No such file or directory" validate --only import/0 --backends ref --out gone/b
refuse 2 "b: already exists; choose a new folder" validate --only import/0 --backends ref --export-cases b
refuse 2 "b: is a bundle; expected a folder that contains one bundle per shard" validate --merge b --out merged
refuse 2 "gone: neither a folder of dumps nor a backend" compare gone

# A log that was cut off within a line.
cp -r b cut
head -c "$(($(wc -c <b/audit.log) - 10))" b/audit.log >cut/audit.log
run 1 verify cut
checks=$((checks + 1))
grep -q "^  audit.log line [0-9]* is cut off; expected an entry 'ended'" out || fail "verify does not report the log that was cut off: $(cat out)"

# verify computes the results of the reference and of a backend again, and must find a changed result.
run 0 verify b --rerun
run 0 verify b --rerun --backend cpu:isa=scalar,threads=3,grain=1
run 2 verify b --backend cpu:threads=2
if [ -e "$build/.libs/mirror.so" ]; then
    export ASAN_OPTIONS="handle_segv=0:${ASAN_OPTIONS:-}"
    cp "$build/.libs/mirror.so" "$build/.libs/thesis_f32.so" .
    run 1 verify b --rerun --backend plugin:./thesis_f32.so
    checks=$((checks + 1))
    grep -q "import/0 plugin:./thesis_f32.so gives another result here (differs" out || fail "verify --rerun does not report the changed result: $(cat out)"

    # A backend that does not end must be stopped after the limit, and the verdict of its case must be
    # "timed out".
    run 1 validate --only sweep/1 --backends 'plugin:mirror.so,break=hang;cpu:isa=scalar,threads=1' --limit 3 --out late --json
    check "backend that does not end: verdict, backend" "$(value findings.0.verdict) $(value findings.0.backend)" "timed out plugin:mirror.so,break=hang"
    check "equal results of the other backend" "$(value results.equal)" 1
    run 0 verify late

    # junit.xml has one test for each case on each backend. Differing results are failures, and
    # absent backends are skipped.
    run 1 validate --only mesh/1 --backends 'cpu:isa=scalar,threads=1;plugin:mirror.so,break=snap;cl:platform=77' --out j
    suite_line() { grep -A2 "<testsuite name=\"$1\"" j/junit.xml; }
    for expected in 'cpu:isa=scalar,threads=1|failures="0" errors="0" skipped="0"|time="[0-9.]*"/>' \
        'plugin:mirror.so,break=snap|failures="1" errors="0" skipped="0"|<failure message="snap 0: ' 'cl:platform=77|failures="0" errors="0" skipped="1"|<skipped message="'; do
        name=${expected%%|*} rest=${expected#*|}
        checks=$((checks + 2))
        suite_line "$name" | grep -q "tests=\"1\" ${rest%%|*} time=\"[0-9.]*\" timestamp=\"20[0-9T:-]*\" hostname=\"" || fail "junit.xml: wrong test suite of $name: $(suite_line "$name")"
        suite_line "$name" | grep -q "<testcase classname=\"$name\" name=\"mesh/1\".*${rest##*|}" || fail "junit.xml: wrong case of $name: $(suite_line "$name")"
    done
    check "failures in junit.xml" "$(grep -c '<failure' j/junit.xml)" 1
    run 0 verify j
    sed 's/<failure message="[^"]*"/<skipped message="later"/' j/junit.xml >other
    mv other j/junit.xml
    run 1 verify j
    checks=$((checks + 1))
    grep -q 'junit.xml does not match the files' out || fail "verify does not report the changed junit.xml: $(cat out)"
else
    echo "not tested, because this build has no shared objects: time limits and junit.xml"
fi
finish
