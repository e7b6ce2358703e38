#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests that osteon validate runs both kernel sets on an OpenCL device with results equal to the
# reference, and that it reports for each set which kernels and paths no case entered.
# Covers: REQ-CL-SETS, REQ-VAL-PATHS
. "${srcdir:-.}/tests/app/lib.sh"

skip() {
    echo "skipped: $*"
    exit 77
}
grep -q '^#define HAVE_OPENCL 1' "$build/config.h" || skip "built without OpenCL"
mkdir -p "$build/tests/cl/cache"
export XDG_CACHE_HOME="$build/tests/cl/cache"
"$osteon" devices >devices 2>/dev/null
device=$(sed -n 's/^  \(cl:platform=[0-9]*,device=[0-9]*\)  *yes.*/\1/p' devices | head -n 1)
[ -n "$device" ] || skip "no OpenCL device can be used here"

# A device that ends long loops cannot run the kernel set for CPUs. In this case, only the other set is compared.
sets=gpu
"$osteon" voxelize builtin:peg --backend "$device,kernels=cpu" --voxel 1 --out peg.nrrd >/dev/null 2>why && sets="cpu gpu"
[ "$sets" != gpu ] || grep -q 'too early for kernels=cpu' why || fail "kernels=cpu: $(cat why)"

specs=
for set in $sets; do specs="$specs;$device,kernels=$set"; done
run 0 validate --backends "${specs#;}" --only import/1 --out bundle --json && mv out json
run 0 validate --backends "${specs#;}" --only import/1
python=$(command -v python3) || skip "no python3"
"$python" - "$device" $sets >problems <<'END'
import json, sys
device, sets = sys.argv[1], sys.argv[2:]
reported = {b["name"]: b for b in json.load(open("json"))["backends"]}
stored = json.load(open("bundle/environment.json"))["paths"]
shown = open("out").read()
own = {"cpu": ("kernel ost_chunk_scan_layers", "kernel ost_remove_blocks"), "gpu": ("kernel ost_chunk_scan", "kernel ost_remove")}
for name in sets:
    b = reported["%s,kernels=%s" % (device, name)]
    other = "gpu" if name == "cpu" else "cpu"
    both = set(b["entered"]) | set(b["not_entered"])
    if b["equal"] != 1: print("the number of equal cases is not 1:", b)
    if own[name][0] not in b["entered"]:
        print(name, "does not list", own[name][0], "as entered, although an import runs it:", b["entered"])
    if own[name][1] not in b["not_entered"]:
        print(name, "does not list", own[name][1], "as not entered, although an import does not run it:", b["not_entered"])
    if both & set(own[other]): print(name, "lists a kernel of the other set")
    if stored[b["name"]] != {"entered": b["entered"], "not_entered": b["not_entered"]}:
        print("the paths in the bundle differ from the output of --json for", name)
    if "not entered: " + ", ".join(b["not_entered"])[:200] not in shown:
        print("the output does not list the paths that were not entered for", name)
END
check "sets and paths" "$(cat problems)" ""
finish
