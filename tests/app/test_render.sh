#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon render, which draws pictures without a display. The bytes must depend neither on the
# backend, the instruction set and the number of threads, nor on the file format of the bone.
# Covers: REQ-RENDER-SAME, REQ-VIEWS
. "${srcdir:-.}/tests/app/lib.sh"

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
refuse 2 "--size 0x5: expected" render bone.nrrd --out a.png --size 0x5
refuse 2 "needs --tool TOOL" render bone.nrrd --out a.png --pose 0,0,0,1,0,0,0
refuse 2 "--pose 1,2: expected" render bone.nrrd --out a.png --tool builtin:peg --pose 1,2
refuse 2 "must end in .png" render bone.nrrd --out a.jpg
if ! "$osteon" devices | grep -q '^  png *yes'; then
    refuse 3 "without libpng" render bone.nrrd --out a.png
    finish
fi
pose=10,20,30,0.5,0.5,0.5,0.5
views="operator en-face lateral medial anterior posterior superior inferior whole"
for view in $views tool; do
    run 0 render bone.nrrd --tool builtin:reamer --view $view --size 240x160 --out $view.png --threads 1 --json
    has renderer width height surface_voxels time_ms file_sha256
    first=$(value file_sha256)
    export OSTEON_ISA=scalar
    run 0 render ct.nrrd --tool builtin:reamer --view $view --size 240x160 --out again.png --threads 3 --json
    unset OSTEON_ISA
    check "digest of the view $view drawn with isa=scalar" "$(value file_sha256)" "$first"
done
check "number of different pictures of the views" "$(for v in $views; do cat $v.png | cksum; done | sort -u | wc -l | tr -d ' ')" 9
run 0 render bone.nrrd --size 240x160 --backend ref --chunk 64 --style faces --out ref.png --json
first=$(value file_sha256)
run 0 render bone.nrrd --size 240x160 --chunk 16 --style faces --out cpu.png --json
check "digest of the picture with the backend ref and other chunks" "$(value file_sha256)" "$first"
run 0 render bone.nrrd --size 240x160 --tool builtin:peg --pose "$pose" --out posed.png --json
[ "$(value file_sha256)" != "$first" ] || fail "the picture with a tool equals the picture without a tool"
# OpenGL's picture equals the processor's except for a few pixels, which tests/render/test_gl
# counts. This test checks only the name of the renderer.
if "$osteon" devices | grep -q '^  gl *yes'; then
    run 0 render bone.nrrd --size 240x160 --style faces --renderer gl --out gl.png --json
    has opengl.version opengl.driver opengl.way opengl.software
    check "name of the renderer" "$(value renderer)" "gl"
    # The renderer auto is gl with a graphics card and points without one. With force_gl_renderer, Mesa's software
    # renderer has the name of a card.
    software=$(value opengl.software)
    run 0 render bone.nrrd --size 240x160 --style faces --renderer auto --out auto.png --json
    if [ "$software" = true ]; then
        check "name of the renderer without a graphics card" "$(value renderer)" "points"
        has no_card
        check "digest of the picture" "$(value file_sha256)" "$first"
        export force_gl_renderer="a card"
        run 0 render bone.nrrd --size 240x160 --style faces --renderer auto --out card.png --json
        unset force_gl_renderer
        case $(value opengl.driver) in
        "a card")
            check "name of the renderer with a graphics card" "$(value renderer)" "gl"
            cmp -s gl.png card.png || fail "the pictures of --renderer gl and --renderer auto differ"
            ;;
        *) check "name of the renderer" "$(value renderer)" "points" ;; # Mesa before 22 does not rename its renderers
        esac
    else
        check "name of the renderer with a graphics card" "$(value renderer)" "gl"
    fi
    # All backends make the same mesh. The picture differs from that of the points only at edges.
    run 0 render bone.nrrd --size 240x160 --tool builtin:reamer --renderer mesh --out mesh.png --json
    has opengl.version mesh.chunks mesh.drawn_faces mesh.bytes mesh.mesh_ms mesh.copy_ms
    check "name of the renderer" "$(value renderer)" "mesh"
    [ "$(value mesh.drawn_faces)" -gt 1000 ] || fail "the mesh has $(value mesh.drawn_faces) faces, expected more than 1000"
    run 0 render bone.nrrd --size 240x160 --tool builtin:reamer --renderer mesh --backend ref --out mesh-ref.png
    cmp -s mesh.png mesh-ref.png || fail "the pictures of the meshes of cpu and ref differ"
    if "$osteon" devices | grep -q '^  cl *yes'; then
        run 0 render bone.nrrd --size 240x160 --tool builtin:reamer --renderer mesh --backend cl --out mesh-cl.png
        cmp -s mesh.png mesh-cl.png || fail "the pictures of the meshes of cpu and OpenCL differ"
    fi
    run 0 render bone.nrrd --size 240x160 --tool builtin:reamer --renderer thesis --out thesis.png --json
    check "name of the renderer" "$(value renderer)" "thesis"
else
    refuse 3 "" render bone.nrrd --size 240x160 --renderer gl --out gl.png
    refuse 3 "" render bone.nrrd --size 240x160 --renderer mesh --out mesh.png
    run 0 render bone.nrrd --size 240x160 --style faces --renderer auto --out auto.png --json
    check "name of the renderer and digest of the picture without OpenGL" "$(value renderer) $(value file_sha256)" "points $first"
    has no_card
fi

# Both verbs must have the same views. A pixel of export's picture is the mean of 2 x 2 samples, on
# any grid of a CT.
for verb in render export; do
    refuse 2 "expected operator, en-face, lateral, medial, anterior, posterior, superior, inferior, tool or whole" \
        $verb bone.nrrd --out a.png --view glenoid
    refuse 2 "--size 5x5x5: expected" $verb bone.nrrd --out a.png --view whole --size 5x5x5
    run 0 $verb bone.nrrd --view en-face --extent 60 --size 300x200 --out first.png --json
    check "size of the picture of $verb" "$(value width) $(value height)" "300 200"
    first=$(value file_sha256)
    export OSTEON_ISA=scalar
    run 0 $verb bone.nrrd --view en-face --extent 60 --size 300x200 --threads 1 --out again.png --json
    unset OSTEON_ISA
    check "digest of the picture of $verb drawn with isa=scalar" "$(value file_sha256)" "$first"
    run 0 $verb ct.nrrd --view lateral --size 64 --out square.png --json
    check "size of the square picture of $verb" "$(value width) $(value height)" "64 64"
done
run 0 import ct.nrrd --cubic 1 --out coarse.nrrd
run 0 export coarse.nrrd --slices --size 100 --out slices.png --json
refuse 2 "expected one number for slices" export coarse.nrrd --slices --size 100x90 --out slices.png

# Cut surfaces, planes, ghosts and lines must be visible and equal on all instruction sets.
refuse 2 "needs the uncut bone: pass --before BONE" render bone.nrrd --out a.png --colour depth
refuse 2 "expected plan, across" render bone.nrrd --out a.png --clip sideways
refuse 2 "are not a direction" render bone.nrrd --out a.png --clip 1,2,3,0,0,0
refuse 2 "need --clip" render bone.nrrd --out a.png --clip-shift 2
refuse 2 "needs --clip plan" render bone.nrrd --out a.png --clip axial --clip-turn 2
refuse 2 "did you mean chunks" render bone.nrrd --out a.png --overlay chunk
refuse 2 "needs --tool TOOL" render bone.nrrd --out a.png --ghost tool
run 0 ream --bone bone.nrrd --tool builtin:reamer --path builtin:glenoid-ream --out cut.nrrd
run 0 render cut.nrrd --before bone.nrrd --size 240x160 --colour bone --out plain.png --json
plain=$(cksum <plain.png)
for shown in "--colour class" "--colour depth" "--colour density" "--colour bone --clip plan --clip-turn 30" "--clip across --colour class --clip-shift 1.5" \
    "--colour bone --clip -147.5,-18,54,1,0,0.5" "--colour bone --ghost implant" "--colour bone --overlay axis" \
    "--colour bone --overlay chunks --overlay boxes" "--colour bone --no-legend" "--colour bone --extent 50"; do
    # shellcheck disable=SC2086
    run 0 render cut.nrrd --before bone.nrrd --size 240x160 $shown --out shown.png --json
    first=$(value file_sha256)
    [ "$(cksum <shown.png)" != "$plain" ] || fail "$shown does not change the picture"
    export OSTEON_ISA=scalar
    # shellcheck disable=SC2086
    run 0 render cut.nrrd --before bone.nrrd --size 240x160 --threads 1 $shown --out shown.png --json
    unset OSTEON_ISA
    check "digest of the picture with $shown drawn with isa=scalar" "$(value file_sha256)" "$first"
done
finish
