#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Links osteon with an OpenCL program in which one line of a kernel is changed. osteon validate must
# detect the change, locate and classify the difference, and write a small case that one command
# reproduces. With the unchanged kernel, the result of this case must be equal.
#
#   kernels --one line changed--> tests/validation/osteon_broken --validate--> bundle
#
# With OST_TEST_KEEP=FOLDER the bundles are stored there for inspection. The test needs OpenCL,
# make and a compiler, and takes minutes. Without OST_TEST_LONG=1 it only checks that the lines to
# change still exist.
# Covers: REQ-BROKEN-KERNEL
. "${srcdir:-.}/tests/app/lib.sh"

long=${OST_TEST_LONG:-}
grep -q '^#define HAVE_OPENCL 1' "$build/config.h" || { echo "skipped: built without OpenCL"; exit 77; }
if [ -n "$long" ]; then
    "$osteon" devices --json >out 2>err
    "$osteon" validate --backends cl --only mesh/0 >out 2>err || { echo "skipped: no OpenCL device gives equal results: $(tail -n 1 err)"; exit 77; }
fi

export XDG_CACHE_HOME="$scratch/cache" POCL_CACHE_DIR="$scratch/pocl"

# check_kernel NAME CASES STAGE CLASS FILE FROM TO [FILE FROM TO]: changes one line of each kernel, in
# the set for CPUs and in the set for GPUs, and checks the finding
check_kernel() {
    name=$1 cases=$2 stage=$3 class=$4
    shift 4
    rm -rf kernels
    mkdir -p kernels/src/cl cache pocl
    cp -R "$source_folder/src/cl/kernels" kernels/src/cl/
    chmod -R u+w kernels
    while [ $# -gt 0 ]; do
        check "$name: lines that are changed in $1" "$(grep -cF -- "$2" "kernels/src/cl/kernels/$1")" 1
        awk -v from="$2" -v to="$3" '{
            at = index($0, from)
            if (at) $0 = substr($0, 1, at - 1) to substr($0, at + length(from))
            print
        }' "$source_folder/src/cl/kernels/$1" >"kernels/src/cl/kernels/$1"
        shift 3
    done
    [ -n "$long" ] || return 0
    rm -f "$build/tests/validation/broken_embedded.c"
    if ! make -C "$build" -s tests/validation/osteon_broken BROKEN_KERNELS="$scratch/kernels" >make.log 2>&1; then
        fail "$name: osteon_broken cannot be built: $(tail -n 5 make.log)"
        return
    fi
    right=$osteon
    osteon=$build/tests/validation/osteon_broken
    run 1 validate --only "$cases" --backends cl:device=0 --limit 900 --out "b-$name" --json
    check "$name: equal" "$(value equal)" false
    check "$name: stage" "$(value findings.0.stage)" "$stage"
    check "$name: class" "$(value findings.0.class)" "$class"
    small=$(value findings.0.reproduce)
    [ -f "b-$name/$small" ] || fail "$name: the bundle has no small case"
    run 1 validate --case "b-$name/$small" --backends cl:device=0 --limit 900 --json
    check "$name: stage of the small case" "$(value findings.0.stage)" "$stage"
    check "$name: class of the small case" "$(value findings.0.class)" "$class"
    run 0 verify "b-$name" --rerun
    grep -q "osteon validate --case $small" "b-$name/report.html" || fail "$name: the report does not contain the command for the small case"
    osteon=$right
    run 0 validate --case "b-$name/$small" --backends cl:device=0 --limit 900 --json
    [ -z "${OST_TEST_KEEP:-}" ] || cp -R "b-$name" "$OST_TEST_KEEP/"
}

check_kernel removal-report sweep/0 tick report-only \
    remove_cpu.cl 'counts &= d >= border' 'counts &= d > border' \
    remove.cl 'd >= border ? 1u' 'd > border ? 1u'
check_kernel removal-map sweep/0 tick boundary-layer \
    remove_cpu.cl '(uint)entry->base[a] + 0x40000000u' '(uint)entry->base[a] + 0x40001000u' \
    remove.cl 'ux = entry.base[0] + j' 'ux = entry.base[0] + 4096 + j'
check_kernel voxelize mesh/ tool column-parity voxelize.cl 'e0 < 0 ||' 'e0 <= 0 ||'
check_kernel resampling sweep/0 cubic shift import.cl 'ost_floor_div(t, 2 * s);' 'ost_floor_div(t > 0 ? t - 1 : 0, 2 * s);'
[ -n "$long" ] || [ $failures -gt 0 ] || { echo "skipped: the lines to change exist; the other checks run only with OST_TEST_LONG=1"; exit 77; }
rm -f "$build/tests/validation/osteon_broken" "$build/tests/validation/broken_embedded.c"
finish
