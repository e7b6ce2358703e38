#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests osteon compare with a plugin, its dump and the reference's dump. Further tests check margins and invalid dumps.
# Covers: REQ-COMPARE
. "${srcdir:-.}/tests/app/lib.sh"
cp "$build/.libs/thesis_f32.so" . || {
    echo "skipped: the plugins are not built, because this build has no shared objects"
    exit 77
}

# The reference must equal its own dump. A plugin with the thesis' arithmetic must differ from the
# reference, and a dump of this plugin must differ in the same way.
run 0 validate --worker ref --dump same --only import/1
run 0 compare same --json
check "comparison of the reference with its own dump: equal" "$(value equal)" true
run 1 compare plugin:./thesis_f32.so --only import/1 --json
has stages.0.different_voxels margins.0.stages.0.bins.21 margins.0.stages.0.max_2_20
# The class and the position must be those that osteon validate reports.
print_difference() { for key in stage class class_hint chunk.0 chunk.1 chunk.2 voxel.0 voxel.1 voxel.2 reference got; do value "$1.0.$key"; done; }
print_difference cases >compared
run 1 validate --backends plugin:./thesis_f32.so --only import/1 --json
print_difference findings >validated
checks=$((checks + 1))
{ cmp -s compared validated && [ "$(wc -l <compared)" -eq 11 ]; } || fail "compare and validate report different classes or positions: $(tr '\n' ' ' <compared), $(tr '\n' ' ' <validated)"
run 1 compare plugin:./thesis_f32.so --only import/1 --json
run 0 validate --worker plugin:./thesis_f32.so --dump theirs --only import/1
run 1 compare theirs --json
print_counts() {
    for stage in 0 1 2; do
        for key in stage voxels decided inherited below_threshold unexplained; do
            value "margins.0.stages.$stage.$key"
        done
    done
}
print_counts >dumped
run 1 compare plugin:./thesis_f32.so --only import/1 --json
print_counts >plugged
checks=$((checks + 1))
cmp -s dumped plugged || fail "the counts with the dump and with the plugin differ: $(tr '\n' ' ' <dumped), $(tr '\n' ' ' <plugged)"

# Compares a user's own files, as validate does, with the plugin and with dumps.
ct_text 20 18 12 0.5 'i * 40 + j - k * 3' >ct.txt
own="--only user --ct ct.txt --cubic 0.7 --tool builtin:peg"
# shellcheck disable=SC2086 # words
{
    run 0 validate --worker ref --dump own $own
    run 0 compare own --ct ct.txt --cubic 0.7 --tool builtin:peg --json
    check "a user's own files, dump of the reference: case, verdict" "$(value cases.0.case) $(value cases.0.verdict)" "user/1 equal"
    run 1 compare plugin:./thesis_f32.so $own --json
    check "a user's own files, plugin: case, verdict, first stage with margins" "$(value cases.0.case) $(value cases.0.verdict) $(value margins.0.stages.0.stage)" "user/1 differs rect"
}
refuse 2 "needs --ct, --tool or --path" compare own --cubic 0.7

# Tests a margin derived by hand. The sample at 2.3 mm on a lattice of 1 mm would leave its voxel,
# which ends at 2.5 mm, if it moved by 0.2 of a voxel. The margin is floor(0.2 * 2^20) = 209715. The
# dump has no sample in voxel (2, 1, 1).
awk 'BEGIN { for (k = 0; k < 5; k++) for (j = 0; j < 6; j++) for (i = 0; i < 7; i++)
    print (i == 2 && j == 1 && k == 1 ? 2.3 : i), j, k, 200 + i + 10 * j + 100 * k }' >off.txt
run 0 validate --worker ref --dump moved --only user --ct off.txt --spacing 1,1,1 --tool builtin:peg
printf '\000\000' | dd of=moved/user-1/rect.raw bs=1 seek=$((2 * (2 + 7 * (1 + 6)))) conv=notrunc 2>/dev/null
run 1 compare moved --ct off.txt --spacing 1,1,1 --tool builtin:peg --json
check "decided voxels and greatest margin in 2^-20 of a voxel" "$(value margins.0.stages.0.decided) $(value margins.0.stages.0.max_2_20)" "1 209715"

# The bundle must contain the margins, and they must follow from its cases.
run 1 validate --only import/1 --backends dump:theirs --out b
grep -q '^import/1,"dump:theirs",rect,1,' b/margins.csv || fail "margins.csv of the bundle has no row for rect: $(cat b/margins.csv)"
grep -q "Margins of differing decisions" b/report.html || fail "the report does not contain the margins"
grep -q "so the difference is not only rounding" b/report.html || fail "the report does not explain the margins"
run 0 verify b

# In ticks and tools, only the rounding at borders may differ.
run 1 compare plugin:./thesis_f32.so --only poses/1 --json
check "second stage that differs" "$(value margins.0.stages.1.stage)" tool
tools=$(value margins.0.stages.1.voxels)

# With --apart, the differences of the tool must be unchanged, and the differences of the chunks
# must not include those of their input.
run 1 compare plugin:./thesis_f32.so --only poses/1 --apart --json
check "--apart: apart" "$(value apart)" true
check "--apart: differing voxels of the tool" "$(value margins.0.stages.1.voxels)" "$tools"
check "--apart: stage of the events" "$(value margins.0.stages.3.stage)" tick
check "--apart: differing voxels of the removal that rounding decides" "$(value margins.0.stages.3.voxels)" "$(value margins.0.stages.3.decided)"
run 1 compare plugin:./thesis_f32.so --only import/1 --apart --json
cp out apart.json
check "--apart: differing voxels of the chunks that are below the threshold" "$(value margins.0.stages.2.voxels)" "$(value margins.0.stages.2.below_threshold)"
refuse 2 "not a dump" compare theirs --apart
run 1 validate --backends plugin:./thesis_f32.so --only import/1 --apart --json
check "validate --apart: apart, evidence" "$(value apart) $(value evidence)" "true false"
check "validate --apart and compare --apart: stage of the first difference" "$(value findings.0.stage)" "$("$json_get" cases.0.stage <apart.json)"
refuse 2 "evidence needs complete runs" validate --apart --out nothing
run 0 validate --backends cpu:threads=1 --only import/1 --apart
grep -q "each stage and tick with the reference's input" out || fail "the first line does not state --apart: $(head -n 1 out)"
refuse 2 "--given needs" validate --given theirs
# Compares a dump that contains only one tick.
run 0 validate --worker ref --dump some --only poses/1
mv some/poses-1/tick-23.raw t23
rm -f some/poses-1/tick-*.raw some/poses-1/final.raw
mv t23 some/poses-1/tick-23.raw
run 0 compare some
grep -q "of .* records are in the dump" out || fail "the output does not state how many records the dump has: $(cat out)"
# A change of one voxel in the last tick must be found and located.
printf '\001\000' | dd of=some/poses-1/tick-23.raw bs=1 seek=2 conv=notrunc 2>/dev/null
run 1 compare some
grep -q "poses/1 on dump:some: tick 23: 1 voxel, the first at (1, 0, 0): 1" out || fail "the changed voxel of tick 23 is not reported: $(cat out)"

# In a dump of all families, a case whose import is refused has a record without a grid.
run 0 validate --worker ref --dump refused --only reach/2
run 2 compare refused
grep -q "no grid of these cases found" err || fail "wrong error for a dump of a refused import: $(cat err)"

# If the threshold is compared by > instead of >=, every voxel at the threshold differs, and the class
# must be reported.
if command -v python3 >/dev/null; then
    run 0 validate --export-cases thresholds --only import/1
    cp -r same greater
    python3 - thresholds/import-1/case.json greater/import-1/chunks.raw >count <<'END'
import array, json, sys
threshold = json.load(open(sys.argv[1]))["ct"]["threshold"]
voxels = array.array("h", open(sys.argv[2], "rb").read())
print(voxels.count(threshold))
open(sys.argv[2], "wb").write(array.array("h", [0 if v == threshold else v for v in voxels]).tobytes())
END
    run 1 compare greater --json
    check "threshold compared by >: class" "$(value cases.0.class)" threshold
    checks=$((checks + 1))
    case $(value cases.0.class_text) in *"the threshold itself, are missing and nothing denser: > in place of >="*) ;; *) fail "threshold compared by >: wrong text of the class: $(value cases.0.class_text)" ;; esac
    check "threshold compared by >: differing voxels, voxels at the threshold, unexplained voxels" "$(value margins.0.stages.0.voxels) $(value margins.0.stages.0.bins.0) $(value margins.0.stages.0.unexplained)" \
        "$(cat count) $(cat count) 0"
    # A single voxel with a different density is another type of mistake.
    printf '\0\0' | dd of=greater/import-1/chunks.raw bs=1 seek=$((2 * $(python3 -c '
import array, sys
v = array.array("h", open(sys.argv[1], "rb").read()); print(v.index(max(v)))' greater/import-1/chunks.raw))) conv=notrunc 2>/dev/null
    run 1 compare greater --json
    check "a dense voxel set to 0: unexplained voxels" "$(value margins.0.stages.0.unexplained)" 1
    checks=$((checks + 1))
    [ "$(value cases.0.class)" != threshold ] || fail "a dense voxel set to 0 has the class threshold"
fi

# refuse_damaged STATUS TEXT COMMAND...: damages a copy of the dump `same` by the command. The dump must be refused in one
# line with the file's name and TEXT
refuse_damaged() {
    status=$1 text=$2
    shift 2
    rm -rf w
    cp -r same w
    "$@"
    refuse "$status" "$text" compare w
}
truncate_file() { head -c 100 same/import-1/rect.raw >w/import-1/rect.raw; }
refuse_damaged 2 "rect.raw: 100 bytes" truncate_file
append_newline() { echo >>w/import-1/cubic.raw; }
refuse_damaged 2 "cubic.raw:" append_newline
add_nrrd() { cp w/import-1/rect.raw w/import-1/rect.nrrd; }
refuse_damaged 2 "also a .raw" add_nrrd
write_text() { rm w/import-1/rect.raw && echo hello >w/import-1/rect.nrrd; }
refuse_damaged 2 "rect.nrrd" write_text
make_folder() { rm w/import-1/rect.raw && mkdir w/import-1/rect.raw; }
refuse_damaged 2 "rect.raw: is a folder; expected a regular file" make_folder
write_head() { echo "$1" >w/dump.json; }
refuse_damaged 2 "dump.json:" write_head '{'
refuse_damaged 2 "osteon_dump must be 1" write_head '{"osteon_dump":2}'
refuse_damaged 2 "tier must be" write_head '{"osteon_dump":1,"tier":"huge"}'
refuse_damaged 2 "seed must be" write_head '{"osteon_dump":1,"seed":1}'
refuse_damaged 2 "arithmetic is 9" write_head '{"osteon_dump":1,"arithmetic":9}'
run 0 validate --worker ref --dump none --only import/1
rm -rf none/import-1
run 2 compare none
rm none/dump.json
refuse 2 "docs/spec/dumps.md" compare none
refuse 2 "nobody" compare nobody
refuse 2 "--trace cannot be combined with --dump" validate --worker ref --trace x --dump y

# Exports inputs for another program.
run 0 validate --export-cases inputs --only poses/1
for file in cases.json poses-1/case.json poses-1/samples.txt poses-1/path.csv poses-1/tool-0.obj poses-1/tool-0.stl; do
    [ -s "inputs/$file" ] || fail "the exported inputs do not contain $file"
done
refuse 2 "inputs: already exists; choose a new folder" validate --export-cases inputs --only poses/1

# A Python program that was written only from docs/spec/arithmetic.md computes the steps before the
# voxels.
if command -v python3 >/dev/null; then
    steps=$source_folder/examples/dump/steps.py
    for family in steps sweep mesh; do
        run 0 validate --export-cases "$family-cases" --only "$family/"
        python3 "$steps" "$family-cases" "$family-steps" || fail "steps.py refuses the cases of $family"
        run 0 compare "$family-steps" --json
        check "steps.py, family $family: equal" "$(value equal)" true
    done
    # The reference also dumps these cases. Both dumps must contain the same records of steps with the same content.
    run 0 validate --worker ref --dump steps-ref --only steps/
    checks=$((checks + 1))
    python3 - steps-ref steps-steps <<'END' || fail "the files of steps.py and of the reference differ"
import glob, json, os, sys
names = [{os.path.relpath(n, top) for n in glob.glob(top + "/*/*.json")} for top in sys.argv[1:]]
assert names[0] == names[1] and len(names[0]) > 100, names
assert all(json.load(open(sys.argv[1] + "/" + n)) == json.load(open(sys.argv[2] + "/" + n)) for n in names[0])
END
    # A wrong integer must be found and named together with its pose. A bundle must state who
    # computed the steps.
    change_steps() {
        rm -rf wrong
        cp -r steps-steps wrong
        python3 - "wrong/steps-0/$1.json" "$2" <<'END'
import json, sys
o = json.load(open(sys.argv[1]))
exec(sys.argv[2])
json.dump(o, open(sys.argv[1], "w"))
END
    }
    change_steps steps-1 'o["poses"][0]["step"][1][2] += 1'
    run 1 compare wrong
    grep -q "steps/0 on dump:wrong: steps 1: step yz (pose 1) is" out || fail "the wrong step is not reported: $(cat out)"
    change_steps steps-1 'o["poses"][0]["origin"][2] = str(int(o["poses"][0]["origin"][2]) + (1 << 70))'
    run 1 compare wrong
    grep -q "steps 1: origin z, high (pose 1) is" out || fail "the wrong origin is not reported: $(cat out)"
    change_steps steps-1 'o["poses"].append(o["poses"][0])'
    run 1 compare wrong
    grep -q "steps 1: poses is" out || fail "the additional pose is not reported: $(cat out)"
    change_steps snap-0 'o["vertices"][3][1] += 1'
    run 1 compare wrong
    grep -q "snap 0: snapped vertex 3 is" out || fail "the wrong vertex is not reported: $(cat out)"
    run 0 validate --backends dump:steps-steps --only steps/ --out b-steps
    grep -q "computed by the backend itself and compared: [0-9]* records" out || fail "the output does not state who computed the steps: $(cat out)"
    checks=$((checks + 1))
    ! grep -q "received sweep" b-steps/report.html || fail "the report says that the steps were supplied"
    run 0 verify b-steps
    # An invalid file must be reported in one line with its name and the member.
    refuse_changed() {
        change_steps "$1" "$2"
        refuse 2 "wrong/steps-0/$1.json: \"$3\" must be" compare wrong
    }
    refuse_changed steps-1 'o["refused"] = 0' refused
    refuse_changed steps-1 'del o["poses"]' poses
    refuse_changed steps-1 'o["poses"] *= 5000' poses
    refuse_changed steps-1 'o["t_ns"] = 0.5' t_ns
    refuse_changed steps-1 'o["pose"].pop()' pose
    refuse_changed steps-1 'o["poses"][0]["divisor"] = 7' divisor
    refuse_changed steps-1 'o["poses"][0]["divisor"] = "-"' divisor
    refuse_changed steps-1 'o["poses"][0]["divisor"] = "1" * 39' divisor
    refuse_changed steps-1 'o["poses"][0]["column"][1][1] = "1x"' column
    refuse_changed steps-1 'o["poses"][0]["base"].pop()' base
    refuse_changed snap-0 'o["meshes"] = []' meshes
    refuse_changed snap-0 'o["meshes"][0]["sha256"] = "00"' sha256
    refuse_changed snap-0 'o["vertices"][0] = [1, 2, -3]' vertices
    refuse_changed snap-0 'o["vertices"] = 3' vertices
    rm -rf wrong
    cp -r steps-steps wrong
    echo '{"refused":' >wrong/steps-0/steps-1.json
    refuse 2 "wrong/steps-0/steps-1.json:" compare wrong
fi
finish
