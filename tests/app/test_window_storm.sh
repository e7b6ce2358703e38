#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim in a window that receives a seeded random sequence of keys, clicks, drags,
# resizes, hiding and showing for ten minutes. The program must continue to run with bounded memory,
# threads and files. It must end on request, and its session must replay. Runs only with
# OST_TEST_LONG=1, or with OST_STORM_SECONDS=N for N seconds; OST_STORM_SEED=N selects another
# sequence.
# Covers: REQ-WINDOW
seconds=${OST_STORM_SECONDS:-600}
[ "${OST_TEST_LONG:-0}" = 1 ] || [ -n "${OST_STORM_SECONDS:-}" ] || { echo "skipped: runs only with OST_TEST_LONG=1"; exit 77; }
. "${srcdir:-.}/tests/app/lib.sh"
need_part window "built without a window"
if ! command -v Xvfb >/dev/null || ! command -v xdotool >/dev/null; then
    echo "SKIP: Xvfb or xdotool is not installed (Debian: xvfb, xdotool)"
    exit 77
fi
. "$source_folder/tests/app/display.sh"
seed=${OST_STORM_SEED:-1}
echo "seed $seed, $seconds s"
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
# The memory that a sanitizer retains after a free is limited, so that it can be distinguished from
# a leak.
ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}quarantine_size_mb=8"
export ASAN_OPTIONS
opened storm.session --json

# Prints one line for each event, in the syntax of `xdotool -`. Park and Miller's generator is
# exact in any awk.
awk -v w="$window" -v seed="$seed" -v seconds="$seconds" '
function r(n) { seed = (seed * 16807) % 2147483647; return int(seed / 2147483647 * n) }
BEGIN {
    keys = split("F1 F2 F3 F4 F5 F6 F7 F8 F9 F10 Escape Tab shift+Tab Home Left Right Up Down plus minus ctrl+plus Page_Up Page_Down shift+Page_Up " \
        "1 2 3 4 5 6 7 8 9 0 a c d e g h k o p r s t u v w x y z shift+x shift+Left shift+Up space Return", key, " ")
    held = split("w s e Left Up plus minus space shift", hold, " ")
    for (ms = 0; ms < 1000 * seconds; ms += pause) {
        k = r(100)
        if (k < 32) print "mousemove --window", w, r(880), r(680)
        else if (k < 44) print "click", 1 + r(5)
        else if (k < 54) print (r(2) ? "mousedown" : "mouseup"), 1 + r(3)
        else if (k < 76) print "key", key[1 + r(keys)]
        else if (k < 84) print (r(2) ? "keydown" : "keyup"), hold[1 + r(held)]
        else if (k < 90) print "windowsize", w, 1 + r(r(8) ? 1400 : 5), 1 + r(r(8) ? 1000 : 5)
        else if (k < 93) print "windowmove", w, r(500), r(300)
        else if (k < 95) print "windowunmap", w "\nsleep", r(300) / 1000 "\nwindowmap", w
        else if (k < 96) print "key F11"
        else if (k < 97) print (r(10) ? "mousemove_relative 3 5" : "key F12")
        else print "sleep", r(200) / 1000
        pause = 4 + r(30)
        print "sleep", pause / 1000
    }
}' </dev/null >storm
xdotool - <storm 2>storm.err &
storm=$!
end=$(($(date +%s) + seconds))

# Records memory in kB, files and threads every two seconds.
: >kept
while kill -0 $storm 2>/dev/null && kill -0 $pid 2>/dev/null && [ "$(date +%s)" -lt $end ]; do
    echo "$(awk '/^VmRSS/ { print $2 }' /proc/$pid/status) $(ls /proc/$pid/fd | wc -l) $(ls /proc/$pid/task | wc -l)" >>kept
    rm -f osteon-*.png
    sleep 2
done
kill -0 $pid 2>/dev/null || fail "osteon sim ended during the random events: $(tail -c 2000 err)"
kill $storm 2>/dev/null
wait $storm 2>/dev/null
sleep 0.5
for key in w s e Left Up plus minus space shift; do xdotool keyup $key; done
xdotool mouseup 1 mouseup 2 mouseup 3 windowsize "$window" 640 400
xdotool windowmap "$window" mousemove --window "$window" 250 160 key Escape keydown ctrl key q keyup ctrl
ended "after Ctrl Q"
check "exit status after Ctrl Q" $status 0
[ $status -eq 0 ] || tail -c 3000 err
# Compares the last fifth of the records with the second fifth.
if [ "$(wc -l <kept)" -ge 10 ]; then
    awk '{ m[NR] = $1; f[NR] = $2; t[NR] = $3; top = $1 > top ? $1 : top }
    END {
        n = int(NR / 5)
        for (i = 1; i <= n; i++) { early += m[n + i] / n; late += m[NR - n + i] / n; files += (f[NR - n + i] - f[n + i]) / n; threads += (t[NR - n + i] - t[n + i]) / n }
        printf "memory %d kB early, %d kB late, %d kB at most; files %+.1f, threads %+.1f\n", early, late, top, files, threads
        exit late - early > 24000 || files > 2 || threads > 2
    }' kept || fail "memory, files or threads increase: $(tail -n 1 kept)"
fi
if [ $status -eq 0 ]; then
    echo "$(value renderer.frames) frames, $(value ticks) ticks, $(value missed) missed"
    check "faults" "$(value faults)" 0
    removed=$(value sha256)
    run 0 replay storm.session --json
    check "replay of the session: equal, digest" "$(value equal) $(value sha256)" "true $removed"
fi
finish
