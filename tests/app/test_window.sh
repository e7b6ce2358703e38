#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# osteon sim in a window: what it says without one, and a window under Xvfb
# that is moved, resized, clicked and typed into, whose session replays.
# Covers: REQ-WINDOW
. "${srcdir:-.}/tests/app/lib.sh"

refuse 2 "needs a window" sim --headless --device mouse --bone builtin:glenoid
refuse 2 "add --headless" sim --no-clock
refuse 2 "add --headless" sim --renderer null
if ! "$osteon" devices | grep -q '^  window *yes'; then
    refuse 3 "built without a window" sim
    finish
fi
unset DISPLAY WAYLAND_DISPLAY
refuse 3 "there is no display" sim
DISPLAY=:31999
export DISPLAY
refuse 3 "--headless runs without one" sim
unset DISPLAY
if ! command -v Xvfb >/dev/null || ! command -v xdotool >/dev/null; then
    [ $failures -eq 0 ] || finish
    echo "SKIP: no Xvfb and xdotool to open a window with (Debian: xvfb, xdotool)"
    exit 77
fi

Xvfb -displayfd 3 -screen 0 900x700x24 -nolisten tcp 3>display 2>xvfb.log &
xvfb=$!
trap 'kill $xvfb 2>/dev/null; rm -rf "$scratch"' EXIT
for i in $(seq 100); do
    [ -s display ] && break
    sleep 0.2
done
[ -s display ] || fail "Xvfb does not start: $(cat xvfb.log)"
DISPLAY=:$(cat display)
export DISPLAY
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd

# Mesa's software driver leaves two small blocks behind when it is unloaded, which LeakSanitizer finds without a name;
# what stays loaded keeps them.
preload=
case ${OST_SAN_CFLAGS:-} in
*address*)
    for file in "$(${CC:-cc} -print-file-name=libasan.so)" /usr/lib/*/dri/swrast_dri.so; do
        [ -e "$file" ] && preload="$preload${preload:+ }$file"
    done
    ;;
esac
LD_PRELOAD=$preload "$osteon" sim --bone bone.nrrd --size 640x400 --record window.session --json >out 2>err &
pid=$!
window=
for i in $(seq 150); do
    # It records when the loop begins.
    [ -s window.session ] && window=$(xdotool search --name '^osteon sim' 2>/dev/null | head -n 1) && [ -n "$window" ] && break
    kill -0 $pid 2>/dev/null || break
    sleep 0.2
done
if [ -z "$window" ]; then
    fail "no window opens: $(cat err)"
    kill $pid
    finish
fi
# Keys and clicks wait for its first frames.
sleep 0.5
xdotool mousemove --window "$window" 320 200
xdotool mousedown 1 mousemove_relative 5 3 mousemove_relative 5 3 mouseup 1
xdotool keydown w; sleep 0.8; xdotool keyup w
xdotool click 4 click 4 click 5 keydown space; sleep 0.2; xdotool keyup space
xdotool keydown shift mousedown 1 mousemove_relative 4 4 mouseup 1 keyup shift
xdotool mousedown 3 mousemove_relative 20 10 mouseup 3 keydown ctrl click 4 keyup ctrl
xdotool key F1 key F1 key F3 key F8 key F10 key F10 key Tab key Home key 1
xdotool windowsize "$window" 500 333 windowmove "$window" 30 40
sleep 0.5
xdotool key F12
for i in $(seq 50); do
    [ -s osteon-001.png ] && break
    sleep 0.1
done
xdotool windowunmap "$window"
sleep 0.1
xdotool windowmap "$window"
sleep 0.1
xdotool mousemove --window "$window" 250 160 keydown ctrl key q keyup ctrl
for i in $(seq 100); do
    kill -0 $pid 2>/dev/null || break
    sleep 0.2
done
kill -0 $pid 2>/dev/null && { fail "Ctrl Q does not end it"; kill $pid; }
wait $pid
check "the end's status" $? 0
has renderer.frames renderer.fps ticks sha256
check "what ended it" "$(value end)" "it was asked to end"
[ "$(value removed_voxels)" -gt 0 ] || fail "the mouse removed nothing"
[ "$(value faults)" = 0 ] || fail "the mouse's hand was in a fault"
if [ -e osteon-001.png ]; then
    size=$(od -An -tu1 -j16 -N8 osteon-001.png | awk '{ print $1 * 16777216 + $2 * 65536 + $3 * 256 + $4, $5 * 16777216 + $6 * 65536 + $7 * 256 + $8 }')
    check "the picture is as large as the window" "$size" "500 333"
elif "$osteon" devices | grep -q '^  png *yes'; then
    fail "F12 leaves no picture"
fi
removed=$(value sha256)
run 0 replay window.session --verify --json
check "what was done, again" "$(value equal) $(value sha256)" "true $removed"
finish
