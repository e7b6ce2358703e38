# SPDX-License-Identifier: Apache-2.0
# Definitions that the shell tests of the command share. Each test runs in the build folder,
# works in its own scratch folder, and ends with `finish`.

set -u
build=$(pwd)
source_folder=$(cd "${srcdir:-.}" && pwd)
osteon=${OSTEON:-$build/osteon}
json_get=$build/tests/app/json_get
scratch=$(mktemp -d) || exit 99
trap 'rm -rf "$scratch"' EXIT
cd "$scratch" || exit 99
failures=0
checks=0

fail() {
    failures=$((failures + 1))
    echo "FAIL: $*"
}

# needs LIBRARY...: skips the test if osteon was built without one of them (ASSIMP, NIFTI, PNG)
needs() {
    for library in "$@"; do
        grep -q "^#define HAVE_$library 1" "$build/config.h" && continue
        echo "skipped: built without $library"
        exit 77
    done
}

# check WHAT GOT EXPECTED: fails the test if GOT differs from EXPECTED
check() {
    checks=$((checks + 1))
    [ "$2" = "$3" ] || fail "$1: got '$2', expected '$3'"
}

# run STATUS ARGUMENT...: runs osteon, checks its exit status, and stores its output in the files
# out and err
run() {
    expected=$1
    shift
    checks=$((checks + 1))
    "$osteon" "$@" >out 2>err
    status=$?
    if [ $status -ne "$expected" ]; then
        fail "osteon $*: status $status, expected $expected: $(head -c 300 err)"
        return 1
    fi
}

# refuse STATUS TEXT ARGUMENT...: checks that osteon ends with the status, prints nothing on
# standard output, and prints one line that contains TEXT on standard error
refuse() {
    expected=$1
    text=$2
    shift 2
    run "$expected" "$@" || return
    check "osteon $*: bytes on standard output" "$(wc -c <out | tr -d ' ')" 0
    check "osteon $*: lines on standard error" "$(wc -l <err | tr -d ' ')" 1
    checks=$((checks + 1))
    grep -qF -- "$text" err || fail "osteon $*: standard error '$(cat err)' does not contain '$text'"
}

# value PATH: prints a value of the JSON object in the file out
value() {
    "$json_get" "$1" <out
}

# has KEY...: checks that the JSON object in the file out has each key
has() {
    for key in "$@"; do
        checks=$((checks + 1))
        "$json_get" "$key" <out >/dev/null || fail "the JSON object has no key $key: $(head -c 200 out)"
    done
}

# need_part NAME WHY: skips the test if an optional part is not built in
need_part() {
    "$osteon" devices | grep -q "^  $1 *yes" || {
        echo "skipped: $2"
        exit 77
    }
}

# ct_text NX NY NZ S EXPRESSION: prints a CT text of NX x NY x NZ voxels with the spacing S;
# EXPRESSION is an awk expression of i, j and k that gives the density
ct_text() {
    awk -v nx="$1" -v ny="$2" -v nz="$3" -v s="$4" "BEGIN {
        for (k = 0; k < nz; k++) for (j = 0; j < ny; j++) for (i = 0; i < nx; i++)
            printf \"%.4f %.4f %.4f %d\n\", i * s, j * s, k * s, $5
    }"
}

finish() {
    echo "$checks checks, $failures failed"
    [ $failures -eq 0 ]
    exit $?
}
