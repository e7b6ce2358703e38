#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Runs the commands for many machines literally as written in docs/reference/campaigns.md, but
# with two shards of a few cases instead of eight of the full tier. A script with the same
# interface replaces sbatch. GNU parallel is used if it is installed.
# Covers: REQ-SHARDS
. "${srcdir:-.}/tests/app/lib.sh"
small="--only import/ --backends cpu:isa=scalar,threads=1"
mkdir bin examples
ln -s "$osteon" bin/osteon
ln -s "$source_folder/examples/cluster" examples/cluster
PATH=$scratch/bin:$PATH
export PATH
# sbatch --wait --array=1-N SCRIPT ARGUMENT...: runs the tasks in any order with the variables
# that Slurm sets; returns the worst status
cat >bin/sbatch <<'END'
#!/bin/sh
[ "$1" = --wait ] && case $2 in --array=1-[0-9]*) ;; *) false ;; esac || { echo "sbatch $*: the arguments differ from those documented in campaigns.md" >&2; exit 64; }
n=${2#--array=1-} worst=0
shift 2
script=$1
shift
SLURM_ARRAY_TASK_COUNT=$n
export SLURM_ARRAY_TASK_COUNT
while [ "$n" -gt 0 ]; do
    SLURM_ARRAY_TASK_ID=$n "$script" "$@" >"shard-$n.log" 2>&1 || worst=$?
    n=$((n - 1))
done
exit $worst
END
chmod +x bin/sbatch

# Writes each block of the section to a file, and replaces large parameters by small ones.
awk '/^## /{ on = $0 == "## Many machines" } on && /^```/{ if (open) close(file); else file = "block-" ++n; open = !open; next } on && open { print >file }' \
    "$source_folder/docs/reference/campaigns.md"
check "blocks of commands in the document" "$(echo block-*)" "block-1 block-2"
# shellcheck disable=SC2086 # words
run 0 validate $small --out whole --quiet
for block in block-1 block-2; do
    if grep -q '^parallel' $block && ! parallel --version 2>/dev/null | grep -q '^GNU parallel'; then
        echo "not tested, because GNU parallel is not installed: its command"
        continue
    fi
    sed "s|--tier full|$small|; s|1-8|1-2|; s|/8|/2|; s|seq 8|seq 2|" $block >small
    check "$block: lines with parameters that were replaced by small ones" "$(diff $block small | grep -c '^>')" 1
    checks=$((checks + 1))
    sh -eu small >out 2>err || fail "$block: status $?, expected 0: $(tail -n 3 err out)"
    grep -q '^EQUAL: 8 cases from 2 shards$' out || fail "$block: the merged bundle is not EQUAL: $(cat out)"
    check "$block: results_root" "$("$json_get" results_root <bundle/manifest.json)" "$("$json_get" results_root <whole/manifest.json)"
    run 0 verify bundle
    rm -rf shards bundle
done

# Runs one of many tasks again, as described in the script's comment.
mkdir shards
# shellcheck disable=SC2086 # words
SHARDS=2 SLURM_ARRAY_TASK_COUNT=1 SLURM_ARRAY_TASK_ID=2 examples/cluster/shards.sbatch $small >out 2>err || fail "running one task again failed: $(cat err)"
check "shard of the repeated task" "$("$json_get" shard.0 shard.1 <shards/2/protocol.json | tr '\n' ' ')" "2 2 "
finish
