#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests a user's own files as cases of a campaign. The cases run on every backend, give equal
# results with and without shards, and can be computed again by anyone who has the files. The
# bundle must not contain the names of the files. Invalid files must be refused.
# Covers: REQ-USER-FILES
. "${srcdir:-.}/tests/app/lib.sh"

one='cpu:isa=scalar,threads=1'
# These names must occur nowhere else in a bundle.
ct=Doe-Jane-1961.txt mesh=prototype-q17.stl path=monday-session.csv
ct_text 22 20 14 0.5 'i * 40 - k * 3 - 100' >$ct
"$osteon" phantom glenoid --scale 0.25 --spacing 1.6,1.6,2 --out second.nrrd >/dev/null || fail "osteon phantom failed"
"$osteon" tool peg --out $mesh >/dev/null || fail "osteon tool failed"
awk 'BEGIN { for (t = 0; t < 40; t++) printf "%.3f,%.3f,5,%.3f,%.9f,0,0,%.9f\n", t * 0.003, 5 + t * 0.02, 6 - t * 0.1, cos(t / 900), sin(t / 900) }' >$path

run 0 validate --only user --backends "$one;cpu:isa=scalar,threads=2" --ct $ct --ct second.nrrd --tool $mesh --tool builtin:burr --path $path --cubic 0.4 --voxel=0.6 --out b --json
check "campaign with the user's files: equal" "$(value equal)" true
check "number of cases" "$(value cases)" 2
check "numbers of records per stage of the first case" "$(sed -n 1p b/cases.jsonl | grep -o '"stage":"[a-z]*"' | sort | uniq -c | tr -s ' \n' ' ')" \
    ' 1 "stage":"chunks" 1 "stage":"collide" 1 "stage":"cubic" 1 "stage":"final" 1 "stage":"rect" 1 "stage":"resample" 4 "stage":"sample" 2 "stage":"snap" 40 "stage":"steps" 40 "stage":"tick" 2 "stage":"tool" 1 "stage":"upload" '
check "files of the bundle that contain the names of the user's files" "$(grep -rlF -e Doe-Jane -e prototype-q17 -e monday-session -e second.nrrd -e "$(pwd)" b)" ""
for file in $ct second.nrrd $mesh $path; do
    checks=$((checks + 1))
    grep -q "\"$(sha256sum <$file | cut -d' ' -f1)\",$(wc -c <$file | tr -d ' ')," b/inputs.csv || fail "$file is not in inputs.csv"
done
# The bone of the CT must equal the bone that osteon import makes.
"$osteon" import $ct --cubic 0.4 --out bone.nrrd --json >out || fail "osteon import failed"
for stage in 0 1 2 3; do
    checks=$((checks + 1))
    grep -q "\"$(value "stages.$stage.name")\": \"$(value "stages.$stage.sha256")\"" b/protocol.json || fail "stage $(value "stages.$stage.name") of import is not in protocol.json"
done

# verify must compute the results again from the user's files, given in any order. Other files must
# be refused.
run 0 verify b
run 0 verify b --rerun --path $path --tool $mesh --ct second.nrrd --ct $ct --json
check "verify --rerun: rerun" "$(value rerun)" true
refuse 2 "--rerun needs these files, 2 with --ct, 1 with --tool, 1 with --path" verify b --rerun
refuse 2 "need --rerun" verify b --ct $ct
sed '30s/[0-9]$/7/; 30s/$/1/' $ct >changed.txt
refuse 2 "none of the files given with --ct is the bundle's" verify b --rerun --path $path --tool $mesh --ct second.nrrd --ct changed.txt
refuse 2 "No such file" verify b --rerun --path nowhere --tool $mesh --ct second.nrrd --ct $ct

# A second run and a run in shards must give the same results, with the protocol's options in any order.
run 0 validate --voxel 0.6 --only user --backends "$one;cpu:isa=scalar,threads=2" --cubic=0.4 --path $path --tool $mesh --ct $ct --tool builtin:burr --ct second.nrrd --out again --quiet
mkdir shards
for i in 1 2; do
    run 0 validate --only user --backends "$one;cpu:isa=scalar,threads=2" --ct $ct --ct second.nrrd --tool $mesh --tool builtin:burr --path $path --cubic 0.4 --voxel=0.6 --shard $i/2 \
        --out shards/$i --quiet
done
run 0 validate --merge shards --out whole
grep -q '^EQUAL: 2 cases from 2 shards$' out || fail "wrong first line of --merge: $(head -n 1 out)"
for other in again whole; do
    check "results_root of $other" "$("$json_get" results_root <$other/manifest.json)" "$("$json_get" results_root <b/manifest.json)"
    check "inputs of $other" "$(cmp b/cases.jsonl $other/cases.jsonl && cmp b/protocol.json $other/protocol.json && echo same)" same
done
run 0 verify whole --rerun --ct $ct --ct second.nrrd --tool $mesh --path $path
rm -r shards/2
run 0 validate --only user --backends "$one;cpu:isa=scalar,threads=2" --ct $ct --ct second.nrrd --tool $mesh --tool builtin:burr --path $path --cubic 0.5 --voxel=0.6 --shard 2/2 --out shards/2 --quiet
refuse 2 "another campaign" validate --merge shards --out mixed
mkdir alone
run 0 validate --only user --backends "$one" --tool $mesh --shard 1/1 --out alone/1 --quiet
run 0 validate --merge alone --out single
check "first line of --merge with one shard" "$(head -n 1 out)" "EQUAL: 1 case from 1 shard"

# A reduced case of a user's files needs these files; without them it must be refused.
echo '{"osteon_case": 1, "id": "user/1", "tier": "smoke", "seed": "1", "keep": {"crop": [[2, 0, 0], [20, 18, 12]], "ticks": [[0, 9]], "no_tools": [1]}}' >part.json
run 0 validate --case part.json --backends "$one" --ct $ct --tool $mesh --tool builtin:burr --path $path --json
check "reduced case: equal" "$(value equal)" true
refuse 2 "give them with --ct, --tool and --path" validate --case part.json --backends "$one"

# A backend differs in the user's case. The difference must be located, reduced, and reproduced
# from the case and the files.
if cp "$build/.libs/thesis_f32.so" . 2>/dev/null; then
    run 1 validate --only user/1 --backends "$one;plugin:./thesis_f32.so" --ct $ct --tool $mesh --out differs --json
    small=$(value findings.0.reproduce)
    check "differing backend: backend, small case" "$(value findings.0.backend) $small" "plugin:./thesis_f32.so cases/user-1-backend-2.json"
    stage=$(value findings.0.stage)
    run 1 validate --case "differs/$small" --backends plugin:./thesis_f32.so --ct $ct --tool $mesh --json
    check "stage of the small case" "$(value findings.0.stage)" "$stage"
    run 0 verify differs --rerun --ct $ct --tool $mesh
else
    echo "not tested, because this build has no shared objects: a backend that differs"
fi

# check_refused TEXT ARGUMENT...: checks that the arguments are refused, before anything runs, in a line
# that contains TEXT
check_refused() {
    text=$1
    shift
    refuse 2 "$text" validate --only user --backends "$one" --out none "$@"
    checks=$((checks + 1))
    [ ! -e none ] || fail "$*: a refused campaign left a bundle"
}
head -c 3000 /dev/urandom >noise
printf 'solid\n' >empty.stl
printf '0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n' >twice.csv
awk 'NR == 9 { $1 = "nan" } { print }' $ct >nan.txt
check_refused "not a regular file" --ct /dev/zero
check_refused "No such file" --ct nowhere.nii.gz
check_refused "noise" --ct noise
check_refused "nan.txt:9" --ct nan.txt
check_refused "is a mesh" --ct $mesh
check_refused "empty.stl" --tool empty.stl
check_refused "noise" --tool noise
check_refused "pass its mesh" --tool second.nrrd
check_refused "twice.csv:2" --ct $ct --tool $mesh --path twice.csv
check_refused "needs --tool and --ct" --tool $mesh --path $path
check_refused "the glenoid's position and axis are not set" --ct $ct --tool $mesh --path builtin:peg-hole
check_refused "needs --ct, --tool or --path" --cubic 0.5
check_refused "expected at most 4" --tool $mesh --tool $mesh --tool $mesh --tool $mesh --tool $mesh
check_refused "no case of tier smoke has a name that starts with 'user'"
check_refused "at most 1024" --ct $ct --tool $mesh --path $path --voxel 0.02
TMPDIR=$scratch/no-such-folder
export TMPDIR
check_refused "no-such-folder" --ct $ct
unset TMPDIR
refuse 2 "cannot be combined with --ct, --tool or --path" validate --merge shards --out mixed --ct $ct
refuse 2 "for workers" validate --worker ref --trace t --user 4</dev/null
finish
