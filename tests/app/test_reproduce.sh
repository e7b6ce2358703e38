#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon reproduce, which makes the tables and figures of the thesis. Its files must agree with
# each other, plots must be well-formed, counts must be equal on every machine, and a report must
# contain all items. Also tests merging, refusals and an interrupted run. Times are not tested.
# Covers: REQ-REPRODUCE, REQ-REPRODUCE-FILES, REQ-REPRODUCE-MERGE
. "${srcdir:-.}/tests/app/lib.sh"
needs PNG
TMPDIR=$scratch
export TMPDIR

# The list must contain every table and figure of the thesis, as an item or with the reason why it is missing.
run 0 reproduce --list --json
cp out list
for n in 2.1 2.2 3.1 3.2 3.3 3.4 3.5 3.6 3.7 3.8; do
    checks=$((checks + 1))
    grep -q "\"table-$n\"" list || fail "--list has no table-$n"
done
for n in 1.1 1.2 1.3 1.4 2.1 2.2 2.3 2.4 3.1 3.2 3.3 3.4 3.5 3.6 3.7 3.8 3.9 3.10 3.11 3.12 3.13 3.14 3.15 3.16; do
    checks=$((checks + 1))
    grep -q "\"figure-$n\"" list || fail "--list has no figure-$n"
done
has items.0.title items.0.kind missing.0.reason
run 0 reproduce --list
checks=$((checks + 1))
grep -q '^table-3\.3  *times ' out || fail "the list for readers has no line for table-3.3: $(head -n 3 out)"

# Makes items of all kinds: counts, times and pictures.
run 0 reproduce table-3.2,figure-3.2,table-3.4,table-3.6,section-3.2.6,figure-2.2 --out once --quick --json
check "numbers of measured and of not measured items" "$(value measured) $(value not_measured)" "6 0"
check "name of the first item" "$(value items.0.name)" figure-2.2
for file in table-3.2.csv table-3.2.json figure-3.2.svg figure-3.2-2.svg table-3.4.csv table-3.4.svg section-3.2.6.svg \
    figure-2.2-before.svg figure-2.2-after.svg report.html; do
    checks=$((checks + 1))
    [ -s "once/$file" ] || fail "the file once/$file is missing or empty"
done
check "hidden files in the folder" "$(ls -A once | grep -c '^\.')" 0
check "files of osteon left in TMPDIR" "$(ls -A "$scratch" | grep -c osteon-)" 0

# The counts of the thesis' event and of the phantoms must be equal on every machine.
cp once/table-3.4.json out
check "chunks of the event" "$(value rows.0.chunks.value) $(value rows.1.chunks.value) $(value rows.2.chunks.value)" "80 18 8"
check "chunks of the event in the thesis" "$(value rows.0.chunks.thesis) $(value rows.1.chunks.thesis) $(value rows.2.chunks.thesis)" "80 18 8"
check "removed voxels" "$(value rows.0.removed_voxels) $(value rows.1.removed_voxels)" "8089 8089"
checks=$((checks + 1))
grep -q '"thesis": 1172' once/table-3.4.json || fail "table-3.4.json does not contain the thesis' value 1172"

# A name may be written as in the thesis.
run 0 reproduce 'Table 3.1,fig-3.15' --out named --quick
check "rows of table-3.1 with the dimensions of the scapula" "$(grep -c '^.*Scapula,.*256 x 234 x 201,256 x 234 x 201,12040704,12040704,' named/table-3.1.csv)" 1
checks=$((checks + 1))
[ -s named/figure-3.15.csv ] || fail "the item fig-3.15 did not write figure-3.15.csv"

# The merged result must contain the rows of both machines, distinguished by their names.
run 0 reproduce --merge once --merge named --merge once --out merged --json
check "number of merged items" "$(value measured)" 8
check "lines of table-3.4.csv with two machines" "$(grep -c . merged/table-3.4.csv)" 7
check "number of different names of machines" "$(sed 1d merged/table-3.4.csv | sed 's/"\([^"]*\)".*/\1/' | sort -u | wc -l | tr -d ' ')" 2
run 0 reproduce table-3.4 --merge merged --out again --quiet
check "table-3.4.json after merging a single folder" "$(cmp merged/table-3.4.json again/table-3.4.json && echo same)" same

# A report must list every table and figure, and be a single page.
for n in table-2.2 figure-3.10 figure-1.3; do
    checks=$((checks + 1))
    grep -q "$(echo "$n" | sed 's/^\(.\)\(.*\)-/\1\2 /; s/^t/T/; s/^f/F/')" once/report.html || fail "the report does not list $n"
done
check "references of the report to other files" "$(grep -c 'src="[^d]\|href=' once/report.html)" 0
if [ -n "${PYTHON3:-}" ] && [ "$PYTHON3" != no ]; then
    checks=$((checks + 1))
    "$PYTHON3" "$source_folder/tests/app/check_reproduce.py" once named merged >out 2>&1 || fail "the files of the items do not agree: $(cat out)"
fi

# Tests a CT of the user that replaces a model.
run 0 phantom glenoid --out own.nrrd --scale 0.5
run 0 reproduce table-3.1 --ct glenoid=own.nrrd --out own --quick
check "rows of table-3.1 with the user's own CT" "$(grep -c 'Glenoid (own CT)' own/table-3.1.csv)" 1
refuse 2 'none.nrrd' reproduce table-3.1 --ct none.nrrd --out own2 --quick

# Tests arguments that must be refused.
refuse 2 "'table-9.9' is not an item" reproduce table-9.9 --out x
refuse 2 "did you mean table-3.3" reproduce tabel-3.3 --out x
refuse 2 '--out DIR is missing' reproduce table-3.3
refuse 3 'a drawing' reproduce figure-1.1 --out x
refuse 2 'contains no result' reproduce --merge "$scratch/own.nrrd.d" --out absent
refuse 2 "'banana' is not a model; expected foam, core-2, core-1, scapula or glenoid" reproduce table-3.3 --ct banana=own.nrrd --out absent
refuse 2 'gone.nrrd: cannot open' reproduce table-3.3 --ct gone.nrrd --out absent
checks=$((checks + 1))
if [ -e absent ]; then fail "a run that made no result leaves a folder"; fi
echo x >file
refuse 2 'file: cannot make the folder' reproduce table-3.6 --out file
mkdir broken
echo '{"format": "other"}' >broken/table-3.4.json
refuse 2 'is not a result of osteon reproduce' reproduce --merge broken --out x
printf '{"form' >broken/table-3.4.json
refuse 2 'broken/table-3.4.json:1' reproduce --merge broken --out x

# Every file that an interrupted run leaves must be complete.
# A shell without job control ignores SIGINT for its background processes.
"$osteon" reproduce figure-2.2,table-2.2,table-3.3 --out cut --quiet >out 2>err &
pid=$!
for _ in $(seq 3000); do
    [ -s cut/figure-2.2.json ] && break
    sleep 0.1
done
sleep 0.5
kill -TERM $pid 2>/dev/null
wait $pid
status=$?
checks=$((checks + 1))
[ $status -eq 143 ] || fail "exit status of an interrupted run: $status, expected 143: $(cat err)"
check "hidden files of an interrupted run" "$(ls -A cut | grep -c '^\.')" 0
check "files that an interrupted run left in TMPDIR" "$(ls -A "$scratch" | grep -c osteon-)" 0
for file in cut/*.json; do
    "$json_get" item <"$file" >/dev/null || fail "$file is not complete"
done
finish
