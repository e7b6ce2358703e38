#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Builds the Python package in python/ against the library of this build folder, as a user does, and runs its tests.
# Nothing is written to the source tree, and no package index is needed. PYTHON3 selects the interpreter.
#
#   python/ --copy--> package --sdist--> osteon-*.tar.gz --pip wheel--> osteon-*.whl --pip install--> site --> pytest
#
# Covers: REQ-PYTHON
. "${srcdir:-.}/tests/python/prepare.sh"
cp -R "$source_folder/python" "$work/package" && chmod -R u+w "$work/package" || exit 99
OSTEON_BUILD=$build
export OSTEON_BUILD

cd "$work/package" || exit 99
build sdist "$python" -W ignore -c "from setuptools import build_meta; build_meta.build_sdist('$work/dist')"
cd "$work" || exit 99
build wheel "$python" -W ignore -m pip wheel -q --no-index --no-deps --no-build-isolation -w dist dist/osteon-*.tar.gz
build install "$python" -W ignore -m pip install -q --no-index --no-deps --target site dist/osteon-*.whl
PYTHONPATH=$work/site${PYTHONPATH:+:$PYTHONPATH}
export PYTHONPATH
run_tests "$python" "${OSTEON:-$build/osteon}" "$@"
