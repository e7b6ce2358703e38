#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests that no character that controls a terminal is printed. Every verb gets a file name and a
# note with escape sequences, a newline, C1 controls, invalid UTF-8 and characters that change the
# text direction. The test checks the verb's output, warnings, errors and JSON.
# Covers: REQ-TERMINAL
. "${srcdir:-.}/tests/app/lib.sh"
needs ASSIMP PNG

# The name contains ESC [ 3 1 m, BEL, a newline, CSI as UTF-8 and as a byte, a right-to-left override, an isolate,
# and a line separator.
evil=$(printf 'a\033[31mb\007c\nQZX\302\233e\2339f\342\200\256g\342\201\246h\342\200\250i')
# Umlauts and letters of other scripts must not be changed.
kind=$(printf 'Schl\303\274ssel-\351\252\250')

# check_output WHAT: checks that the files out and err contain no such character except newlines at the
# ends of lines
check_output() {
    checks=$((checks + 1))
    for stream in out err; do
        LC_ALL=C grep -n -q "$(printf '[\001-\010\013-\037\177]')" $stream && fail "$1: a control character on $stream"
        LC_ALL=C grep -q "$(printf '\302[\200-\237]')" $stream && fail "$1: a C1 character on $stream"
        LC_ALL=C grep -q "$(printf '\342\200[\216\217\250-\256]')" $stream && fail "$1: a direction or line character on $stream"
        LC_ALL=C grep -q "$(printf '\342\201[\246-\251]')" $stream && fail "$1: an isolate on $stream"
        LC_ALL=C grep -q "$(printf 'e\2339')" $stream && fail "$1: a byte that is not UTF-8 on $stream"
        LC_ALL=C grep -q '^QZX' $stream && fail "$1: the newline of the file name on $stream"
    done
}
# run_any ARGUMENT...: runs osteon with any exit status and checks its output
run_any() {
    "$osteon" "$@" >out 2>err </dev/null
    status=$?
    [ $status -le 3 ] || fail "osteon $1: status $status, expected 0 to 3"
    check_output "osteon $1 ${2:-}"
}

run 0 phantom glenoid --spacing 2 --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 tool peg --out peg.ply
run 0 voxelize peg.ply --voxel 1 --out peg.nrrd
run 0 ream --bone bone.nrrd --tool peg.nrrd --path builtin:peg-hole --out reamed.nrrd --record it.session
run 0 validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out bundle --quiet
for suffix in nrrd txt session ply csv params; do
    case $suffix in nrrd) cp bone.nrrd "$evil.nrrd" ;; session) cp it.session "$evil.session" ;; ply) cp peg.ply "$evil.ply" ;; esac
done
printf '0 0 0 500\n1 0 0 %s\n' "$(printf 'oo\033[31mps\302\233')" >"$evil.txt"
printf 't_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,\033[2J,0,0,1,0,0,0\n' >"$evil.csv"
printf 'wall_stiffness\033[31m: 7\n' >"$evil.params"
cp -r bundle "$evil.bundle"
echo more >"$evil.bundle/$evil"

# Tests every verb with the name as an existing file, a missing file and an output, with and without
# --json.
for json in '' --json; do
    for verb in phantom tool import voxelize ream replay sim diff render export info validate compare verify bench reproduce devices bridge; do
        # The name is passed as an operand, an option, a value and a verb's name.
        run_any $verb "$evil" $json
        run_any $verb "--$evil" $json
        [ -n "$json" ] || run_any $verb --threads "$evil"
    done
    run_any import ct.nrrd --backend "$evil" --out o.nrrd $json
    run_any import ct.nrrd --backend "plugin:$evil" --out o.nrrd $json
    run_any export ct.nrrd --out "$evil" $json
    run_any phantom glenoid --spacing 2 --out "$evil.nrrd" $json
    run_any tool peg --out "$evil.ply" $json
    run_any import "$evil.nrrd" --out "$evil.o.nrrd" $json
    run_any import "$evil.txt" --out "$evil.o.nrrd" $json
    run_any voxelize "$evil.ply" --voxel 1 --out "$evil.o.nrrd" $json
    run_any ream --bone "$evil.nrrd" --tool "$evil.ply" --path builtin:peg-hole --out "$evil.o.nrrd" $json
    run_any ream --bone bone.nrrd --tool peg.nrrd --path "$evil.csv" --out o.nrrd $json
    run_any replay "$evil.session" --verify $json
    run_any sim --headless --no-clock --no-pin --seconds 0.01 --device null --bone "$evil.nrrd" --tool peg.nrrd --out "$evil.o.nrrd" $json
    run_any sim --headless --bone bone.nrrd --device "motion:$evil.csv" $json
    run_any sim --headless --bone bone.nrrd --device "$evil" $json
    run_any sim --headless --bone bone.nrrd --device null --force-params "$evil.params" $json
    run_any diff "$evil.nrrd" reamed.nrrd $json
    run_any diff "$evil.bundle" bundle $json
    run_any render "$evil.nrrd" --size 32x24 --out "$evil.png" $json
    run_any export "$evil.nrrd" --out "$evil.o.txt" $json
    for file in nrrd txt session ply csv; do run_any info "$evil.$file" $json; done
    [ -n "$json" ] || run_any validate --only import/0 --backends 'cpu:isa=scalar,threads=1' --out "$evil.new"
    run_any validate --case "$evil.txt" --backends cpu $json
    run_any validate --merge "$evil.bundle" --out "$evil.new" $json
    run_any verify "$evil.bundle" $json
    run_any compare "$evil.bundle" $json
    run_any bench --suite tick --filter "$evil" $json
    run_any bridge --device "$evil" $json
done
run_any "$evil"
run_any help "$evil"

# Tests a fact in the header of a file, which the program prints.
{ printf '# osteon %s: 1\n' "$(printf 'no\033]0;title\007te\302\233')"; printf '# note: \033[31mred\n'; cat <<END; } >noted.txt
0 0 0 500
1 0 0 500
0 1 0 500
1 1 0 500
0 0 1 500
1 0 1 500
0 1 1 500
1 1 1 500
END
run_any info noted.txt
run_any import noted.txt --out noted.nrrd
sed "s/^type:/# $(printf 'k\033[31my')\ntype:/; s/^endian: little/&\nk\\\\ney:=$(printf 'v\033[31mal\302\233')/" ct.nrrd >noted2.nrrd 2>/dev/null
run_any info noted2.nrrd
run_any info noted2.nrrd --json

# JSON must contain the unchanged name in escaped form.
run 0 info "$evil.nrrd" --json
grep -qiF 'a\u001b[31mb\u0007c\nQZX' out || grep -q 'not UTF-8' out || fail "JSON does not contain the escaped file name: $(head -c 300 out)"
mv "$evil.nrrd" "$(printf 'a\033b\302\233c\342\200\256d').nrrd"
run 0 info "$(printf 'a\033b\302\233c\342\200\256d').nrrd" --json
checks=$((checks + 1))
grep -qiF 'a\u001bb\u009bc\u202ed.nrrd' out || fail "JSON does not contain the escaped file name: $(head -c 300 out)"

# Harmless characters must be printed.
mv bone.nrrd "$kind.nrrd"
run 0 info "$kind.nrrd"
checks=$((checks + 1))
grep -qF "$kind.nrrd" out || fail "the output does not contain the file name in UTF-8: $(head -c 200 out)"
refuse 2 "$kind.absent" info "$kind.absent"
finish
