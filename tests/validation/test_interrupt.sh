#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# A campaign that is ended by a signal must leave no folder, no trace and no worker, and its exit
# status must be that of the signal. If a worker is killed or the disk is full, the campaign must
# report this and must also leave nothing.
# Covers: REQ-EVIDENCE
. "${srcdir:-.}/tests/app/lib.sh"

# The seed is unique, so that it identifies the workers of this run.
seed=91827364$$
mkdir tmp
TMPDIR=$scratch/tmp
export TMPDIR
# workers [KIND]: prints the /proc entries of the running workers; the pattern does not match
# grep's own arguments
workers() { grep -lsa -- "[-]-worker.${1:-}.*--seed.$seed." /proc/[0-9]*/cmdline; }
# wait_for COMMAND...: waits at most a minute until the command succeeds
wait_for() {
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        [ $tries -lt 1200 ] || { fail "not reached within a minute: $*"; return 1; }
        sleep 0.05
    done
}
workers_run() { [ -n "$(workers "$@")" ]; }
no_worker_runs() { [ -z "$(workers)" ]; }
check_nothing_left() {
    wait_for no_worker_runs
    check "$1: files that remain next to the bundle" "$(find . -maxdepth 1 -name 'b*' | tr '\n' ' ')" ""
    check "$1: files that remain in the folder of the traces" "$(ls -A tmp)" ""
}

for signal in INT:2 TERM:15 HUP:1; do
    # Background jobs of a shell ignore SIGINT, and processes started by nohup ignore SIGHUP. env
    # restores the default actions.
    env --default-signal=INT,TERM,HUP "$osteon" validate --tier standard --only session --cpu-only --seed $seed --out b --quiet >out 2>err &
    pid=$!
    wait_for workers_run
    kill -"${signal%:*}" $pid
    wait $pid
    check "status after SIG$signal" $? $((128 + ${signal#*:}))
    check_nothing_left "SIG$signal"
done

# After SIGKILL no handler runs. The workers must still end, and no trace remains, because the files of
# traces have no name. The unfinished folder remains under a name that shows its state.
"$osteon" validate --tier standard --only session --cpu-only --seed $seed --out b --quiet >out 2>err &
pid=$!
wait_for workers_run
kill -KILL $pid
wait $pid 2>/dev/null
check "status after SIGKILL" $? 137
wait_for no_worker_runs
check "unfinished folders after SIGKILL" "$(ls -d b.part-* | wc -l | tr -d ' ')" 1
# The next run with this name removes the unfinished folder, but no folder that belongs to another
# program, has another name, or is in use.
mkdir b.part-abc bb.part-abcdef b.part-locked
echo kept >b.part-abc/file
flock b.part-locked "$osteon" validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out b --quiet >out 2>err
check "folders that the next run must not remove" "$(ls -d b*.part-* | tr '\n' ' ')" "b.part-abc b.part-locked bb.part-abcdef "
rm -rf b b.part-* bb.part-*
check_nothing_left SIGKILL

# end_worker SIGNAL: ends one worker of the backend under comparison with this signal; returns the
# campaign's status
end_worker() {
    "$osteon" validate --tier standard --only session/0 --backends 'cpu:isa=scalar,threads=1' --seed $seed --quiet --json >out 2>err &
    pid=$!
    wait_for workers_run cpu
    kill -"$1" "$(workers cpu | sed -n '1s,/proc/\([0-9]*\)/cmdline,\1,p')"
    wait $pid
}
# If a worker crashes, its current case fails, and the other cases must run.
end_worker SEGV
check "exit status after a worker crashed" $? 1
check "equal after a worker crashed" "$(value equal)" false
check "crashed cases" "$(value results.crashed)" 1
check_nothing_left "a crashed worker"

# A SIGKILL comes from another process or from the kernel, usually because memory is exhausted, and
# is no evidence about the backend. Therefore there must be no verdict, and the status must be 2.
end_worker KILL
check "exit status after a worker was killed" $? 2
checks=$((checks + 1))
grep -q "the worker of cpu:isa=scalar,threads=1 was ended from outside by SIGKILL" err || fail "the error does not state that a worker was killed: $(cat err)"
check_nothing_left "a killed worker"

# A limit on the file size simulates a full disk.
checks=$((checks + 1))
(ulimit -f 64 && "$osteon" validate --only mesh --cpu-only --seed $seed --quiet >out 2>err)
status=$?
[ $status -eq 2 ] || fail "disk full: status $status, expected 2: $(cat err)"
check_nothing_left "a full disk"
finish
