#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests that no byte of any output depends on the implementation. The test varies the backend (ref
# and cpu), the instruction set, the number of threads (1, 2, 3 and 7), the environment variables of
# OpenMP, and the chunk size (16, 32 and 64 voxels).
#
# Every configuration writes the same outputs from one CT text, in a folder of its own. The files are
# compared with those of the reference by cmp:
#   import of text in order and shuffled, NRRD, NIfTI   bones, raw and gzip
#   voxelize by both rules, one mesh and two            tools
#   ream by built-in paths and by poses                 bones
#   export                                              text, NIfTI, STL, PNG
#   diff, info                                          page, JSON
#
# and the objects of --json without the lines that contain times. The keys that depend on chunks by
# definition (chunk, chunk_dims, chunks, active_chunks, chunk_bytes of import and ream) are compared
# among configurations with the same chunk size, all other keys among all.
#
# By default each instruction set is combined with each number of threads once, and chunk sizes
# rotate; OST_TEST_LONG=1 tests every combination.
# Covers: AR-CHK-3, AR-FILE-1, AR-LAW-1, REQ-CPU, REQ-SAME-FILES
. "${srcdir:-.}/tests/app/lib.sh"

long=${OST_TEST_LONG:-0}
is_built() { "$osteon" devices | grep -q "^  $1 *yes"; }
is_built assimp && meshes=yes || meshes=no
is_built nifti && nifti=yes || nifti=no
is_built png && png=yes || png=no

# Makes the inputs that all configurations share.
run 0 phantom glenoid --spacing 0.8 --out ct.nrrd
run 0 export ct.nrrd --out ct.txt
[ $nifti = yes ] && run 0 export ct.nrrd --out ct.nii.gz
# Writes the same lines in another order, sorted by a key modulo a prime. The first lines of a scan
# may be at any position in this file.
grep -v '^#' ct.txt | awk '{ print (NR * 7919) % 10007, $0 }' | LC_ALL=C sort -n | cut -d' ' -f2- >shuffled.txt
run 0 tool reamer --out reamer.stl
run 0 tool peg --out peg.stl
# Makes poses around the glenoid that rotate, with motions that need intermediate poses.
run 0 info ct.nrrd --json
# shellcheck disable=SC2046 # three numbers
set -- $(value meta.glenoid_at_mm)
awk -v x="$1" -v y="$2" -v z="$3" 'BEGIN {
    print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
    for (i = 0; i < 40; i++) {
        a = i * 0.11
        printf "%.3f,%.4f,%.4f,%.4f,%.6f,%.6f,%.6f,0\n", i * 0.01, x + 9 * sin(a) - 4, y + 7 * cos(2 * a), z + 0.9 * i - 18,
            cos(a / 2), sin(a / 2) * 0.6, sin(a / 2) * 0.8
    }
}' >poses.csv

# without_times: removes the lines of a JSON object that contain times.
without_times() { grep -vE '^ *"(time_ms|run_ms|p50|p99|max)":' | sed 's/,$//'; }
# without_chunks: removes the keys that depend on chunks. Their values may be numbers or arrays.
without_chunks() { awk '/"(chunk|chunks|active_chunks|chunk_bytes)": [0-9]/ { next } /"chunk_dims": \[/ { skip = 1 } !skip { print } /\]/ { skip = 0 }'; }

# run_verb OUTPUT ARGUMENT...: runs a verb and stores its JSON object in OUTPUT.json
run_verb() {
    output=$1
    shift
    "$osteon" "$@" --json >object 2>err
    status=$?
    [ $status -eq 0 ] || { [ "$1" = diff ] && [ $status -eq 1 ]; } || fail "osteon $*: status $status: $(head -c 300 err)"
    without_times <object >"$output.chunked.json"
    without_chunks <"$output.chunked.json" >"$output.json"
    rm -f object err
    # Only import and ream have keys that depend on chunks.
    case $1 in import | ream) ;; *) rm "$output.chunked.json" ;; esac
}

# make_files CHUNK OPTION...: writes all outputs to the current folder
make_files() {
    chunk=$1
    shift
    run_verb bone import ../ct.txt --out bone.nrrd --chunk "$chunk" "$@"
    run_verb small import ../shuffled.txt --spacing 0.8 --out small.nrrd --compress --chunk "$chunk" "$@"
    run_verb coarse import ../ct.nrrd --cubic 1.1 --resample nearest --threshold 300 --out coarse.nrrd --chunk "$chunk" "$@"
    [ $nifti = no ] || run_verb nii import ../ct.nii.gz --out nii.nrrd --chunk "$chunk" "$@"
    if [ $meshes = yes ]; then
        run_verb reamer voxelize ../reamer.stl --voxel 0.5 --noncutting ../peg.stl --out reamer.nrrd "$@"
        run_verb parity voxelize ../peg.stl --voxel 0.3 --rule parity --out parity.nrrd "$@"
    else
        run_verb reamer voxelize builtin:reamer --voxel 0.5 --out reamer.nrrd "$@"
    fi
    run_verb reamed ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole \
        --rate 30 --out reamed.nrrd --chunk "$chunk" "$@"
    [ "$long" != 1 ] || run_verb glenoid ream --bone reamed.nrrd --tool reamer.nrrd --path builtin:glenoid-ream --rate 60 \
        --out glenoid.nrrd --chunk "$chunk" "$@"
    run_verb free ream --bone ../ct.txt --tool reamer.nrrd --path ../poses.csv --out free.nrrd --chunk "$chunk" "$@"
    run_verb info info reamed.nrrd --digest "$@"
    run_verb text export reamed.nrrd --out reamed.txt "$@"
    run_verb surface export reamed.nrrd --out reamed.stl "$@"
    [ $nifti = no ] || run_verb volume export reamed.nrrd --out reamed.nii.gz "$@"
    run_verb difference diff bone.nrrd reamed.nrrd "$@"
    if [ "$draws" = yes ]; then
        run_verb slices export reamed.nrrd --before bone.nrrd --slices --out slices.png "$@"
        run_verb page diff bone.nrrd reamed.nrrd --html page.html "$@"
    fi
}

# Pictures take longest and are drawn from files that are compared anyway, so only every fifth
# configuration draws.
pictures=0
[ $png = no ] || pictures=4
draws=$png
ways=0
# compare_files NAME CHUNK OPTION...: writes the outputs and compares them with those of the reference
compare_files() {
    name=$1
    shift
    [ "$long" = 1 ] || [ $((ways % 5)) -eq 0 ] && draws=$png || draws=no
    ways=$((ways + 1))
    mkdir way && cd way || exit 99
    make_files "$@"
    for file in *; do
        case $file in *.chunked.json) against=../ref$1 ;; *) against=../ref32 ;; esac
        checks=$((checks + 1))
        cmp -s "$file" "$against/$file" || fail "$name, chunks of $1: $file differs from the reference's file"
    done
    here=$(ls | wc -l) all=$(ls ../ref32 | wc -l)
    [ "$draws" = yes ] || here=$((here + pictures))
    check "$name, chunks of $1: number of files" $((here)) $((all))
    cd .. && rm -r way
}

for size in 32 16 64; do
    mkdir ref$size && cd ref$size || exit 99
    make_files $size --backend ref
    cd ..
    [ $size = 32 ] && continue
    for file in ref32/*; do
        case $file in *.chunked.json) continue ;; esac
        checks=$((checks + 1))
        cmp -s "$file" "ref$size/${file#ref32/}" || fail "ref, chunks of $size: ${file#ref32/} differs from the file with chunks of 32"
    done
done
# The comparison would prove nothing if the reference removed no voxels, or if the filters removed
# all lines of the objects.
check "the built-in paths remove voxels" "$(grep -c '"removed_voxels": [1-9]' ref32/reamed.json)" 1
check "the poses remove voxels" "$(grep -c '"removed_voxels": [1-9]' ref32/free.json)" 1
check "number of digests in bone.json" "$(grep -c '"sha256"' ref32/bone.json)" 4
cmp -s ref32/bone.nrrd ref32/small.nrrd && fail "the compressed file equals the raw file"

[ $failures -eq 0 ] || finish

isas=
for isa in scalar avx2 avx512 avx512vbmi neon; do
    "$osteon" devices --backend "cpu:isa=$isa" | grep -q "works with $isa" && isas="$isas $isa"
done
turn=0
for isa in $isas; do
    for threads in 1 2 3 7; do
        turn=$((turn + 1))
        for size in 16 32 64; do
            [ "$long" = 1 ] || [ $((turn % 3)) -eq $((size / 16 % 4 % 3)) ] || continue
            compare_files "cpu:isa=$isa, $threads threads" $size --backend "cpu:isa=$isa" --threads $threads
        done
    done
done

# Tests the environment variables of OpenMP: an odd number of threads, fewer threads than requested,
# and a dynamic number.
OMP_NUM_THREADS=5 OMP_SCHEDULE=dynamic,1 compare_files "OMP_NUM_THREADS=5" 32
OMP_THREAD_LIMIT=2 OMP_DYNAMIC=true compare_files "OMP_THREAD_LIMIT=2" 32 --threads 7
if [ "$long" = 1 ]; then
    for size in 16 64; do
        OMP_NUM_THREADS=1 compare_files "OMP_NUM_THREADS=1" $size
        OMP_NUM_THREADS=9 OMP_WAIT_POLICY=passive OMP_PROC_BIND=false compare_files "OMP_NUM_THREADS=9" $size
    done
fi
if is_built embree; then
    compare_files "voxelizer=embree" 32 --backend cpu:voxelizer=embree --threads 3
fi
echo "instruction sets:$isas; $ways configurations with $(ls ref32 | wc -l | tr -d ' ') files each"
finish
