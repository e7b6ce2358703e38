#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# A campaign that is ended by a signal leaves nothing: no folder, no trace, no
# worker; and its status says which signal.  A worker that dies, and a disk
# without room, are told and leave nothing either.
# Covers: REQ-EVIDENCE
. "${srcdir:-.}/tests/app/lib.sh"

# The seed is what this run's workers are known by.
seed=91827364$$
mkdir tmp
TMPDIR=$scratch/tmp
export TMPDIR
# workers [KIND]: the folders in /proc of those that are at work; the pattern is not found in grep's own words
workers() { grep -lsa -- "[-]-worker.${1:-}.*--seed.$seed." /proc/[0-9]*/cmdline; }
# await COMMAND...: until it succeeds, for a minute at the most
await() {
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        [ $tries -lt 1200 ] || { fail "waited in vain for: $*"; return 1; }
        sleep 0.05
    done
}
working() { [ -n "$(workers "$@")" ]; }
idle() { [ -z "$(workers)" ]; }
nothing_left() {
    await idle
    check "$1: what is left beside the bundle" "$(find . -maxdepth 1 -name 'b*' | tr '\n' ' ')" ""
    check "$1: what is left for traces" "$(ls -A tmp)" ""
}

for signal in INT:2 TERM:15 HUP:1; do
    # A shell's background jobs ignore SIGINT, and all that nohup started SIGHUP: env makes them the default again.
    env --default-signal=INT,TERM,HUP "$osteon" validate --tier standard --only session --cpu-only --seed $seed --out b --quiet >out 2>err &
    pid=$!
    await working
    kill -"${signal%:*}" $pid
    wait $pid
    check "status after SIG$signal" $? $((128 + ${signal#*:}))
    nothing_left "SIG$signal"
done

# SIGKILL runs nothing: workers end all the same, traces have no name; the unfinished folder stays, under a name that says so.
"$osteon" validate --tier standard --only session --cpu-only --seed $seed --out b --quiet >out 2>err &
pid=$!
await working
kill -KILL $pid
wait $pid 2>/dev/null
check "status after SIGKILL" $? 137
await idle
check "unfinished folders after SIGKILL" "$(ls -d b.part-* | wc -l | tr -d ' ')" 1
# The next run with this name removes it, but not what is somebody else's, another name's or in use.
mkdir b.part-abc bb.part-abcdef b.part-locked
echo kept >b.part-abc/file
flock b.part-locked "$osteon" validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out b --quiet >out 2>err
check "folders that are not removed" "$(ls -d b*.part-* | tr '\n' ' ')" "b.part-abc b.part-locked bb.part-abcdef "
rm -rf b b.part-* bb.part-*
nothing_left SIGKILL

# end_worker SIGNAL: one worker of the backend that is compared ends by this signal; the campaign's status
end_worker() {
    "$osteon" validate --tier standard --only session/0 --backends 'cpu:isa=scalar,threads=1' --seed $seed --quiet --json >out 2>err &
    pid=$!
    await working cpu
    kill -"$1" "$(workers cpu | sed -n '1s,/proc/\([0-9]*\)/cmdline,\1,p')"
    wait $pid
}
# A worker that crashes fails the case that it was at; the others go on.
end_worker SEGV
check "status after a worker's crash" $? 1
check "verdict after a worker's crash" "$(value equal)" false
check "crashed cases" "$(value results.crashed)" 1
nothing_left "a worker's crash"

# SIGKILL comes from outside, mostly from the kernel when memory runs out, and says nothing about the backend, so that
# there is no verdict: status 2, where it was 1 ("crashed") before.
end_worker KILL
check "status after a worker's death" $? 2
checks=$((checks + 1))
grep -q "the worker of cpu:isa=scalar,threads=1 was ended from outside by SIGKILL" err || fail "a worker's death: $(cat err)"
nothing_left "a worker's death"

# No room: a limit on the size of files stands for a full disk.
checks=$((checks + 1))
(ulimit -f 64 && "$osteon" validate --only mesh --cpu-only --seed $seed --quiet >out 2>err)
status=$?
[ $status -eq 2 ] || fail "without room for traces: status $status, $(cat err)"
nothing_left "no room"
finish
