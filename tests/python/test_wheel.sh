#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Packs the library of this build folder into a wheel, installs the wheel into a new virtual environment without a
# package index, and runs the tests of the package with it. PYTHON3 selects the interpreter.
#
#   python/build-wheel --> dist/osteon-*-manylinux_*.whl --pip install--> venv --> pytest, and the command in venv/bin
#
# Covers: REQ-PYTHON
. "${srcdir:-.}/tests/python/prepare.sh"
cd "$work" || exit 99
interpreter=$("$python" -c 'import sys; print(sys.executable)')
"$python" -c "import venv" 2>/dev/null || skip "no module venv (for $python)"
# all names are relative, as a user may write them
(
    cd / || exit 99
    OSTEON_BUILD=${build#/} PYTHON3=${interpreter#/} "$source_folder/python/build-wheel" "${work#/}/dist"
) >wheel.log 2>&1
case $? in
0) ;;
3) skip "$(cat wheel.log)" ;;
*)
    tail -n 40 wheel.log
    exit 1
    ;;
esac
build venv "$python" -m venv --system-site-packages --without-pip venv
# numpy and cffi are used from the interpreter, which may itself belong to a virtual environment
"$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))' \
    >"$(venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/base.pth"
build install "$python" -W ignore -m pip --python venv/bin/python install -q --no-index --no-deps dist/osteon-*manylinux*.whl

# The package osteon, the command osteon and the library with its libraries must come from the environment.
"$work/venv/bin/python" - "$work/venv/" <<'END' || exit 1
import sys
import osteon
with open("/proc/self/maps", encoding="utf-8") as file:
    loaded = {line.split(None, 5)[5].strip() for line in file if line.count("/")}
own = {name for name in loaded if any(part in name.rsplit("/", 1)[1] for part in ("osteon", "assimp", "nifti", "jansson"))}
wrong = sorted(name for name in own if not name.startswith(sys.argv[1]))
assert len(own) >= 5 and not wrong, (sorted(own), wrong)
assert osteon.cases.command().startswith(sys.argv[1]), osteon.cases.command()
END
unset OSTEON_BUILD
run_tests "$work/venv/bin/python" "$work/venv/bin/osteon" "$@"
