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
GITHUB_STEP_SUMMARY=summary "$ci/compare" bundle --only import/0 --backends 'cpu:isa=scalar,threads=1' >out 2>err || fail "examples/ci/compare: status $?, expected 0: $(tail -n 3 err)"
check "first line of the summary" "$(head -n 1 summary)" "# Backend equivalence verification: EQUAL"
checks=$((checks + 2))
grep -q '<testcase classname="cpu:isa=scalar,threads=1" name="import/0" time="[0-9.]*"/>' bundle/junit.xml || fail "junit.xml does not contain the case import/0"
"$ci/compare" bundle >out 2>err && fail "examples/ci/compare overwrites an existing bundle"
# On an absent backend nothing is compared, and the exit status must be passed on.
checks=$((checks + 1))
"$ci/compare" none --only import/0 --backends 'cl:platform=nowhere' >out 2>err && fail "examples/ci/compare returns 0 although nothing was compared"

# The pipelines of GitHub, GitLab and Jenkins must have the same jobs, with commands that exist, and publish the report
# and the bundle.
python=${PYTHON3:-python3}
if "$python" -c 'import yaml' 2>/dev/null; then
    checks=$((checks + 2))
    PYTHONDONTWRITEBYTECODE=1 "$python" "$source_folder/.ci/pipelines" --list >jobs || fail "the files do not have the form that .ci/pipelines reads"
    for file in github-actions.yml gitlab-ci.yml Jenkinsfile; do
        sed -n "s/^$file\t//p" jobs | sort >"jobs of $file"
        check "$file: jobs" "$(cat "jobs of $file")" "$(cat "jobs of github-actions.yml")"
    done
    for results in bundle slowdown; do
        for file in github-actions.yml gitlab-ci.yml; do
            check "$file: publishes the report and $results" "$(grep -c "\(junit\|report_paths\): $results/junit.xml\|^ *- $results/\$\|path: $results/\$" "$ci/$file")" 2
        done
    done
    check "Jenkinsfile: publishes the report and the results" "$(grep -c 'junit testResults: "${results}/junit.xml"\|artifacts: .results ' "$ci/Jenkinsfile")" 2
    check "uses of CCACHE_DIR in each pipeline" "$(grep -c 'CCACHE_DIR[:=]' "$ci/github-actions.yml" "$ci/gitlab-ci.yml" "$ci/Jenkinsfile" | sed 's|.*/||' | tr '\n' ' ')" "github-actions.yml:2 gitlab-ci.yml:2 Jenkinsfile:1 "
    cut -f 3- jobs | tr '\t' '\n' | cut -d ' ' -f 1 | sort -u >scripts
    check "scripts of the jobs" "$(tr '\n' ' ' <scripts)" "examples/ci/build examples/ci/compare examples/ci/opencl examples/ci/slowdown "
    while read -r script; do
        checks=$((checks + 1))
        [ -x "$source_folder/$script" ] || fail "the script $script of a job does not exist or is not executable"
    done <scripts
    for implementation in $(cut -f 3- jobs | tr '\t' '\n' | sed -n 's|.*/opencl \([a-z]*\) .*|\1|p' | sort -u); do
        checks=$((checks + 1))
        grep -q "^$implementation)\$" "$ci/opencl" || fail "examples/ci/opencl does not support the implementation '$implementation'"
    done
else
    echo "not tested, because $python has no module yaml: the jobs of the pipelines"
fi
for script in build compare opencl; do
    checks=$((checks + 1))
    sh -n "$ci/$script" || fail "$script: sh -n reports a syntax error"
done
checks=$((checks + 1))
"$ci/opencl" unknown bundle >out 2>err && fail "examples/ci/opencl accepts an unknown implementation"
grep -q "unknown implementation 'unknown'" err || fail "wrong error of examples/ci/opencl: $(cat err)"

# The program `fake` simulates osteon bench --json. Each line of the file `turns` gives the exit status and the rows of
# one run with --against. A row consists of its name, its slowdown in percent, and true if this is too slow.
cat >fake <<'END'
#!/bin/sh
case " $* " in
*" --suite wrong-usage "*) exit 2 ;;
*" --suite absent "*) exit 3 ;;
*" --against "*) ;;
*) echo '{"rows": []}' && exit 0 ;;
esac
echo "$@" >>arguments
read -r status rows <turns
sed -i 1d turns
[ "$rows" != wrong ] || { echo '{"rows": [{"name": "w", "equal": false}]}'; exit 1; }
echo "$rows" | awk '{
    printf "{\"rows\": [{\"name\": \"a\", \"equal\": true}, {\"name\": \"b\", \"equal\": null}], \"against\": {\"rows\": ["
    for (i = 1; i + 2 <= NF; i += 3)
        printf "%s{\"name\": \"%s\", \"slowdown_percent\": %s, \"slower\": %s}", (i > 1) ? ", " : "", $i, $(i + 1), $(i + 2)
    print "]}}" }'
exit "$status"
END
chmod +x fake
mkdir -p path
ln -s ../fake path/osteon
# slowdown STATUS TURN...: runs the script slowdown with the program `fake` and checks the exit status. Each TURN is a
# line of the file `turns`.
slowdown() {
    expected=$1
    shift
    printf '%s\n' "$@" >turns
    rm -rf slow arguments
    # shellcheck disable=SC2086 # a list of words
    PATH=$scratch/path:$PATH "$python" "$ci/slowdown" slow "$scratch/fake" $options >out 2>err
    check "slowdown with $*: exit status, turns that were not used" "$? $(cat turns)" "$expected "
}
if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 7))' 2>/dev/null; then
    options='--suite removal --max-slowdown 5%'
    slowdown 0 '0 a 1 false b -3.25 false'
    check "arguments with the limit" "$(cat arguments)" "bench --suite removal --against slow/old-1.json --max-slowdown 5% --json"
    check "rows that passed in junit.xml" "$(grep -c '<testcase classname="slowdown" name="[ab]" time="0"></testcase>' slow/junit.xml)" 2
    options=--max-slowdown=7%
    slowdown 1 '1 a 12 true b 0 false' '1 a 13 true b 50 true' '1 a 14.5 true b 0 false'
    check "arguments with the limit" "$(head -n 1 arguments)" "bench --against slow/old-1.json --max-slowdown 7% --json"
    check "slower row in junit.xml" "$(grep -o 'name="."[^/]*failure message[^/]*' slow/junit.xml)" 'name="a" time="0"><failure message="slowdown 12.0 %, 13.0 %, 14.5 %; allowed: 7%"'
    check "row of the table" "$(grep '`a`' out)" "| \`a\` | 12.0 %, 13.0 %, 14.5 % | slower |"
    options=
    # A row counts as slower only if it is slower in every turn.
    slowdown 0 '1 a 12 true b 0 false' '0 a 1 false b 0 false'
    slowdown 0 '1 a 12 true b 0 false' '1 a 1 false b 30 true'
    slowdown 0 '1 a 1 false c/cold/1 60 true'
    check "rows with cold caches in junit.xml" "$(grep -c cold slow/junit.xml)" 0
    slowdown 1 '1 wrong'
    grep -q 'the grid differs from the reference: w' err || fail "the error does not name the row whose grid differs: $(cat err)"
    slowdown 3 '2' # no row is in both runs
    slowdown 3 '1 c/cold 60 true'
    options='--suite wrong-usage' && slowdown 2 ''
    options='--suite absent' && slowdown 3 ''
    # Tests that the script slowdown can read the output of the real osteon bench.
    checks=$((checks + 1))
    "$python" "$ci/slowdown" slow "$osteon" --suite removal --filter peg/32/steady/1 --quick --max-slowdown 1000% >out 2>err ||
        fail "slowdown with the real osteon bench: status $?, expected 0: $(tail -n 3 err)"
    check "rows that passed in junit.xml" "$(grep -c '<testcase classname="slowdown" name="removal/peg/32/steady/1" time="0"></testcase>' slow/junit.xml)" 1
    checks=$((checks + 1))
    "$python" "$ci/slowdown" slow >out 2>err
    [ $? -eq 2 ] || fail "slowdown without a revision: status $?, expected 2"
fi

# The script examples/ci/build installs the packages that quickstart prints. They must include these three packages.
check "expected packages that quickstart prints" "$("$source_folder/quickstart" packages | grep -cx 'libssl-dev\|gcc\|pocl-opencl-icd')" 3
finish
