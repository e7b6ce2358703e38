#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the command without a usable OpenCL device: without a driver, with a broken driver, or built
# without OpenCL. All other functions must work, and the reason must be reported.
# Covers: REQ-OPTIONAL
. "${srcdir:-.}/tests/app/lib.sh"

# reason TEXT: checks in the file `out` that the backend cl is not available and that the reason contains TEXT
reason() {
    i=0
    while name=$(value "backends.$i.name") && [ -n "$name" ]; do
        if [ "$name" = '"cl"' ] || [ "$name" = cl ]; then
            available=$(value "backends.$i.available")
            check "availability of backend cl" "$available" false
            checks=$((checks + 1))
            value "backends.$i.reason" | grep -q -- "$1" || fail "the reason '$(value "backends.$i.reason")' does not contain '$1'"
            return
        fi
        i=$((i + 1))
    done
    fail "no backend cl in: $(head -c 300 out)"
}

built=yes
meshes=yes
grep -q '^#define HAVE_ASSIMP 1' "$build/config.h" || meshes=no
grep -q '^#define HAVE_OPENCL 1' "$build/config.h" || built=no
mkdir empty broken
echo libno-such-driver.so.9 >broken/some.icd

for folder in empty broken; do
    export OCL_ICD_VENDORS="$scratch/$folder"
    run 0 devices --json
    case $built$folder in
    no*) reason "built without OpenCL" ;;
    yesempty) reason "found no driver in" ;;
    yesbroken) reason "some.icd cannot be loaded: libno-such-driver.so.9" ;;
    esac
    run 0 tool peg --out peg.stl
    [ $meshes = yes ] || continue
    run 0 voxelize peg.stl --voxel 1 --out peg.nrrd
    refuse 3 "backend 'cl' is not available" voxelize peg.stl --voxel 1 --out other.nrrd --backend cl
    [ ! -e other.nrrd ] || fail "the refused command wrote other.nrrd"
done
finish
