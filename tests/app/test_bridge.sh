#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim with a device that osteon bridge connects over loopback, as from another machine.
# The recorded operation must replay with equal results. Times are not tested.
# Covers: REQ-LINK
. "${srcdir:-.}/tests/app/lib.sh"

(umask 077; printf 'a key of sixteen bytes, or more' >key)
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
awk 'BEGIN {
    print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
    for (i = 0; i < 4000; i++)
        printf "%.3f,300,0,%.4f,1,0,0,0\n", i * 0.001, 100 - i * 0.01
}' >press.csv

# simulate ARGS...: starts osteon sim in the background and waits until it prints its address
simulate() {
    rm -f sim.out sim.err
    : >sim.err
    "$osteon" sim --headless --bone bone.nrrd --device "udp:port=0,key=key" --tool builtin:reamer --path builtin:glenoid-slow --buttons button1=none \
        --seconds 300 "$@" >sim.out 2>sim.err &
    simulator=$!
    while ! grep -q "waits for a bridge at" sim.err && kill -0 $simulator 2>/dev/null; do sleep 0.05; done
    to=$(sed -n 's/.*waits for a bridge at //p' sim.err)
}
# json_value FILE KEY: prints the value of KEY in the JSON object in FILE
json_value() { "$json_get" "$2" <"$1"; }

simulate --record far.session --json
run 0 bridge --to "$to" --key key --device sim --path press.csv --seconds 1.5 --no-realtime --json
has ticks sent states bad late replayed limps limp_s peak_force_n round_trip_us.p50
check "osteon bridge: ticks, reason of the end, bad packets" "$(value ticks) $(value end) $(value bad)" "1500 the time was over 0"
wait $simulator
check "exit status of osteon sim" $? 0
check "reason of the end of osteon sim" "$(json_value sim.out end)" "the device has no further poses"
check "malformed packets, packets with a wrong key, faults" "$(json_value sim.out device_counts.malformed) $(json_value sim.out device_counts.wrong_key) $(json_value sim.out faults)" "0 0 0"
[ "$(json_value sim.out removed_voxels)" -gt 0 ] || fail "the operation removed no voxel"
run 0 replay far.session --verify --backend cpu:isa=scalar,threads=2 --json
check "replay of the operation with a bridge: equal, digest" "$(value equal) $(value sha256)" "true $(json_value sim.out sha256)"

# If no bridge connects, a signal ends the simulation, which must report its counts.
simulate --stats
sleep 0.2
kill -TERM $simulator
wait $simulator
check "exit status if no bridge connected" $? 0
grep -q "counters of device udp: all are 0" sim.out || fail "the output does not state that all counters are 0: $(cat sim.out)"

refuse 2 "missing option key=FILE" sim --headless --bone bone.nrrd --device udp
refuse 2 "other users can read this key" sim --headless --bone bone.nrrd --device udp:key=bone.nrrd
refuse 2 "--to nowhere: expected HOST:PORT" bridge --to nowhere --key key --device null
refuse 2 "--to 127.0.0.1:99999: port must be from 1 to 65535" bridge --to 127.0.0.1:99999 --key key --device null
refuse 2 "--to localhost:abc: port must be from 1 to 65535" bridge --to localhost:abc --key key --device null
refuse 2 "--device mouse: works only in osteon sim" bridge --to 127.0.0.1:9 --key key --device mouse
refuse 2 "--device openxr: works only in osteon sim" bridge --to 127.0.0.1:9 --key key --device openxr:hand=left
refuse 2 "--path builtin:peg-hole: built-in paths need osteon sim" bridge --to 127.0.0.1:9 --key key --path builtin:peg-hole
refuse 2 "--no-clock: cannot be combined with --device udp, which runs in real time" sim --headless --bone bone.nrrd --no-clock --device udp:port=0,key=key
refuse 2 "port=65536; expected a whole number from 0 to 65535" sim --headless --bone bone.nrrd --device udp:port=65536,key=key
refuse 2 "device sim: no path given" bridge --to 127.0.0.1:9 --key key --device sim
refuse 2 "unknown device" bridge --to 127.0.0.1:9 --key key --device omni
refuse 2 "--seconds 0: must be" bridge --to 127.0.0.1:9 --key key --device null --seconds 0
finish
