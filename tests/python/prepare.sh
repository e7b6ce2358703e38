# shellcheck shell=sh
# SPDX-License-Identifier: Apache-2.0
# Sourced by the tests of the Python package: skips a test that cannot run, and makes the folder $work.
set -u
build=$(pwd)
source_folder=$(cd "${srcdir:-.}" && pwd)
python=${PYTHON3:-python3}
work=$build/tests/python/$(basename "$0" .sh)

skip() {
    echo "SKIP: $*"
    exit 77
}

[ -z "${OST_SAN_CFLAGS:-}" ] || skip "a build with sanitizers, which Python cannot load"
for library in ASSIMP NIFTI PNG; do
    grep -q "^#define HAVE_$library 1" "$build/config.h" || skip "built without $library"
done
[ -e "$build/.libs/libosteon.so" ] || skip "a build without a shared library"
command -v "$python" >/dev/null || skip "no $python"
for name in cffi numpy pytest setuptools pip; do
    "$python" -W ignore -c "import $name" 2>/dev/null || skip "no python3-$name (for $python)"
done
"$python" -W ignore -c '
import setuptools
if tuple(int(n) for n in setuptools.__version__.split(".")[:2]) < (70, 1): import wheel' 2>/dev/null ||
    skip "no python3-wheel (for $python)"
"$python" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' ||
    skip "no Python.h (python3-dev, for $python)"

rm -rf "$work"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work" || exit 99
PYTHONDONTWRITEBYTECODE=1
PIP_DISABLE_PIP_VERSION_CHECK=1
export PYTHONDONTWRITEBYTECODE PIP_DISABLE_PIP_VERSION_CHECK

# build NAME COMMAND...: runs the command, and shows the end of its output after a failure
build() {
    log=$work/$1.log
    shift
    "$@" >"$log" 2>&1 || {
        tail -n 40 "$log"
        echo "FAIL: $*"
        exit 1
    }
}

# run_tests PYTHON COMMAND [ARGUMENT...]: runs the tests of the package with an interpreter, the program osteon, and
# arguments for pytest
run_tests() {
    interpreter=$1
    OSTEON=$2
    OSTEON_SOURCE=$source_folder
    export OSTEON OSTEON_SOURCE
    shift 2
    "$interpreter" -W ignore -m pytest -q -p no:cacheprovider --basetemp "$work/tmp" \
        --rootdir "$source_folder/tests/python" "$source_folder/tests/python" "$@"
}
