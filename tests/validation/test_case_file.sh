#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests cases from files: reduced parts of a generated case, bundles of such cases, and files that
# are not cases.
# Covers: REQ-CASE-FILE
. "${srcdir:-.}/tests/app/lib.sh"

one='cpu:isa=scalar,threads=1'
cat >small.json <<'END'
{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "1",
 "keep": {"crop": [[0, 0, 0], [20, 18, 17]], "ticks": [[0, 2], [3, 4]], "no_tools": [], "collide": false}}
END
run 0 validate --case small.json --backends "$one" --out b --json
check "equal" "$(value equal)" true
check "evidence of a file" "$(value evidence)" false
run 0 verify b --rerun --json
check "made again" "$(value rerun)" true
cmp -s b/case.json small.json && fail "case.json is not in the bundle's form"
run 0 validate --case b/case.json --backends "$one" --out b2
check "the same again" "$(cmp b/cases.jsonl b2/cases.jsonl && echo same)" same
grep -q -- '--case case.json' b/README.md || fail "README.md does not say how to do it again"
echo '{"cases": [{"osteon_case": 1, "id": "mesh/0", "tier": "smoke", "seed": "1"}, {"osteon_case": 1, "id": "mesh/1", "tier": "smoke", "seed": "2"}]}' >two.json
run 0 validate --case two.json --backends "$one" --json
check "cases" "$(value cases)" 2

# bad TEXT CASE: checks that the case is refused in a line that contains TEXT
bad() {
    printf '%s' "$2" >bad.json
    refuse 2 "$1" validate --case bad.json --backends "$one"
}
case='"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "1"'
bad "bad.json:" ''
bad "bad.json:" '{'
bad "no case of osteon" '[]'
bad "bad.json:" '7'
bad "no case of osteon" '{"osteon_case": 2}'
bad "'cases' must be" '{"cases": []}'
bad "'tier'" '{"osteon_case": 1, "id": "sweep/0", "tier": "plonk", "seed": "1"}'
bad "'seed'" '{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": 1}'
bad "'seed'" '{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "-1"}'
bad "has no case" '{"osteon_case": 1, "id": "sweep/9", "tier": "smoke", "seed": "1"}'
bad "has no case" '{"osteon_case": 1, "id": 9, "tier": "smoke", "seed": "1"}'
bad "no object" "{$case, \"keep\": 3}"
bad "does not know" "{$case, \"keep\": {\"plonk\": 1}}"
bad "neither true nor false" "{$case, \"keep\": {\"ct\": 0}}"
bad "'crop' must be" "{$case, \"keep\": {\"crop\": [[0, 0, 0], [0, 1, 1]]}}"
bad "'crop' must be" "{$case, \"keep\": {\"crop\": [[0, 0, 0], [99999999, 1, 1]]}}"
bad "'crop' must be" "{$case, \"keep\": {\"crop\": {}}}"
bad "must be [[from" "{$case, \"keep\": {\"ticks\": [[3, 2]]}}"
bad "must be [[from" "{$case, \"keep\": {\"ticks\": [[3, 5], [4, 9]]}}"
bad "must be [[from" "{$case, \"keep\": {\"samples\": [[-1, 5]]}}"
bad "must be [[from" "{$case, \"keep\": {\"samples\": [[0, 4294967296]]}}"
bad "'no_tools'" "{$case, \"keep\": {\"no_tools\": [4]}}"
bad "'triangles'" "{$case, \"keep\": {\"triangles\": [[0, 2, 0, 1]]}}"
bad "'triangles'" "{$case, \"keep\": {\"triangles\": [[0, 0, 0]]}}"
bad "nothing of the grid" "{$case, \"keep\": {\"crop\": [[5000, 0, 0], [5001, 1, 1]]}}"
bad "no sample is left" "{$case, \"keep\": {\"samples\": []}}"
refuse 2 "nowhere.json" validate --case nowhere.json
refuse 2 "cannot be combined with --only" validate --case small.json --only mesh
[ ! -e c ] || fail "an output appeared"
finish
