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
check "campaign with a reduced case: equal" "$(value equal)" true
check "evidence of a campaign with a case from a file" "$(value evidence)" false
run 0 verify b --rerun --json
check "verify --rerun: rerun" "$(value rerun)" true
cmp -s b/case.json small.json && fail "case.json of the bundle is a copy of the file instead of the bundle's form"
run 0 validate --case b/case.json --backends "$one" --out b2
check "cases.jsonl of a second campaign with case.json" "$(cmp b/cases.jsonl b2/cases.jsonl && echo same)" same
grep -q -- '--case case.json' b/README.md || fail "README.md does not contain the command with case.json"
echo '{"cases": [{"osteon_case": 1, "id": "mesh/0", "tier": "smoke", "seed": "1"}, {"osteon_case": 1, "id": "mesh/1", "tier": "smoke", "seed": "2"}]}' >two.json
run 0 validate --case two.json --backends "$one" --json
check "number of cases" "$(value cases)" 2

# check_refused TEXT CASE: checks that the case is refused in a line that contains TEXT
check_refused() {
    printf '%s' "$2" >bad.json
    refuse 2 "$1" validate --case bad.json --backends "$one"
}
case='"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "1"'
check_refused "bad.json:" ''
check_refused "bad.json:" '{'
check_refused "no case of osteon" '[]'
check_refused "bad.json:" '7'
check_refused "no case of osteon" '{"osteon_case": 2}'
check_refused "'cases' must be" '{"cases": []}'
check_refused "'tier'" '{"osteon_case": 1, "id": "sweep/0", "tier": "plonk", "seed": "1"}'
check_refused "'seed'" '{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": 1}'
check_refused "'seed'" '{"osteon_case": 1, "id": "sweep/0", "tier": "smoke", "seed": "-1"}'
check_refused "has no case" '{"osteon_case": 1, "id": "sweep/9", "tier": "smoke", "seed": "1"}'
check_refused "has no case" '{"osteon_case": 1, "id": 9, "tier": "smoke", "seed": "1"}'
check_refused "no object" "{$case, \"keep\": 3}"
check_refused "does not know" "{$case, \"keep\": {\"plonk\": 1}}"
check_refused "neither true nor false" "{$case, \"keep\": {\"ct\": 0}}"
check_refused "'crop' must be" "{$case, \"keep\": {\"crop\": [[0, 0, 0], [0, 1, 1]]}}"
check_refused "'crop' must be" "{$case, \"keep\": {\"crop\": [[0, 0, 0], [99999999, 1, 1]]}}"
check_refused "'crop' must be" "{$case, \"keep\": {\"crop\": {}}}"
check_refused "must be [[from" "{$case, \"keep\": {\"ticks\": [[3, 2]]}}"
check_refused "must be [[from" "{$case, \"keep\": {\"ticks\": [[3, 5], [4, 9]]}}"
check_refused "must be [[from" "{$case, \"keep\": {\"samples\": [[-1, 5]]}}"
check_refused "must be [[from" "{$case, \"keep\": {\"samples\": [[0, 4294967296]]}}"
check_refused "'no_tools'" "{$case, \"keep\": {\"no_tools\": [4]}}"
check_refused "'triangles'" "{$case, \"keep\": {\"triangles\": [[0, 2, 0, 1]]}}"
check_refused "'triangles'" "{$case, \"keep\": {\"triangles\": [[0, 0, 0]]}}"
check_refused "nothing of the grid" "{$case, \"keep\": {\"crop\": [[5000, 0, 0], [5001, 1, 1]]}}"
check_refused "no sample is left" "{$case, \"keep\": {\"samples\": []}}"
refuse 2 "nowhere.json" validate --case nowhere.json
refuse 2 "cannot be combined with --only" validate --case small.json --only mesh
[ ! -e c ] || fail "a refused campaign left the folder c"
finish
