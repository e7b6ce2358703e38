#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Checks the pipelines in examples/ci: that they have the same jobs, and that the commands work here.
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

# The pipelines of GitHub, GitLab and Jenkins must have the same jobs, with commands that exist, and publish the report
# and the bundle.
python=${PYTHON3:-python3}
if "$python" -c 'import yaml' 2>/dev/null; then
    checks=$((checks + 2))
    PYTHONDONTWRITEBYTECODE=1 "$python" "$source_folder/.ci/pipelines" --list >jobs || fail "the files do not have the form that .ci/pipelines reads"
    for file in github-actions.yml gitlab-ci.yml Jenkinsfile; do
        sed -n "s/^$file\t//p" jobs | sort >"jobs of $file"
        check "$file: jobs" "$(cat "jobs of $file")" "$(cat "jobs of github-actions.yml")"
        check "$file: publishes the report and the bundle" "$(grep -c '\(junit\|report_paths\).*bundle/junit.xml\|^ *- bundle/$\|path: bundle/$\|artifacts: .bundle ' "$ci/$file")" 2
        check "$file: caches the compiler's results" "$(grep -c 'CCACHE_DIR[:=]' "$ci/$file")" 1
    done
    cut -f 3- jobs | tr '\t' '\n' | cut -d ' ' -f 1 | sort -u >scripts
    check "scripts of the jobs" "$(tr '\n' ' ' <scripts)" "examples/ci/build examples/ci/compare examples/ci/opencl "
    while read -r script; do
        checks=$((checks + 1))
        [ -x "$source_folder/$script" ] || fail "there is no $script"
    done <scripts
    for implementation in $(cut -f 3- jobs | tr '\t' '\n' | sed -n 's|.*/opencl \([a-z]*\) .*|\1|p' | sort -u); do
        checks=$((checks + 1))
        grep -q "^$implementation)\$" "$ci/opencl" || fail "opencl: no implementation '$implementation'"
    done
else
    echo "$python has no module yaml: the jobs of the pipelines are not checked"
fi
for script in build compare opencl; do
    checks=$((checks + 1))
    sh -n "$ci/$script" || fail "$script: syntax"
done
checks=$((checks + 1))
"$ci/opencl" unknown bundle >out 2>err && fail "opencl accepts an unknown implementation"
grep -q "unknown implementation 'unknown'" err || fail "opencl says: $(cat err)"

# The packages that build installs come from quickstart.
check "the packages of quickstart" "$("$source_folder/quickstart" packages | grep -cx 'libssl-dev\|gcc\|pocl-opencl-icd')" 3
finish
