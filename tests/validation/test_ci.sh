#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Checks that the workflows in examples/ci are valid YAML, list the packages of quickstart, and
# run commands that work here.
# Covers: REQ-CI
. "${srcdir:-.}/tests/app/lib.sh"
ci=$source_folder/examples/ci
PATH=$(dirname "$osteon"):$PATH
export PATH

# Runs the command that both workflows run. A summary file simulates GitHub.
checks=$((checks + 1))
GITHUB_STEP_SUMMARY=summary "$ci/compare" bundle --only import/0 --backends 'cpu:isa=scalar,threads=1' >out 2>err || fail "compare: status $?: $(tail -n 3 err)"
check "the summary" "$(head -n 1 summary)" "# Backend equivalence verification: EQUAL"
checks=$((checks + 2))
grep -q '<testcase classname="cpu:isa=scalar,threads=1" name="import/0" time="[0-9.]*"/>' bundle/junit.xml || fail "junit.xml has no case"
"$ci/compare" bundle >out 2>err && fail "compare overwrites a bundle"
# On an absent backend nothing is compared, and the exit status must be passed on.
checks=$((checks + 1))
"$ci/compare" none --only import/0 --backends 'cl:platform=nowhere' >out 2>err && fail "compare passes with nothing compared"

# The packages must be those of quickstart, except for packages that are needed only for its tests, for
# OpenGL or to make keys.
sed -n "/^	cat <<'END'$/,/^END$/p" "$source_folder/quickstart" | sed '1d;$d' | awk '{ print $1 }' | grep -v '^\(libcmocka-dev\|python3\|openssl\|libgl1-mesa-dri\|libegl-mesa0\)$' | sort >wanted
check "the packages of quickstart are found" "$(grep -cx 'libssl-dev\|gcc\|pocl-opencl-icd' wanted)" 3
for file in github-actions gitlab-ci; do
    grep -v '^ *#' "$ci/$file.yml" | tr ' ' '\n' | grep -xFf wanted | sort -u >named
    checks=$((checks + 1))
    cmp -s wanted named || fail "$file.yml does not name the packages of quickstart: $(comm -23 wanted named | tr '\n' ' ')"
    checks=$((checks + 1))
    ! grep -q '	' "$ci/$file.yml" || fail "$file.yml has a tab"
    # Blocks must be indented by two spaces.
    checks=$((checks + 1))
    ! grep -nE '^( {2})* [^ #]' "$ci/$file.yml" | grep -q . || fail "$file.yml: odd indentation"
    grep -q 'examples/ci/compare bundle$' "$ci/$file.yml" || fail "$file.yml does not run compare"
    grep -q 'bundle/junit.xml' "$ci/$file.yml" || fail "$file.yml shows no report"
done
if command -v python3 >/dev/null && python3 -c 'import yaml' 2>/dev/null; then
    checks=$((checks + 1))
    python3 - "$ci" <<'END' || fail "the workflows do not have the form that GitHub and GitLab require"
import sys, yaml
hub = yaml.safe_load(open(sys.argv[1] + "/github-actions.yml"))
lab = yaml.safe_load(open(sys.argv[1] + "/gitlab-ci.yml"))
job = hub["jobs"]["compare"]
assert hub[True].keys() == {"push", "pull_request"}, "on is read as true"
assert job["runs-on"] and all(("run" in s) != ("uses" in s) for s in job["steps"])
assert [s["run"] for s in job["steps"] if s.get("name") == "Compare"] == ["examples/ci/compare bundle"]
assert lab["backends"]["stage"] in lab["stages"] and lab["backends"]["script"] == ["examples/ci/compare bundle"]
assert lab["backends"]["artifacts"]["reports"]["junit"] == "bundle/junit.xml"
assert all(isinstance(line, str) for line in lab["backends"]["before_script"])
END
else
    echo "python3 has no module yaml: the workflows are checked line by line only"
fi
finish
