# SPDX-License-Identifier: Apache-2.0
# Definitions for the scripts that call `walk`. Each script includes this file after
# tests/app/lib.sh.

skip() {
    echo "skipped: $*"
    exit 77
}
needs ASSIMP NIFTI PNG
library=$build/.libs/fault_inject.so
walk=$build/tests/faults/walk
[ -r "$library" ] || skip "built without shared libraries"
[ -z "${OST_SAN_CFLAGS:-}" ] || skip "the run-time library of a sanitizer must be loaded first"
seed=${OST_TEST_SEED:-$(od -An -N4 -tu4 /dev/urandom | tr -d ' ')}
echo "# seed $seed"
excepted=libassimp:_dri:libEGL:libGL:libglapi:libepoxy:libgallium:libLLVM:libgcc_s:libcrypto:libexpat:libomp:libgomp
# OpenCL is disabled in these tests, because its libraries are written in C++.
export OCL_ICD_VENDORS="$scratch/none" XDG_CACHE_HOME="$scratch/cache" OST_FAIL_EXCEPT=$excepted
mkdir "$OCL_ICD_VENDORS" "$XDG_CACHE_HOME"

# sample N: sets the number of faults for each of the following commands; with OST_TEST_LONG=1 all
# faults are tested
sample() {
    runs=$1
    [ -z "${OST_TEST_LONG:-}" ] || runs=0
}

# walk_over [OPTION...] -- ARGUMENT...: runs `walk` on one command of osteon
walk_over() {
    options=
    while [ "$1" != -- ]; do
        options="$options $1"
        shift
    done
    shift
    case "$*" in *"${OST_TEST_ONLY:-}"*) ;; *) return ;; esac
    checks=$((checks + 1))
    echo "# osteon $*$options"
    "$walk" --runs $runs --seed "$seed" $options "$library" "$osteon" "$@" || fail "a fault was not handled: osteon $*$options"
}

# make_inputs: makes a CT, a bone, tools and a session in folder $in
make_inputs() {
    in=$scratch/in
    mkdir "$in"
    run 0 phantom glenoid --spacing 1.5 --out in/ct.nrrd
    run 0 phantom glenoid --spacing 1.5 --out in/ct.nii.gz
    run 0 phantom glenoid --spacing 1.5 --out in/ct.txt
    run 0 import in/ct.nrrd --out in/bone.nrrd
    run 0 tool peg --out in/peg.ply
    run 0 voxelize builtin:reamer --voxel 2 --out in/reamer.nrrd
    run 0 ream --bone "$in/bone.nrrd" --tool "$in/reamer.nrrd" --path builtin:glenoid-ream --rate 100 --out in/reamed.nrrd --record in/today.session
    run 0 info in/today.session
}
