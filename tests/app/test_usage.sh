#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the messages of the command: help, man pages, wrong usage, and standard streams that are
# closed or full.
# Covers: REQ-CLI-STATUS, REQ-CLI-HELP
. "${srcdir:-.}/tests/app/lib.sh"

# Every verb must have a help text with usage and an example, within 90 columns, and a man page with
# the same options.
run 0 --help
cp out help_all
run 0 --version
grep -q '^osteon [0-9.]*, arithmetic version [0-9]*$' out || fail "the output of --version is wrong: $(cat out)"
verbs=$(sed -n '/^verbs$/,/^$/s/^  \([a-z]*\) .*/\1/p' help_all)
checks=$((checks + 1))
for page in "$source_folder"/man/osteon-*.1; do
    verb=${page##*/osteon-}
    echo "$verbs" | grep -qx "${verb%.1}" || fail "osteon --help does not list the verb of $page"
done
for verb in $verbs; do
    run 0 "$verb" --help
    check "$verb --help: usage" "$(grep -c "^usage: osteon $verb " out)" 1
    check "$verb --help: example" "$(grep -c '^example$' out)" 1
    check "$verb --help: lines over 90 columns" "$(awk 'length > 90' out | wc -l | tr -d ' ')" 0
    check "$verb --help: bytes on standard error" "$(wc -c <err | tr -d ' ')" 0
    page=$source_folder/man/osteon-$verb.1
    [ -f "$page" ] || fail "no man page $page"
    grep -o '^  --[a-z-]*' out | tr -d ' ' | grep -vxE -- '--(backend|threads|json|quiet|help)' | sort >options_help
    sed -n 's/^\.BI* \\-\\-\([a-z\\-]*\).*/--\1/p' "$page" | tr -d '\\' | grep -vx -- --json | sort >options_man
    cmp -s options_help options_man || fail "$verb: help and man page differ in options: $(diff options_help options_man | tr '\n' ' ')"
    # The option --help must have priority over errors in other options.
    run 0 "$verb" --no-such-option --help
done

# docs/reference/command.md must contain every verb and every environment variable that the program reads.
page=$source_folder/docs/reference/command.md
check "verbs of command.md" "$(sed -n 's/^| `\([a-z]*\)` .*osteon-.*/\1/p' "$page" | sort | tr '\n' ' ')" "$(echo "$verbs" | sort | tr '\n' ' ')"
for variable in $(cd "$source_folder" && grep -rhoE '(getenv|is_set|setenv)\("[A-Z_]+"|vendor_library library = \{"[A-Z_]+"' \
    src bench validation reproduction --include='*.c' | sed 's/"$//; s/.*"//' | sort -u); do
    checks=$((checks + 1))
    grep -q "\`$variable\`" "$page" || fail "$page does not describe the environment variable $variable"
done

# After wrong usage, the status must be 2, there must be one line with a suggestion, and nothing on
# standard output.
refuse 2 'no verb given'
refuse 2 'did you mean ream?' reem --bone x
refuse 2 'did you mean voxelize?' voxelise
refuse 2 'not a verb' operate
refuse 2 'not a verb' ''
refuse 2 'did you mean --version?' --versoin
refuse 2 'no CT given' import
refuse 2 "unexpected argument 'b'" import a b
refuse 2 'empty argument: no CT given' import ''
refuse 2 'empty argument: no second grid given' diff a ''
refuse 2 '--out needs a value' import a --out
refuse 2 '--out needs a value' import a --out --json
refuse 2 '--out FILE is missing' import a
refuse 2 'did you mean --spacing?' import a --spcing 3
refuse 2 "--spacing '0'" import a --out b.nrrd --spacing 0
refuse 2 "--spacing '1,2'" import a --out b.nrrd --spacing 1,2
refuse 2 "--spacing 'nan'" import a --out b.nrrd --spacing nan
refuse 2 'expected 16, 32 or 64' import a --out b.nrrd --chunk 17
refuse 2 'from 1 to 32767' import a --out b.nrrd --threshold 0
refuse 2 'expected a whole number' import a --out b.nrrd --threshold 120.5
refuse 2 'expected from:to' import a --out b.nrrd --crop 0:1,2:3
refuse 2 'the range from 5 to 5 is empty' import builtin:glenoid --out b.nrrd --crop 5:5,0:9,0:9
refuse 2 '.nrrd, .nii, .nii.gz or .txt' import a --out b.stl
refuse 2 'No such file or directory' import a --out no/such/folder/b.nrrd
refuse 2 'File name too long' import a --out "$(printf 'x%.0s' $(seq 300)).nrrd"
refuse 2 'nothing.txt' import nothing.txt --out b.nrrd
refuse 2 '--json takes no value' import a --out b.nrrd --json=1
refuse 2 'given twice' import a --out b.nrrd --out c.nrrd
refuse 2 'a direction cannot be zero' ream --bone a --out b.nrrd --axis 0,0,0
for axis in 1e300,0,0 0,1e-300,0; do
	refuse 2 "'$axis': expected a direction whose greatest component is from 1e-9 to 1e9" ream --bone a --out b.nrrd --axis "$axis"
done
refuse 2 '--tool TOOL is missing' ream --bone a --out b.nrrd --path p
refuse 2 '--path PATH is missing' ream --bone a --out b.nrrd --tool t
refuse 2 '3 paths and 2 tools' ream --bone a --out b.nrrd --tool t --tool t --path p --path p --path p
refuse 2 '--rate 0' ream --bone builtin:glenoid --out b.nrrd --tool builtin:peg --path builtin:peg-hole --rate 0
refuse 2 's: the name must end in .session' ream --bone a --out b.nrrd --tool t --path p --record s
refuse 2 'did you mean scapula?' phantom scapla --out b.nrrd
refuse 2 'did you mean reamer?' tool remer --out b.stl
refuse 2 'builtin:nothing' voxelize builtin:nothing --out b.nrrd
refuse 2 'builtin:peg-hole' ream --bone builtin:glenoid --out b.nrrd --tool builtin:peg --path builtin:peghole
refuse 2 'no second grid given' diff a
refuse 2 'cannot be combined' export a --out b.png --view lateral --slices
refuse 2 'need a .png file' export a --out b.nrrd --view lateral
refuse 2 'backend' import builtin:glenoid --out b.nrrd --backend nonsense

# Tests the options of backends. Each message must state the expected values.
peg="voxelize builtin:peg --voxel 1 --out b.nrrd"
refuse 2 "unknown backend 'cpux'; expected cpu, ref" $peg --backend cpux
refuse 2 "unknown instruction set 'sse9'; expected auto, scalar" $peg --backend cpu:isa=sse9
refuse 2 'isa= needs the name of an instruction set' $peg --backend cpu:isa=
refuse 2 'isa= is given twice' $peg --backend cpu:isa=scalar,isa=scalar
for threads in 0 -1 +2 ' 2' 1025 99999999999999999999 2x ''; do
    refuse 2 "threads=$threads; expected a number from 1 to 1024" $peg --backend "cpu:threads=$threads"
done
for grain in 0 -1 +2 2x '' 10000000000; do
    refuse 2 "grain=$grain; expected a number from 1 to 9999999999" $peg --backend "cpu:grain=$grain"
    refuse 2 "order=$grain; expected a number from 1 to 9999999999" $peg --backend "cpu:order=$grain"
done
refuse 2 'must be from 1 to 1024' $peg --threads 1025
refuse 2 'pass one of them' $peg --backend cpu:threads=2 --threads 3
refuse 2 'voxelizer=rays; expected auto, triangles or embree' $peg --backend cpu:voxelizer=rays
refuse 2 "unknown option 'color=red'; expected isa=NAME, threads=N, grain=N, order=N or voxelizer=NAME" $peg --backend cpu:color=red
refuse 2 "backend ref: unknown option 'threads'; it has no options" $peg --backend ref:threads=2
OSTEON_ISA=sse9
export OSTEON_ISA
refuse 2 "OSTEON_ISA: unknown instruction set 'sse9'" $peg
run 0 devices
grep -q "^  cpu *no *OSTEON_ISA" out || fail "osteon devices does not report the invalid OSTEON_ISA: $(head -c 300 out)"
unset OSTEON_ISA
"$osteon" devices | grep -q '^  embree *yes' || refuse 3 'libembree-dev' $peg --backend cpu:voxelizer=embree

# The output of osteon devices must agree with the backend that a verb opens. An instruction set
# that is not in this output must be refused.
value_of() { # value_of KEY
    "$osteon" devices --json | "$json_get" "backends.0.$1"
}
check "name of the first backend" "$(value_of name)" cpu
check "instruction set with OSTEON_ISA=scalar" "$(OSTEON_ISA=scalar value_of isa)" scalar
check "threads with OMP_NUM_THREADS=3" "$(OMP_NUM_THREADS=3 value_of threads)" "$("$osteon" devices --threads 3 --json | "$json_get" backends.0.threads)"
for isa in scalar avx2 avx512 avx512vbmi neon; do
    if "$osteon" devices | grep -q "works with.*there are.*\<$isa\>"; then
        check "instruction set with OSTEON_ISA=$isa" "$(OSTEON_ISA=$isa value_of isa)" $isa
    else
        refuse 3 "instruction set '$isa' is not available here" $peg --backend cpu:isa=$isa
    fi
done
check "files that refused commands left" "$(ls | grep -v '^\(out\|err\|help_all\|options_\)' | tr '\n' ' ')" ""

# If a library terminates the process by exit(1), as OpenMP does without memory for a thread's stack,
# there must be no verdict.
ct_text 8 8 8 1 'i * 100' >threads.txt
OMP_STACKSIZE=1000000G "$osteon" import threads.txt --threads 2 --out threads.nrrd >out 2>err
status=$?
case $status in
0 | 2) ;;
*) fail "import without memory for the threads: status $status: $(head -c 300 err)" ;;
esac
[ $status -ne 2 ] || [ ! -e threads.nrrd ] || fail "import without memory for the threads left an output"

# A closed or full standard stream must be an error and must never be replaced by another file.
"$osteon" devices >/dev/full 2>err
check "exit status of devices > /dev/full" $? 2
grep -q 'standard output' err || fail "the error of devices > /dev/full does not name standard output: $(cat err)"
"$osteon" devices >&- 2>err
check "exit status of devices with standard output closed" $? 2
"$osteon" devices <&- >out 2>err
check "exit status of devices with standard input closed" $? 0
"$osteon" tool peg --out closed.stl >&- 2>/dev/null <&-
"$osteon" tool peg --out open.stl >/dev/null
cmp -s closed.stl open.stl || fail "the file written with standard output closed differs"
(
    trap '' PIPE
    "$osteon" ream --help
) 2>err | head -1 >/dev/null
check "error after writing to a closed pipe" "$(cat err)" ""
finish
