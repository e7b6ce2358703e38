#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the comparison of two bundles by digests: equal bundles, bundles that differ at a given
# position, bundles that are not comparable, and folders that are not bundles.
# Covers: REQ-DIFF-BUNDLES
. "${srcdir:-.}/tests/app/lib.sh"

one='cpu:isa=scalar,threads=1'
cat >case.json <<'END'
{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "1", "keep": {"crop": [[0, 0, 0], [40, 36, 35]], "ticks": [[0, 4]]}}
END
run 0 validate --case case.json --backends "$one" --out a
mkdir b
cp a/protocol.json a/cases.jsonl b/
run 0 diff a b --json
check "two equal bundles: equal, compared cases" "$(value equal) $(value compared)" "true 1"
run 0 diff a b

# change_bundle WHAT PYTHON: makes the folder b from the folder a with a changed cases.jsonl
change_bundle() {
    python3 - "$1" <<END || fail "$1: python3 did not change the bundle"
import json
rows = [json.loads(l) for l in open("a/cases.jsonl")]
records = rows[0]["reference"]
tick = [r for r in records if r["stage"] == "tick"]
$2
open("b/cases.jsonl", "w").write("".join(json.dumps(r, sort_keys=True) + "\n" for r in rows))
END
}
if command -v python3 >/dev/null; then
    change_bundle leaf 'tick[2]["sha256"] = "0" * 64
tick[2]["leaves"] = [[0, "1" * 64]] + tick[2].get("leaves", [])[1:]
tick[3]["sha256"] = "0" * 64'
    run 1 diff a b --json
    check "first difference: case, stage, tick" "$(value differences.0.case) $(value differences.0.stage) $(value differences.0.item)" "sweep/0 tick 2"
    check "number of cases that differ" "$(value different_cases)" 1
    leaf=$(value differences.0.leaf)
    [ "$leaf" -ge 0 ] || fail "the first difference has no leaf: $(cat out)"
    change_bundle report 'tick[1]["sha256"] = "0" * 64'
    run 1 diff a b
    grep -q 'what was reported differs' out || fail "the output does not state that the reports differ: $(cat out)"
    change_bundle cubic '[r for r in records if r["stage"] == "cubic"][0].update(sha256="0" * 64, leaves=["2" * 64])'
    run 1 diff a b --json
    check "first difference: stage, leaf" "$(value differences.0.stage) $(value differences.0.leaf)" "cubic 0"
    change_bundle input 'rows[0]["input_sha256"] = "0" * 64'
    run 1 diff a b
    grep -q 'nothing could be compared' out || fail "the output does not state that nothing could be compared: $(cat out)"
    change_bundle other 'rows[0]["id"] = "sweep/1"'
    run 1 diff a b --json
    check "case that was not compared" "$(value not_compared.0)" "sweep/0: only in a"
    change_bundle short 'del records[-1]'
    run 1 diff a b
    grep -q 'no such record' out || fail "the output does not state that a record is missing: $(cat out)"
    # For a user's own files the protocol contains the dims of the grids, so the chunk can be
    # determined without the files.
    ct_text 40 36 34 1 'i * 20 + j + k' >ct.txt
    run 0 validate --only user --backends "$one" --ct ct.txt --cubic 0.5 --tool builtin:burr --out own
    mv a generated
    mkdir a
    cp own/protocol.json own/cases.jsonl a/
    cp own/protocol.json b/
    change_bundle own '[r for r in records if r["stage"] == "cubic"][0].update(sha256="0" * 64, leaves=[r for r in records if r["stage"] == "cubic"][0]["leaves"][:18] + ["3" * 64])'
    run 1 diff a b --json
    check "a user's own case: case, leaf, chunk" "$(value differences.0.case) $(value differences.0.leaf): $(value differences.0.chunk.0) $(value differences.0.chunk.1) $(value differences.0.chunk.2)" "user/1 18: 0 0 2"
    change_bundle own-tool '[r for r in records if r["stage"] == "tool"][0].update(sha256="0" * 64, leaves=["3" * 64])'
    run 1 diff a b --json
    check "a user's own tool: stage, chunk" "$(value differences.0.stage) $(value differences.0.chunk.0)" "tool 0"
    rm -r a
    mv generated a
    cp a/protocol.json b/
    # Replaces parts of a bundle by values of wrong types, which no valid bundle contains.
    for value in '7' 'null' '[[1,[2]],"x",{}]' '{"leaves":3}' '"x"'; do
        change_bundle odd "rows[0]['reference'] = json.loads('''$value''')"
        run 1 diff a b
        change_bundle odd "records[2] = json.loads('''$value''')"
        run 1 diff b a
        change_bundle odd "tick[0].update(leaves=json.loads('''$value'''), sha256='0')"
        run 1 diff a b
    done
fi
printf 'x\n' >b/cases.jsonl
refuse 2 "cases.jsonl:1" diff a b
printf '[]' >b/protocol.json
refuse 2 "protocol.json" diff a b
rm b/protocol.json
refuse 2 "protocol.json" diff a b
refuse 2 "is not; expected two grids" diff a case.json
refuse 2 "needs grids, not bundles" diff a a --html x.html
finish
