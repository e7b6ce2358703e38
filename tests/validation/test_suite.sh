#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests osteon validate --with-suite: the results of tests in a bundle, and the problems that
# verify reports about them. The suite is a simulated program tests/run-test. Its tests pass, fail,
# are skipped, hang, are ended by a signal, or print endlessly.
# Covers: REQ-SUITE
. "${srcdir:-.}/tests/app/lib.sh"

mkdir -p suite/tests
cat >suite/tests/run-test <<'END'
#!/bin/sh
case $1 in
tests/core/test_pose.c) echo "5 of 5"; exit 0 ;;
*) echo "it is not built: make check builds it"; exit 77 ;;
esac
END
chmod +x suite/tests/run-test
campaign="validate --only import/0 --backends cpu:isa=scalar,threads=1"

# A folder that is not a suite must be refused before anything runs.
refuse 2 "needs --out" $campaign --with-suite suite
refuse 2 "only the first shard runs the tests; pass --shard 1/2" $campaign --with-suite suite --shard 2/2 --out b
refuse 2 "nowhere: has no program tests/run-test" $campaign --with-suite nowhere --out b
mkdir -p plain/tests folder/tests/run-test
echo text >plain/tests/run-test
refuse 2 "no program that can be executed" $campaign --with-suite plain --out b
refuse 2 "no program that can be executed" $campaign --with-suite folder --out b
checks=$((checks + 1))
[ ! -e b ] || fail "a campaign with a refused suite left a bundle"

# One test passes. Absent tests are skipped, and the reason is given.
run 0 $campaign --with-suite suite --out b --json
named=$(sed 1d b/requirements.csv | grep -v '^,' | cut -d, -f4 | tr ';' '\n' | grep . | sort -u | wc -l | tr -d ' ')
check "passed tests of the suite" "$(value suite.passed)" 1
check "skipped tests of the suite" "$(value suite.skipped)" $((named - 1))
check "time limit in the protocol" "$("$json_get" suite.limit_s <b/protocol.json)" 1800
checks=$((checks + 1))
grep -q '"output_bytes": 7,' b/suite.json && grep -q "\"output_sha256\": \"$(echo "5 of 5" | sha256sum | cut -d' ' -f1)\"" b/suite.json || fail "suite.json does not contain the size and the digest of a test's output"
checks=$((checks + 1))
grep '^requirement,"AR-POSE-1",' b/trace.csv | grep -q '; the test suite",".*; tests: 1 passed","common.json suite.json"$' || fail "AR-POSE-1 is not traced to its test: $(grep AR-POSE-1 b/trace.csv)"
checks=$((checks + 1))
grep '^requirement,"REQ-CLI-HELP",' b/trace.csv | grep -q '"not by this bundle; tests: 0 passed; tests/app/test_guide.sh skipped: it is not built' || fail "trace.csv does not state that a skipped test verifies nothing"
checks=$((checks + 1))
grep -q 'id="suite"' b/report.html && ! grep -q 'SUITE FAILED' b/report.html || fail "the report does not contain the suite, or states that it failed"
run 0 verify b --json
check "passed tests according to verify" "$(value suite.passed)" 1

# The suite of a shard must be part of the merged bundle.
mkdir shards
run 0 validate --only import --backends cpu:isa=scalar,threads=1 --shard 1/2 --with-suite suite --out shards/1
run 0 validate --only import --backends cpu:isa=scalar,threads=1 --shard 2/2 --out shards/2
run 0 validate --merge shards --out merged --json
check "passed tests in the merged bundle" "$(value suite.passed)" 1
run 0 verify merged

# If no test ran, there must be no evidence.
printf '#!/bin/sh\nexit 77\n' >suite/tests/run-test
run 3 $campaign --with-suite suite --out none
checks=$((checks + 1))
grep -q 'no test of the suite ran' err || fail "the error does not state that no test ran: $(cat err)"
run 0 verify none
check "results_root with other results of the suite" "$("$json_get" results_root <none/manifest.json)" "$("$json_get" results_root <b/manifest.json)"

# The tests fail in every way. None of their processes may continue, and none of their output may be stored.
cat >suite/tests/run-test <<END
#!/bin/sh
case \$1 in
tests/core/test_pose.c) exit 0 ;;
tests/core/test_grid.c) echo "3 is not 4"; exit 1 ;;
tests/core/test_integer.c) kill -SEGV \$\$ ;;
tests/core/test_digest.c) sleep 1000 & echo \$! >$scratch/hung; wait ;;
tests/core/test_decimal.c) yes "a line that never ends well" ;;
tests/core/test_motor.c) printf 'no\tplain \033[31mtext\n\n'; exit 99 ;;
tests/core/test_report.c) sleep 1000 >/dev/null 2>&1 & echo \$! >$scratch/left; exit 0 ;;
tests/ref/test_map.c) exec 1>&- 2>&-; exit 3 ;;
*) echo "it is not built"; exit 77 ;;
esac
END
run 1 $campaign --with-suite suite --suite-limit 3 --out failed
checks=$((checks + 1))
grep -q '^TEST SUITE FAILED: .* 2 passed, 6 failed' out && grep -q 'verdict .*; the test suite FAILED' out || fail "the output does not state that the suite failed: $(cat out)"
object_of() { # object_of TEST: prints the object of TEST in suite.json on one line
    tr '\n' ' ' <failed/suite.json | sed 's/},/}\n/g' | grep -F "\"test\": \"$1\""
}
check_object() { # check_object TEST TEXT...: checks that the object of TEST contains each TEXT
    test=$1
    shift
    for text in "$@"; do
        checks=$((checks + 1))
        object_of "$test" | grep -qF "$text" || fail "$test: the object '$(object_of "$test")' does not contain '$text'"
    done
}
check_object tests/core/test_grid.c '"result": "failed"' '"status": 1' 'ended with status 1; it printed last: 3 is not 4'
check_object tests/core/test_integer.c '"result": "failed"' '"status": -11' 'was ended by signal 11'
check_object tests/core/test_digest.c '"result": "failed"' '"stopped": "time"' 'ran longer than 3 s and was stopped'
check_object tests/core/test_decimal.c '"result": "failed"' '"stopped": "output"' 'printed more than 67108864 bytes and was stopped'
check_object tests/core/test_motor.c '"result": "failed"' '"status": 99' 'it printed last: no?plain ?[31mtext'
check_object tests/core/test_report.c '"result": "passed"'
check_object tests/ref/test_map.c '"result": "failed"' '"reason": "ended with status 3"'
for left in hung left; do
    checks=$((checks + 1))
    ! kill -0 "$(cat $left)" 2>/dev/null || grep -q '^State:.*Z' "/proc/$(cat $left)/status" 2>/dev/null || fail "a process of a test continues to run"
done
checks=$((checks + 1))
grep -q 'THE TEST SUITE FAILED' failed/report.html || fail "the report does not state that the suite failed"
run 0 verify failed
checks=$((checks + 1))
grep -q 'the test suite FAILED: 2 passed, 6 failed' out || fail "verify does not state that the suite failed: $(cat out)"

# Files are forged without correcting the manifest and the log. verify must name suite.json and the error.
cp -r failed forged
sed 's/"failed": 6/"failed": 5/' failed/suite.json >forged/suite.json
run 1 verify forged
checks=$((checks + 1))
grep -q 'suite.json says 5 failed, and its results give 6' out || fail "verify does not report the forged count: $(cat out)"
sed 's/"result": "failed"/"result": "passed"/' failed/suite.json >forged/suite.json
run 1 verify forged
checks=$((checks + 1))
grep -q "says 'passed', and status 1 gives 'failed'" out || fail "verify does not report the failed test that is listed as passed: $(cat out)"
sed 's/"result": "failed"/"result": "skipped"/;s/"status": 1,/"status": 77,/;s/"limit_s": 3/"limit_s": 4/' failed/suite.json >forged/suite.json
run 1 verify forged
checks=$((checks + 1))
grep -q "has another limit of time" out || fail "verify does not report the forged time limit: $(cat out)"
sed 's,tests/core/test_pose.c,tests/core/test_posf.c,' failed/suite.json >forged/suite.json
run 1 verify forged
checks=$((checks + 1))
grep -q "has a result of 'tests/core/test_posf.c' where requirements.csv gives tests/core/test_pose.c" out || fail "verify does not report the forged name of a test: $(cat out)"
printf '[' >forged/suite.json
run 1 verify forged
rm forged/suite.json
run 2 verify forged
checks=$((checks + 1))
grep -q 'suite.json is missing' out err || fail "verify does not report the removed suite: $(cat out)"
run 0 $campaign --out without
cp failed/suite.json without/suite.json
run 1 verify without
checks=$((checks + 1))
grep -q 'suite.json belongs to no bundle of this protocol' out || fail "verify does not report the added suite: $(cat out)"

# The program tests/run-test of the build must run a test in the same way as make check.
if [ -x "$build/tests/core/test_pose" ]; then
    "$build/tests/run-test" tests/core/test_pose.c >out 2>&1
    check "tests/run-test tests/core/test_pose.c" $? 0
fi
for path in m4/arithmetic.m4 tests/nothing.c; do
    "$build/tests/run-test" "$path" >out 2>&1
    check "tests/run-test $path" $? 77
done
finish
