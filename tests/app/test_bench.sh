#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the output of osteon bench that scripts use: the names and keys of the rows, the equality of
# the grids with the reference's, and the counts of the thesis' static events. Times are not tested.
# Covers: REQ-CLI-BENCH
. "${srcdir:-.}/tests/app/lib.sh"
TMPDIR=$scratch
export TMPDIR

# row_index NAME: prints the index of the row in the JSON object in the file out
row_index() {
    i=0
    while name=$(value "rows.$i.name" 2>/dev/null); do
        [ "$name" = "$1" ] && { echo $i; return; }
        i=$((i + 1))
    done
    echo none
}

# row_has NAME KEY...: checks that the row exists, is equal to the reference, and has the keys
row_has() {
    at=$(row_index "$1")
    shown=$1
    shift
    checks=$((checks + 1))
    [ "$at" = none ] && { fail "the output has no row $shown"; return; }
    check "row $shown: equal" "$(value "rows.$at.equal")" true
    for key in unit threads ours ours_min ours_max ours_repetitions baseline ratio ratio_of_minima "$@"; do has "rows.$at.$key"; done
}

# check_figures NAME: checks that osteon's figure, the baseline's and their ratio are numbers
check_figures() {
    at=$(row_index "$1")
    for key in ours baseline ratio; do
        checks=$((checks + 1))
        case $(value "rows.$at.$key") in
        [0-9]*) ;;
        *) fail "row $1: $key is not a number: $(value "rows.$at.$key")" ;;
        esac
    done
}

run 0 bench --suite removal --filter /32/ --quick --json
has suite backend isa threads cpu cpus clock compiler baseline_flags quick
check "clock" "$(value clock)" CLOCK_MONOTONIC
for name in removal/reamer/32/fresh removal/reamer/32/steady removal/peg/32/fresh removal/peg/32/steady removal/reamer/32/fresh/1 \
    removal/reamer/32/steady/1 removal/peg/32/fresh/1 removal/peg/32/steady/1; do
    row_has $name baseline_min baseline_max baseline_repetitions baseline_is chunks removed_voxels
    check "row $name: chunks" "$(value "rows.$at.chunks")" 18
    check "row $name: unit" "$(value "rows.$at.unit")" us
    check_figures $name
done
check "voxels that the reamer removes" "$(value "rows.$(row_index removal/reamer/32/fresh).removed_voxels")" 77108
check "voxels that the peg removes" "$(value "rows.$(row_index removal/peg/32/fresh).removed_voxels")" 8089
check "threads of the row removal/peg/32/fresh/1" "$(value "rows.$(row_index removal/peg/32/fresh/1).threads")" 1

# Compares the counts for chunks of 16^3 and 64^3 with Tables 3.3 and 3.4. Other chunk sizes must
# remove the same voxels.
run 0 bench --suite removal --filter fresh/1 --quick --repeat 1 --json
for expected in reamer/16:84 reamer/64:5 peg/16:80 peg/64:8 voxel/1:18 voxel/0.75:18; do
    name=removal/${expected%:*}/fresh/1
    row_has "$name" chunks
    check "row $name: chunks" "$(value "rows.$at.chunks")" "${expected#*:}"
done
check "voxels that the reamer removes in chunks of 16 voxels" "$(value "rows.$(row_index removal/reamer/16/fresh/1).removed_voxels")" 77108
check "voxels that the peg removes in chunks of 64 voxels" "$(value "rows.$(row_index removal/peg/64/fresh/1).removed_voxels")" 8089
run 0 bench --suite removal --filter sequence --quick --repeat 1 --json
row_has removal/sequence/1 p50 p99 max undisturbed_mean
run 0 bench --suite removal --filter bone/128 --quick --repeat 1 --json
row_has removal/bone/128/steady/1 chunks

run 0 bench --suite tick --filter reamer --quick --json
row_has tick/reamer/32
row_has tick/reamer/32/steady
run 0 bench --suite parse --quick --repeat 1 --json
row_has parse/text lines bytes gb_per_s
row_has parse/text/floor
check "lines of the text of the parse rows" "$(value rows.0.lines)" 239616
check "files of osteon bench left in TMPDIR" "$(ls -A "$scratch" | grep -c osteon-bench)" 0
run 0 bench --suite transfer --quick --repeat 1 --json
for row in transfer/scapula transfer/scapula/nearest transfer/scapula/thesis transfer/scapula/0.6; do
    row_has $row chunk_bytes active_chunks
done
run 0 bench --suite voxelize --filter /0.5 --quick --repeat 1 --json
row_has voxelize/reamer/0.5 triangles solid_voxels
row_has voxelize/peg/0.5
row_has voxelize/peg/0.5/bytes solid_voxels
run 0 bench --suite voxelize --filter sphere80k/256 --quick --repeat 1 --json
row_has voxelize/sphere80k/256
check "triangles of the first row" "$(value rows.0.triangles)" 80400
# Without Embree, no row can be measured, which is status 3.
if grep -q '^#define HAVE_EMBREE[34] 1' "$build/config.h"; then
    run 0 bench --suite candidates --filter 64/64 --quick --repeat 1 --json
    row_has candidates/sphere/64/64 triangles voxels
else
    run 3 bench --suite candidates --filter 64/64 --quick --repeat 1 --json
    has rows.0.reason
fi

# If there is no OpenCL device, a row must contain the reason.
run 0 bench --suite opencl --filter reamer/32/fresh --quick --repeat 1 --json
check "name of the OpenCL row" "$(value rows.0.name)" opencl/reamer/32/fresh
if value rows.0.reason >/dev/null 2>&1; then
    has rows.0.reason
else
    row_has opencl/reamer/32/fresh chunks removed_voxels baseline_is
    check "voxels that the OpenCL row removes" "$(value "rows.$at.removed_voxels")" 77108
fi

run 0 bench --suite render --filter glenoid/1 --quick --repeat 1 --json
row_has render/scapula/glenoid/1 p50_ms p99_ms fps scalar_min_ms surface_voxels active_voxels covered_pixels baseline_is
run 0 bench --suite render --filter render/frame/whole --quick --repeat 1 --json
row_has render/frame/whole/1 p99_ms drawn_share put_back_share kept_splat_ms whole_merge_ms baseline_is

# Tests the output for readers: a table of at most 100 columns, and Markdown.
run 0 bench --suite servo --quick --json
check "names and ticks of the servo rows" "$(value rows.0.name) $(value rows.1.name) $(value rows.0.ticks)" "servo/empty servo/spin 50"
has rows.0.missed rows.1.missed rows.1.p99_us
run 0 bench --suite servo --filter empty --quick
grep -q 'deadlines missed: [0-9]* in 50 ticks' out || fail "the servo rows do not state the missed deadlines: $(cat out)"
run 0 bench --suite removal --filter peg/32 --quick
check "lines of more than 100 columns" "$(awk 'length > 100' out | grep -v '^  baseline' | wc -l | tr -d ' ')" 0
grep -q '^removal/peg/32/fresh ' out || fail "the table has no row removal/peg/32/fresh"
run 0 bench --suite removal --filter peg/32/steady/1 --quick --markdown
grep -q '^| `removal/peg/32/steady/1` | us |' out || fail "the Markdown table has no row removal/peg/32/steady/1"

# If a row cannot run, it must contain the reason, and the other rows must run. In this test, the
# text of the parse/ rows has no folder.
TMPDIR=$scratch/nowhere
run 0 bench --quick --filter ext --json
at=$(row_index parse/text)
check "parse/text without a folder: run, equal, ours" "$(value "rows.$at.run") $(value "rows.$at.equal") $(value "rows.$at.ours")" "false null null"
case $(value "rows.$at.reason") in *"$scratch/nowhere"*) ;; *) fail "the reason of parse/text does not contain the folder: $(value "rows.$at.reason")" ;; esac
check "the row render/scapula/extract was run after a row that cannot run" "$(value "rows.$(row_index render/scapula/extract).run")" true
check "numbers of rows that were run and not run" "$(value rows_run) $(value rows_not_run)" "1 2"
run 0 bench --quick --filter ext
grep -q '^parse/text  *not run: ' out || fail "the table does not state that parse/text was not run: $(cat out)"
run 3 bench --quick --suite parse --json
grep -q "no row could be run: $scratch/nowhere" err || fail "the error does not state that no row could be run: $(cat err)"
check "number of rows that were run if none can run" "$(value rows_run)" 0
TMPDIR=$scratch

# Compares ratios with those of an earlier run. No machine is 1e9 times as fast as the baseline, and every machine is
# faster than a millionth of it, so the results do not depend on times.
write_earlier_run() { printf '{"quick": true, "isa": "abacus", "rows": [{"name": "removal/peg/32/steady/1", "ratio_of_minima": %s}]}' "$1" >old.json; }
row=removal/peg/32/steady/1
write_earlier_run 1e9
run 1 bench --suite removal --filter peg/32/steady/1 --quick --against old.json --json
check "name of the slower row, whether it is slower, number of slower rows" "$(value against.rows.0.name) $(value against.rows.0.slower) $(value against.slower)" "$row true 1"
check "name of the measured row" "$(value rows.0.name)" $row
has against.rows.0.ratio_then against.rows.0.ratio_now against.rows.0.slowdown_percent
check "default of max_slowdown_percent" "$(value against.max_slowdown_percent)" 10
run 1 bench --suite removal --filter peg/32/steady/1 --quick --against old.json
grep -q "^$row .*  slower$" out || fail "the table does not mark the slower row: $(cat out)"
write_earlier_run 1e-6
run 0 bench --suite removal --filter peg/32/steady/1 --quick --against old.json --max-slowdown 0.5%
grep -q "^$row .* -100.0%$" out || fail "the table has no comparison with the earlier run: $(cat out)"
grep -q 'slower than allowed: 0 of 1 rows; allowed is a slowdown of 0.5 %' out || fail "the comparison has no summary: $(cat out)"
grep -q 'isa then: abacus; now: ' out || fail "the output does not state that the instruction set differs: $(cat out)"
run 2 bench --suite removal --filter peg/64/steady/1 --quick --against old.json
grep -q 'old.json: no row with a ratio is in both runs' err || fail "the error does not state that no row can be compared: $(cat err)"
refuse 2 "measured with --quick" bench --suite removal --filter peg/64/steady/1 --against old.json
for spoilt in '{' '[]' '{"quick": true}' '{"quick": 1, "rows": []}'; do
    echo "$spoilt" >spoilt.json
    refuse 2 "spoilt.json" bench --suite removal --filter peg/64/steady/1 --quick --against spoilt.json
done
refuse 2 "absent.json" bench --quick --against absent.json
refuse 2 "--max-slowdown needs --against" bench --quick --max-slowdown 5
for limit in x -1 1001 5%%; do
    refuse 2 "expected a percentage" bench --quick --against old.json --max-slowdown="$limit"
done

refuse 2 "no row of suite tick matches 'nothing'" bench --suite tick --filter nothing
refuse 2 '--scale 2' bench --scale 2
finish
