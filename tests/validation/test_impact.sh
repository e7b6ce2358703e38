#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests the report of changes since an older bundle (osteon validate --against): no change, and
# changes of a seed, a compiler and a library, a requirement, a verdict, and a result.
# Covers: REQ-IMPACT
. "${srcdir:-.}/tests/app/lib.sh"
python=$(command -v python3) || { echo "skipped: python3 is not installed"; exit 77; }

one='cpu:isa=scalar,threads=1'
run 0 validate --only import/0 --backends "$one" --out old --quiet
# make_new OLD: makes a bundle "new" that is compared with OLD
make_new() {
    rm -rf new
    run 0 validate --only import/0 --backends "$one" --out new --against "$1" --json
    run_out=$(cat out)
}
# edit FILE EXPRESSION: copies old to x and applies EXPRESSION to the JSON object o of FILE
edit() {
    rm -rf x
    cp -r old x
    "$python" - "x/$1" "$2" <<'PY'
import json, sys
name, how = sys.argv[1:]
o = json.load(open(name))
exec(how)
open(name, "w").write(json.dumps(o) + "\n")
PY
}
impact() {
    "$json_get" "$1" <new/impact.json
}

make_new old
check "conclusion without changes" "$(impact conclusion)" "no result changed among the cases that both bundles have"
check "compared cases, different cases, explained" "$(impact results.compared) $(impact results.different_cases) $(impact explained)" "1 0 true"
check "changes listed for an equal run" "$("$python" -c 'import json; o = json.load(open("new/impact.json")); print([o[k] for k in ("causes", "libraries", "devices", "requirements", "verdicts")])')" "[[], [], [], [], []]"
check "root of the older bundle" "$(impact against.root)" "$("$json_get" root <old/manifest.json)"
check "conclusion in the output of --json and in impact.json" "$(echo "$run_out" | "$json_get" impact.conclusion)" "$(impact conclusion)"
run 0 verify new
grep -q "Changes since an older bundle" new/report.html || fail "the report has no section on changes"
check "results_root" "$("$json_get" results_root <new/manifest.json)" "$("$json_get" results_root <old/manifest.json)"

edit tools.json 'o["build"]["compiler"] = "another"; o["libraries"][0]["version"] = "0.0-1"'
make_new x
check "change of the compiler" "$(impact causes.0.what) was $(impact causes.0.old)" "compiler was another"
check "older version of the library" "$(impact libraries.0.old | cut -d, -f1)" "0.0-1"
sed -i '2d' x/requirements.csv
make_new x
check "new requirement" "$(impact requirements.0.what) $(impact requirements.0.old)" "AR-INT-1 absent"

# Changes a verdict, and results with and without a known cause.
edit cases.jsonl 'o["results"]["cpu:isa=scalar,threads=1"]["verdict"] = "differs"'
make_new x
check "changed verdict: case, old, new" "$(impact verdicts.0.case) $(impact verdicts.0.old) $(impact verdicts.0.new)" "import/0 differs equal"
edit cases.jsonl 'o["reference"][0]["sha256"] = "0" * 64'
make_new x
check "changed result without a cause: explained, different cases" "$(impact explained) $(impact results.different_cases)" "false 1"
sed -i 's/"arithmetic": [0-9]*/"arithmetic": 1/' x/protocol.json
make_new x
check "changed result with another arithmetic version: explained, cause, old" "$(impact explained) $(impact causes.0.what) $(impact causes.0.old)" "true arithmetic 1"
edit cases.jsonl 'del o["reference"][-1]'
make_new x
check "conclusion with an additional record" "$(impact conclusion)" "cases have records of other stages than in the older bundle, so their results cannot be compared in full"
rm -rf x
run 0 validate --only import/0 --backends "$one" --seed 2 --out x --quiet
make_new x
check "another seed: compared cases, cause, conclusion" "$(impact results.compared) $(impact causes.0.what) $(impact conclusion)" "0 seed no case has the same input in both bundles, so no result was compared"

refuse 2 "not a bundle: protocol.json is missing" validate --against . --out y
refuse 2 "--against needs --out" validate --against old
refuse 2 "--faults needs --faults-only" validate --faults 3
[ ! -e y ] || fail "a bundle was begun"
finish
