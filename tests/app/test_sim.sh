#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim without a window: its output, and that an operation has the same result with and
# without a clock, and in a replay. Times are not tested.
# Covers: REQ-FILM, REQ-HAPTICS, REQ-REPLAY, REQ-MOTION, REQ-DEVICE-LOST
. "${srcdir:-.}/tests/app/lib.sh"
other=cpu:isa=scalar,threads=2
[ "${OST_TEST_LONG:-0}" = 1 ] && other=ref

run 0 devices --json
has haptics.0.name haptics.0.available haptics.0.reason haptics.3.max_force_n
check "device sim of osteon devices: name, available, force" "$(value haptics.3.name) $(value haptics.3.available) $(value haptics.3.force)" "sim true true"

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
run 0 sim --headless --bone bone.nrrd --seconds 0.5 --record live.session --out live.nrrd --json
has ticks missed exec_us.p50 exec_us.p99 exec_us.p99_9 exec_us.max wake_us.p50 wake_us.p99_9 completion_us.max completion_us.p99 \
    own_us.p99_9 missed_by_work missed_woken_late missed_preempted removed_voxels sha256 scheduling memory stolen_ms
check "ticks, faults, ticks without a sample" "$(value ticks) $(value faults) $(value ticks_without_sample)" "500 0 0"
[ "$(value removed_voxels)" -gt 0 ] || fail "the simulated operator removed no voxel"
awk "BEGIN { exit !($(value peak_force_n) > 0.4 && $(value contact_ticks) >= 370) }" ||
    fail "the simulated operator does not press: $(value peak_force_n) N, $(value contact_ticks) ticks with contact"
live=$(value sha256)
run 0 replay live.session --verify --backend $other --json
check "replay of the operation: equal, ticks, end compared, digest" "$(value equal) $(value ticks) $(value end_compared) $(value sha256)" "true 500 true $live"
run 0 info live.session --json
check "device and tick length in the session" "$(value header.device) $(value header.tick_ns)" "sim 1000000"

# Without a clock and with a different number of threads, the operation must be the same. With
# another simulated operator it must differ.
run 0 sim --headless --bone bone.nrrd --seconds 0.5 --no-clock --threads 2 --json
check "operation without a clock: ticks, missed deadlines, digest" "$(value ticks) $(value missed) $(value sha256)" "500 0 $live"
run 0 sim --headless --bone bone.nrrd --device sim:grip=light,friction=20,tremor=300,seed=4 --seconds 2 --no-clock --json
shaking=$(value sha256)
run 0 sim --headless --bone bone.nrrd --device sim:grip=light,friction=20,tremor=300,seed=4 --seconds 2 --no-clock --json
check "digest with the same simulated operator" "$(value sha256)" "$shaking"
run 0 sim --headless --bone bone.nrrd --device sim:grip=light,friction=20,tremor=300,seed=5 --seconds 2 --no-clock --json
[ "$(value sha256)" != "$shaking" ] || fail "the operation is the same with another seed of the simulated operator"

# A renderer that runs at the same time must not change the result, and its picture must be the same
# on every instruction set.
if "$osteon" devices | grep -q '^  png *yes'; then
    run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --picture seen.png --json
    has renderer.frames renderer.fps renderer.frame_ms.p50 renderer.frame_ms.p99 renderer.changed_chunks
    check "name and size of the renderer" "$(value renderer.name) $(value renderer.width) $(value renderer.height)" "points 320 200"
    seen=$(value sha256)
    export OSTEON_ISA=scalar
    run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --picture scalar.png --video scalar.y4m --json
    unset OSTEON_ISA
    check "digest with a renderer" "$(value sha256)" "$seen"
    check "frames in the video file" "$(($(wc -c <scalar.y4m) / (6 + 3 * 320 * 200)))" "$(value video.frames)"
    cmp seen.png scalar.png || fail "the picture depends on the instruction set"
    if "$osteon" devices | grep -q '^  gl *yes'; then
        run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --renderer gl --picture gl.png --json
        has renderer.opengl renderer.driver
        check "operation with --renderer gl: renderer, width, digest" "$(value renderer.name) $(value renderer.width) $(value sha256)" "gl 320 $seen"
        driver=$(value renderer.driver)
        if "$osteon" devices | grep -q '^  cl *yes'; then
            run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --backend cl --renderer gl --json
            check "operation on OpenCL with --renderer gl: renderer, digest" "$(value renderer.name) $(value sha256)" "gl $seen"
            [ "$(value renderer.copied_bytes)" -gt 0 ] || fail "the renderer copied no voxels from the OpenCL device"
        fi
        export force_gl_renderer="a card"
        run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --renderer auto --picture card.png --json
        unset force_gl_renderer
        check "operation with --renderer auto: width, digest" "$(value renderer.width) $(value sha256)" "320 $seen"
        case $driver in
        *llvmpipe*)
            case $(value renderer.name) in
            gl) check "name of the OpenGL driver" "$(value renderer.driver)" "a card" ;;
            points) has renderer.no_card ;; # Mesa before 22 does not rename its renderers
            *) fail "unexpected renderer $(value renderer.name)" ;;
            esac
            ;;
        esac
        run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --renderer thesis --picture thesis.png --json
        check "operation with --renderer thesis: renderer, width, digest" "$(value renderer.name) $(value renderer.width) $(value sha256)" "thesis 320 $seen"
        ! cmp -s gl.png thesis.png || fail "the pictures of --renderer thesis and --renderer gl are equal"
        run 0 sim --headless --bone bone.nrrd --seconds 0.3 --no-clock --size 320x200 --renderer mesh --picture mesh.png --json
        check "operation with --renderer mesh: renderer, width, digest" "$(value renderer.name) $(value renderer.width) $(value sha256)" "mesh 320 $seen"
        [ -z "$(value renderer.lost)" ] || fail "the renderer mesh failed: $(value renderer.lost)"
    fi
fi
run 0 sim --headless --bone bone.nrrd --seconds 0.3 --size 64x48 --renderer points --json
has renderer.fps_worst_1_percent
[ "$(value renderer.frames)" -gt 0 ] || fail "no frame was drawn in 0.3 s"
# The summary must be short; --stats must add the times.
run 0 sim --headless --bone bone.nrrd --seconds 0.05
[ "$(wc -l <out)" -le 6 ] || fail "the summary is longer than six lines: $(cat out)"
grep -q "deadlines missed: [0-9,]* in 50 ticks" out || fail "the summary does not state the missed deadlines: $(cat out)"
grep -q "bone removed: [0-9,]* voxels, [0-9.]* mm3; grid [0-9a-f]*" out || fail "the summary does not state the removed bone: $(cat out)"
run 0 sim --headless --bone bone.nrrd --seconds 0.05 --stats
for line in "delay of a tick's begin" "duration of a tick" "thread CPU time" "scheduling:"; do
    grep -q "$line" out || fail "--stats does not print '$line': $(cat out)"
done
refuse 2 "needs --renderer auto" sim --headless --bone bone.nrrd --renderer none --hud
refuse 2 "cannot be combined" sim --headless --bone bone.nrrd --video a.y4m --video-pipe cat
refuse 2 "--size 12x: expected" sim --headless --bone bone.nrrd --size 12x
refuse 2 "needs --renderer auto" sim --headless --bone bone.nrrd --renderer none --picture a.png

# With a force, less bone must be removed than without, and the session must contain the force on
# the hand. The session must replay.
run 0 sim --headless --bone bone.nrrd --path builtin:glenoid-ream --seconds 2.5 --no-clock --force off --json
free=$(value removed_voxels)
run 0 sim --headless --bone bone.nrrd --path builtin:glenoid-ream --seconds 2.5 --no-clock --record felt.session --json
has peak_force_n peak_axial_n cutting_j contact_ticks damped_ticks
check "force law with a device that renders forces" "$(value force)" energy
[ "$(value removed_voxels)" -lt "$free" ] || fail "with a force, $(value removed_voxels) voxels were removed, expected fewer than $free"
felt=$(value sha256)
run 0 replay felt.session --verify --backend cpu:isa=scalar --json
check "replay of the operation with a force: equal, digest" "$(value equal) $(value sha256)" "true $felt"
run 0 export felt.session --out felt.csv
awk -F, 'NR > 1 && $21 != 0 { n++ } END { exit n < 100 }' felt.csv || fail "the session contains fewer than 100 ticks with a force"
# Tests removal in some ticks and force in all ticks, with the thesis' 333 Hz, a divisor of the
# loop's rate, and a rate that is not a divisor. Each operation must replay.
for rate in 333:200 250:150 70:42; do
    run 0 sim --headless --bone bone.nrrd --seconds 0.6 --no-clock --rate "${rate%:*}" --record rate.session --json
    check "removals at ${rate%:*} Hz" "$(value removals)" "${rate#*:}"
    # The tool starts 2 mm outside the face, which takes 0.1 s.
    [ "$(value contact_ticks)" -gt 450 ] || fail "removals at ${rate%:*} Hz: $(value contact_ticks) ticks with contact, expected more than 450"
    at_rate=$(value sha256)
    run 0 replay rate.session --verify --json
    check "replay with removals at ${rate%:*} Hz: equal, digest" "$(value equal) $(value sha256)" "true $at_rate"
done

# Tests parameters from a file: they are printed, changed and recorded. An error must be reported in
# one line.
"$osteon" sim --print-force-params >force.params || fail "--print-force-params failed"
run 0 sim --headless --bone bone.nrrd --seconds 0.5 --no-clock --force-params force.params --record params.session --json
check "digest with the printed parameters" "$(value sha256)" "$live"
run 0 info params.session --json
grep -q '"force.stiffness": "300"' out || fail "the session does not contain the parameters: $(cat out)"
echo "max_force: 0.2" >weak.params
run 0 sim --headless --bone bone.nrrd --seconds 0.5 --no-clock --force-params weak.params --json
awk "BEGIN { exit !($(value peak_force_n) <= 0.2 && $(value peak_force_n) > 0.1) }" || fail "the peak force is $(value peak_force_n) N, expected 0.1 to 0.2 N"
echo "stiffness: 1e9" >wrong.params
refuse 2 "wrong.params:1: stiffness is '1e9': expected 1 to 1e+06 N/m" sim --headless --force-params wrong.params
refuse 2 "nothing.params: cannot open" sim --headless --force-params nothing.params
echo "turn_stiffness: 1" >turn.params
run 0 sim --headless --bone bone.nrrd --seconds 0.05 --no-clock --force-params turn.params
grep -q "turn_stiffness ignored: device sim renders no torques" err || fail "there is no warning that turn_stiffness is ignored: $(cat err)"

run 0 sim --headless --bone bone.nrrd --path builtin:glenoid-ream --seconds 2.5 --no-clock --force instant --json
check "force law with --force instant" "$(value force)" instant
refuse 2 "device null cannot render a force; pass --force off" sim --headless --bone bone.nrrd --device null --force energy

# Scripts and sessions that are used as devices end before the given time.
run 0 sim --headless --bone bone.nrrd --device replay --path live.session --no-clock --json
check "session as a device: ticks, digest" "$(value ticks) $(value sha256)" "500 $live"
grep -q "no further poses" out || fail "the output does not state that the session has no further poses: $(cat out)"
run 0 ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --out hole.nrrd --json
hole=$(value sha256)
run 0 sim --headless --bone bone.nrrd --device script --tool builtin:peg --path builtin:peg-hole --no-clock --seconds 60 --json
check "digest of a script as a device and of ream" "$(value sha256)" "$hole"
run 0 sim --headless --bone bone.nrrd --device null --seconds 0.05 --no-realtime --json
check "device null: ticks, scheduling" "$(value ticks) $(value scheduling)" "50 as it was"
run 0 sim --headless --bone bone.nrrd --device null --seconds 0.05
grep -q "deadlines missed" out || fail "the output does not contain the missed deadlines: $(cat out)"

# Tests a tracked device whose tracking is lost for 0.2 s in the middle, and in the last 0.2 s.
awk 'BEGIN {
    print "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
    for (i = 0; i <= 300; i++) {
        w = (i > 100 && i < 150) || i > 250 ? "nan" : "1"
        printf "%.4f,1,2,%.6f,%s,0,0,0\n", i * 0.004, -0.05 * i * 0.004, w
    }
}' >hand.csv
run 0 sim --headless --bone bone.nrrd --device motion:hand.csv,scale=20 --no-clock --record hand.session --seconds 60 --json
check "tracked device: ticks, drop-outs, their sum and longest in s, faults" "$(value ticks) $(value dropouts) $(value dropout_s) $(value longest_dropout_s) $(value faults)" "1201 2 0.399 0.2 0"
hand=$(value sha256)
run 0 replay hand.session --verify --backend $other --json
check "replay of the tracked operation: ticks, equal, digest" "$(value ticks) $(value equal) $(value sha256)" "802 true $hand"
run 0 sim --headless --bone bone.nrrd --device motion:hand.csv,scale=20 --no-clock
grep -q "lost tracking 2 times, 0.399 s in all" out || fail "the output does not contain the drop-outs: $(cat out)"
refuse 2 "nowhere.csv: cannot open" sim --headless --bone bone.nrrd --device motion:nowhere.csv
refuse 2 "bone.nrrd:1: " sim --headless --bone bone.nrrd --device motion:bone.nrrd

# An operation that is stopped or killed in the middle and then continued must give the same bone as
# an operation without interruption.
"$osteon" ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path builtin:peg-hole --path builtin:glenoid-ream --out all.nrrd \
    --record all.session >/dev/null || fail "recording all.session failed"
"$osteon" export all.session --out all.csv >/dev/null || fail "exporting all.csv failed"
{ head -n 1 all.csv; sed -n '4800,5100p' all.csv; } | cut -d, -f1-9 >one.csv
{ head -n 1 all.csv; sed -n '4800,4950p' all.csv; } | cut -d, -f1-9 >first.csv
{ head -n 1 all.csv; sed -n '4951,5100p' all.csv; } | cut -d, -f1-9 >second.csv
run 0 ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path one.csv --out one.nrrd --json
one=$(value sha256)
run 0 sim --headless --no-clock --device script --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path first.csv --record first.session
head -c $(($(wc -c <first.session) - 128)) first.session >killed.session
cut=$("$osteon" info killed.session --json 2>/dev/null | "$json_get" replayable_ticks)
{ head -n 1 one.csv; tail -n +$((cut + 2)) one.csv; } >rest.csv
run 0 sim --headless --no-clock --device script --resume first.session --path second.csv --record both.session --json
check "continued operation: ticks before, ticks, faults, digest" "$(value ticks_before) $(value ticks) $(value faults) $(value sha256)" "151 150 0 $one"
run 0 replay both.session --verify --backend $other --json
check "session of the continued operation: ticks, equal" "$(value ticks) $(value equal)" "301 true"
run 0 sim --headless --no-clock --device script --resume killed.session --path rest.csv --json
check "operation continued after a kill: all ticks, digest" "$(($(value ticks_before) + $(value ticks))) $(value sha256)" "301 $one"
run 0 sim --headless --no-clock --device null --resume first.session --path builtin:peg-hole --seconds 0.02 --json
check "operation continued with a distant device: faults, ticks with a fault" "$(value faults) $(value fault_ticks)" "1 20"
refuse 2 "names the same file" sim --headless --resume first.session --record first.session
refuse 2 "is not the bone of this session" sim --headless --resume first.session --bone all.nrrd

# If a signal ends the operation, the session must be complete and record the reason.
"$osteon" sim --headless --bone bone.nrrd --seconds 20 --record asked.session --json >out 2>err &
while [ ! -s asked.session ] && kill -0 $! 2>/dev/null; do sleep 0.05; done
sleep 0.4
kill -TERM $!
wait $!
check "exit status after a signal" $? 0
check "reason of the end after a signal" "$(value end)" "it was interrupted"
ticks=$(value ticks)
run 0 info asked.session --json
check "session after a signal: ended, replayable ticks" "$(value ended) $(value replayable_ticks)" "true $ticks"

# If the disk becomes full during the operation, this must be reported immediately, and the
# operation must continue to its end.
(
    ulimit -f 60 # blocks of 512 or 1024 bytes
    "$osteon" sim --headless --bone bone.nrrd --seconds 1.2 --record full.session >out 2>err
)
check "exit status of a run on a full disk" $? 2
grep -q "limit of a file's size is reached; the operation goes on, and the recording waits: there is room for" err || fail "wrong message on a full disk: $(cat err)"
grep -q "1,200 ticks; the time was over" out || fail "the operation on a full disk did not continue to its end: $(cat out)"
# A pipe whose reader reads nothing for three seconds simulates a slow disk.
if [ "${OST_TEST_LONG:-0}" = 1 ] && mkfifo slow.session; then
    (sleep 4; cat >whole.session) <slow.session &
    run 0 sim --headless --bone bone.nrrd --seconds 5 --record slow.session
    wait
    grep -q "nothing could be written for 2 s: the disk is slow, or the recorder was stopped; the operation goes on" err || fail "there is no message about the slow disk: $(cat err)"
    grep -q "recording goes on; nothing was lost" err || fail "there is no message that the recording continues: $(cat err)"
    run 0 replay whole.session --verify --json
    check "session recorded through a slow pipe: ticks, equal" "$(value ticks) $(value equal)" "5000 true"
fi

refuse 2 "unknown device 'omni'" sim --headless --bone bone.nrrd --device omni
refuse 2 "expected light, normal or firm" sim --headless --bone bone.nrrd --device sim:grip=iron
refuse 2 "--seconds 0: must be greater than 0" sim --headless --seconds 0
refuse 2 "--seconds -1: must be from 0" sim --headless --seconds -1
refuse 2 "needs one --path SESSION" sim --headless --device replay
refuse 2 "must end in .session" sim --headless --record x.log
# If the device is lost, the status must be 3, all outputs must be written, and it must be possible
# to replay and continue the session.
if [ -e "$build/.libs/fake_hd.so" ] && [ -z "${OST_SAN_CFLAGS:-}" ]; then
    OSTEON_OPENHAPTICS_LIBRARY=$build/.libs/fake_hd.so FAKE_HD_FAIL_READ_AT=200
    export OSTEON_OPENHAPTICS_LIBRARY FAKE_HD_FAIL_READ_AT
    run 3 sim --headless --bone bone.nrrd --device openhaptics --seconds 60 --record lost.session --out lost.nrrd --json
    check "lost device: reason of the end" "$(value end)" "the device was lost"
    grep -q "device openhaptics: the device was lost after [0-9]* ticks, before the end of the operation" err || fail "lost device: wrong message: $(cat err)"
    lost_ticks=$(value ticks)
    check "lost device: digest of the written bone" "$(value file_sha256)" "$(sha256sum lost.nrrd | cut -d' ' -f1)"
    run 0 replay lost.session --verify --json
    check "replay of the session with a lost device: complete, verified ticks" "$(value complete) $(value verified_ticks)" "true $lost_ticks"
    unset FAKE_HD_FAIL_READ_AT
    # For the limit of the force, the value in a file has priority over the value of the device,
    # which has priority over the default.
    OSTEON_DHD_LIBRARY=$build/.libs/fake_dhd.so
    export OSTEON_DHD_LIBRARY
    echo "max_force: 2" >two.force
    echo "stiffness: 250" >soft.force
    # check_limit DEVICE EXPECTED [FILE]: checks the limit in the report and in the session
    check_limit() {
        run 0 sim --headless --bone bone.nrrd --device "$1" --seconds 0.02 --record limit.session --json ${3:+--force-params "$3"}
        check "force limit of the device $1, ${FAKE_HD_MAX_FORCE-}${FAKE_DHD_TYPE-} ${3-}" "$(value max_force_n) $(value max_force_from)" "$2"
        if grep -q "is not a usable limit" err; then warned=1; else warned=0; fi
        run 0 info limit.session --json
        grep -q "\"force.max_force\": \"${2%% *}\"" out || fail "the session does not contain the force limit of the device $1: $(cat out)"
        grep -q "\"force.max_force_from\": \"${2#* }" out || fail "the session does not contain the origin of the force limit of the device $1: $(cat out)"
    }
    check_limit openhaptics "2.97 device"
    check "number of warnings for a plausible limit" $warned 0
    check_limit openhaptics "2 force-params" two.force
    check_limit openhaptics "2.97 device" soft.force
    for absurd in nan 0 -3 1e6 inf; do
        export FAKE_HD_MAX_FORCE=$absurd
        check_limit openhaptics "3 default"
        check "number of warnings for the limit $absurd" $warned 1
    done
    unset FAKE_HD_MAX_FORCE
    check_limit dhd "10.8 device"
    FAKE_DHD_TYPE=104
    export FAKE_DHD_TYPE
    check_limit dhd "10.8 device"
    grep -q '"force.max_torque": "0.18"' out || fail "the session does not contain the torque limit of a sigma.7: $(cat out)"
    FAKE_DHD_TYPE=63
    check_limit dhd "18 device"
    FAKE_DHD_TYPE=7
    check_limit dhd "3 default"
    check "number of warnings for an unknown type of device" $warned 1
    unset FAKE_DHD_TYPE
    check_limit sim "3 default"
fi
# Before the device moves, no tool may remove anything: a simulated operator starts clear of the
# bone.
run 0 sim --headless --bone bone.nrrd --device null --seconds 1 --no-clock --json
check "device null: ticks, removed voxels, overlap" "$(value ticks) $(value removed_voxels) $(value overlap_voxels)" "1000 0 0"
for device in sim script; do
    run 0 sim --headless --bone bone.nrrd --device $device --seconds 0.001 --no-clock --strict --json
    check "overlap at the start with the device $device" "$(value overlap_voxels)" 0
done
run 0 sim --headless --bone bone.nrrd --device null --tool builtin:burr --tool builtin:peg --seconds 0.1 --no-clock --json
check "device null with the burr and the peg: removed voxels" "$(value removed_voxels)" 0
# With the motor off, no path may remove anything.
for path in peg-hole glenoid-ream glenoid-slow glenoid-press; do
    run 0 ream --bone bone.nrrd --tool builtin:reamer --path builtin:$path --rpm 0 --out off.nrrd --json
    check "path $path with the motor off: removals, removed voxels" "$(value removals) $(value removed_voxels)" "0 0"
done
run 0 sim --headless --bone bone.nrrd --device sim --rpm 0 --seconds 0.5 --no-clock --json
check "removed voxels of a pressing operator with the motor off" "$(value removed_voxels)" 0
# A tool with its motor on must remove more than a tool that does not rotate. The path contains the
# speed in each row.
run 0 ream --bone bone.nrrd --tool builtin:reamer --path builtin:glenoid-ream --out on.nrrd --json
turning=$(value removed_voxels)
run 0 ream --bone bone.nrrd --tool builtin:reamer --path builtin:glenoid-ream --rpm 1 --out on.nrrd --json
[ "$turning" -gt $(($(value removed_voxels) * 11 / 10)) ] || fail "a rotating reamer removes $turning voxels, a nearly static one $(value removed_voxels)"
refuse 2 "must be from 0 to 3000" ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --out off.nrrd --rpm 3001
refuse 2 "at least 13.3 Hz" sim --headless --bone bone.nrrd --rate 5
refuse 2 "unknown button 'lever'" sim --headless --bone bone.nrrd --device dhd --buttons lever=motor
refuse 2 "device sim has no buttons" sim --headless --bone bone.nrrd --buttons 1=motor
"$osteon" sim --print-force-params | grep -q '^speed' && fail "--print-force-params prints the speed of the motor, which is not a parameter of the force"
# Suitable parameters depend on the device. Each preset file must be accepted.
for preset in "$source_folder"/presets/*.force; do
    run 0 sim --print-force-params --force-params "$preset" --json
    check "force limit of the preset $(basename "$preset")" "$(value force_params.max_force)" "$(sed -n 's/^max_force: \([0-9.]*\) .*/\1/p' "$preset")"
done
finish
