#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Builds the Python package in python/ against the library of this build folder, as a user does, and runs its tests.
# Nothing is written to the source tree, and no package index is needed. PYTHON3 selects the interpreter.
#
#   python/ --copy--> package --sdist--> osteon-*.tar.gz --pip wheel--> osteon-*.whl --pip install--> site --> pytest
#
# Covers: REQ-PYTHON
set -u
build=$(pwd)
source_folder=$(cd "${srcdir:-.}" && pwd)
python=${PYTHON3:-python3}
work=$build/tests/python/work

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
mkdir -p "$work" && cp -R "$source_folder/python" "$work/package" && chmod -R u+w "$work/package" || exit 99
PYTHONDONTWRITEBYTECODE=1
PIP_DISABLE_PIP_VERSION_CHECK=1
OSTEON_BUILD=$build
OSTEON_SOURCE=$source_folder
OSTEON=${OSTEON:-$build/osteon}
export PYTHONDONTWRITEBYTECODE PIP_DISABLE_PIP_VERSION_CHECK OSTEON_BUILD OSTEON_SOURCE OSTEON

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

cd "$work/package" || exit 99
build sdist "$python" -W ignore -c "from setuptools import build_meta; build_meta.build_sdist('$work/dist')"
cd "$work" || exit 99
build wheel "$python" -W ignore -m pip wheel -q --no-index --no-deps --no-build-isolation -w dist dist/osteon-*.tar.gz
build install "$python" -W ignore -m pip install -q --no-index --no-deps --target site dist/osteon-*.whl
PYTHONPATH=$work/site${PYTHONPATH:+:$PYTHONPATH}
export PYTHONPATH
"$python" -W ignore -m pytest -q -p no:cacheprovider --basetemp "$work/tmp" --rootdir "$source_folder/tests/python" \
    "$source_folder/tests/python" "$@"
