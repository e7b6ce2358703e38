#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# A kernel that is broken on purpose: osteon is linked with an OpenCL program
# that has one line changed, and validate must catch it, say where and what it
# looks like, and leave a small case that shows the same by one command; and
# the same case must be equal on the kernel as it is.
#
#   kernels --one line changed--> tests/validation/osteon_broken --validate--> bundle
#
# With OST_TEST_KEEP=FOLDER the bundles are left there, to be looked at.
# Needs OpenCL, make and a compiler, and takes minutes: skipped but with
# OST_TEST_LONG.
# Covers: REQ-BROKEN-KERNEL
. "${srcdir:-.}/tests/app/lib.sh"

[ -n "${OST_TEST_LONG:-}" ] || { echo "only with OST_TEST_LONG"; exit 77; }
grep -q '^#define HAVE_OPENCL 1' "$build/config.h" || { echo "built without OpenCL"; exit 77; }
"$osteon" devices --json >out 2>err
"$osteon" validate --backends cl --only mesh/0 >out 2>err || { echo "no OpenCL device is equal here: $(tail -n 1 err)"; exit 77; }

export XDG_CACHE_HOME="$scratch/cache" POCL_CACHE_DIR="$scratch/pocl"

# broken NAME FILE FROM TO CASES STAGE CLASS: one line of a kernel changed, and what must be found
broken() {
    name=$1 file=$2 from=$3 to=$4 cases=$5 stage=$6 class=$7
    rm -rf kernels
    mkdir -p kernels/src/cl cache pocl
    cp -R "$source_folder/src/cl/kernels" "$source_folder/src/cl/embed" kernels/src/cl/
    chmod -R u+w kernels
    check "$name: lines that are changed" "$(grep -cF -- "$from" "kernels/src/cl/kernels/$file")" 1
    awk -v from="$from" -v to="$to" '{
        at = index($0, from)
        if (at) $0 = substr($0, 1, at - 1) to substr($0, at + length(from))
        print
    }' "$source_folder/src/cl/kernels/$file" >"kernels/src/cl/kernels/$file"
    rm -f "$build/tests/validation/broken_embedded.c"
    if ! make -C "$build" -s tests/validation/osteon_broken BROKEN_KERNELS="$scratch/kernels" >make.log 2>&1; then
        fail "$name: $(tail -n 5 make.log)"
        return
    fi
    right=$osteon
    osteon=$build/tests/validation/osteon_broken
    run 1 validate --only "$cases" --backends cl:device=0 --out "b-$name" --json
    check "$name: verdict" "$(value equal)" false
    check "$name: stage" "$(value findings.0.stage)" "$stage"
    check "$name: class" "$(value findings.0.class)" "$class"
    small=$(value findings.0.reproduce)
    [ -f "b-$name/$small" ] || fail "$name: no small case"
    run 1 validate --case "b-$name/$small" --backends cl:device=0 --json
    check "$name: stage of the small case" "$(value findings.0.stage)" "$stage"
    check "$name: class of the small case" "$(value findings.0.class)" "$class"
    run 0 verify "b-$name" --rerun
    grep -q "osteon validate --case $small" "b-$name/report.html" || fail "$name: the report does not say how to do it again"
    osteon=$right
    run 0 validate --case "b-$name/$small" --backends cl:device=0 --json
    [ -z "${OST_TEST_KEEP:-}" ] || cp -R "b-$name" "$OST_TEST_KEEP/"
}

broken removal-report remove.cl 'counts = d >= border ? is_hit' 'counts = d > border ? is_hit' sweep/0 tick report-only
broken removal-map remove.cl '(kx + view->along[0][v]) >> 20' '(kx + view->along[0][v] + 4096u) >> 20' sweep/0 tick boundary-layer
broken voxelize voxelize.cl 'e0 < 0 ||' 'e0 <= 0 ||' mesh/ tool column-parity
broken resampling import.cl 'ost_floor_div(i * c, r);' 'ost_floor_div(i > 0 ? i * c - 1 : 0, r);' sweep/0 cubic shift
rm -f "$build/tests/validation/osteon_broken" "$build/tests/validation/broken_embedded.c"
finish
