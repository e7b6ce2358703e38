#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim in a window. Without a display there must be an error. A window under Xvfb is
# moved and resized and receives clicks and keys; its session must replay. If its display ends or
# another client destroys the window, the program must end with one line and a complete session.
# Events whose order this test cannot control are tested in tests/window.
# Covers: REQ-WINDOW
. "${srcdir:-.}/tests/app/lib.sh"

refuse 2 "needs a window" sim --headless --device mouse --bone builtin:glenoid
refuse 2 "pass --headless" sim --no-clock
refuse 2 "pass --headless" sim --renderer none
if ! "$osteon" devices | grep -q '^  window *yes'; then
    refuse 3 "built without a window" sim
    finish
fi
unset DISPLAY WAYLAND_DISPLAY
refuse 3 "cannot open a window: DISPLAY is not set" sim
DISPLAY=:31999
export DISPLAY
refuse 3 "pass --headless to run without a window" sim
unset DISPLAY
if ! command -v Xvfb >/dev/null || ! command -v xdotool >/dev/null; then
    [ $failures -eq 0 ] || finish
    echo "SKIP: Xvfb or xdotool is not installed (Debian: xvfb, xdotool)"
    exit 77
fi

. "$source_folder/tests/app/display.sh"
MESA_GL_VERSION_OVERRIDE=2.1 refuse 3 "needs OpenGL 3.3, found 2.1 Mesa" sim
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd

# Closing the window terminates the program.
opened window.session --json
# Keys and clicks are sent after the window's first frames.
sleep 0.3
xdotool mousemove --window "$window" 320 200
xdotool mousedown 1 mousemove_relative 5 3 mousemove_relative 5 3 mouseup 1
xdotool click 4 click 4 click 5
# The tool starts clear of the bone and moves into the bone with the motor on.
xdotool keydown space keydown w; sleep 2; xdotool keyup w keyup space
xdotool keydown shift mousedown 1 mousemove_relative 4 4 mouseup 1 keyup shift
xdotool mousedown 3 mousemove_relative 20 10 mouseup 3 keydown ctrl click 4 keyup ctrl
xdotool key F1 key F1 key F3 key F8 key F10 key F10 key Tab key shift+Tab key Home key 1 key 0 key shift+Left
xdotool windowsize "$window" 500 333 windowmove "$window" 30 40
sleep 0.2
if "$osteon" devices | grep -q '^  png *yes'; then
    same_picture "the window after keys and clicks"
else
    xdotool key F12
fi
xdotool windowunmap "$window"
sleep 0.1
xdotool windowmap "$window"
on_screen || fail "the window after it was hidden and shown again: $(cat differs)"
xdotool windowunmap "$window"
xdotool windowsize "$window" 1 1 windowmap "$window" windowsize "$window" 3000 40 windowsize "$window" 500 333
sleep 0.1
xdotool mousemove --window "$window" 250 160 keydown ctrl key q keyup ctrl
ended "after Ctrl Q"
check "exit status after Ctrl Q" $status 0
has renderer.frames renderer.fps ticks sha256
check "reason of the end" "$(value end)" "it was interrupted"
[ "$(value removed_voxels)" -gt 0 ] || fail "the mouse as the device removed no voxel"
[ "$(value faults)" = 0 ] || fail "the mouse as the device caused a fault"
if [ -e osteon-001.png ]; then
    size=$(od -An -tu1 -j16 -N8 osteon-001.png | awk '{ print $1 * 16777216 + $2 * 65536 + $3 * 256 + $4, $5 * 16777216 + $6 * 65536 + $7 * 256 + $8 }')
    check "size of the stored picture" "$size" "500 333"
fi
removed=$(value sha256)
run 0 replay window.session --verify --json
check "replay of the session: equal, digest" "$(value equal) $(value sha256)" "true $removed"

# check_lost TEXT: checks for status 3, one line that contains TEXT, and a complete session
check_lost() {
    ended "$1"
    check "$1: exit status" $status 3
    check "$1: lines on standard error" "$(grep -vc '^osteon sim: device' err)" 1
    grep -qF "$1" err || fail "standard error '$(cat err)' does not contain '$1'"
    run 0 info "$recorded" --json
    check "$1: session: ended, missing" "$(value ended) $(value missing)" "true "
}
opened destroyed.session --quiet --tool builtin:burr
xdotool windowclose "$window"
check_lost "another program destroyed the window"
opened gone.session --quiet --tool builtin:burr
kill $xvfb
check_lost "lost the connection to the display"
finish
