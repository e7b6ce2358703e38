#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim in a window that a window manager controls. The window is minimised, restored,
# maximised, moved off the screen, made very small and very large, and closed by its frame. The loop
# must run all the time, and a window that is not visible must not need processor time.
# Covers: REQ-WINDOW
. "${srcdir:-.}/tests/app/lib.sh"
need_part window "built without a window"
for program in Xvfb xdotool xprop openbox; do
    command -v $program >/dev/null || { echo "SKIP: $program is not installed (Debian: xvfb, xdotool, x11-utils, openbox)"; exit 77; }
done
. "$source_folder/tests/app/display.sh"
cat >rc.xml <<'EOF'
<?xml version="1.0"?>
<openbox_config xmlns="http://openbox.org/3.4/rc">
<keyboard>
<keybind key="W-i"><action name="Iconify"/></keybind>
<keybind key="W-m"><action name="ToggleMaximize"/></keybind>
<keybind key="W-u"><action name="ToggleDecorations"/></keybind>
<keybind key="W-f"><action name="ToggleFullscreen"/></keybind>
<keybind key="W-c"><action name="Close"/></keybind>
</keyboard>
</openbox_config>
EOF
HOME=$scratch XDG_CONFIG_HOME=$scratch XDG_CACHE_HOME=$scratch openbox --sm-disable --config-file rc.xml >openbox.log 2>&1 &
manager=$!
trap 'kill $manager $xvfb 2>/dev/null; rm -rf "$scratch"' EXIT

# wait_until WHAT COMMAND...: waits until the command succeeds, at most 30 s. The limit is long, because other work on the
# machine may delay the window manager. A step that depends on an earlier one cannot succeed after it, so a failure
# ends the test.
wait_until() {
    what=$1
    shift
    checks=$((checks + 1))
    begun=$(date +%s)
    while [ $(($(date +%s) - begun)) -lt 30 ]; do
        "$@" && return
        sleep 0.02
    done
    kill -0 $manager || echo "The window manager has ended."
    fail "not reached within 30 s: $what; openbox printed: $(cat openbox.log)"
    [ -z "${pid:-}" ] || kill $pid
    finish
}
manager_runs() { xprop -root _NET_SUPPORTING_WM_CHECK 2>/dev/null | grep -q 'window id'; }
state_is() { xprop -id "$window" WM_STATE 2>/dev/null | grep -q "window state: $1"; }
size_of() { xdotool getwindowgeometry "$window" | sed -n 's/.*Geometry: //p'; }
size_changed() { [ "$(size_of)" != "$was" ]; }
session_grew() { [ "$(wc -c <wm.session)" -gt "$before" ]; }
check_loop() {
    before=$(wc -c <wm.session)
    wait_until "the servo loop runs $1" session_grew
}
# cpu_time: prints the CPU time of the window's thread in hundredths of a second. In the stat file, the
# thread's name is in brackets and may contain blanks, so the text up to the bracket is removed.
cpu_time() { sed 's/.*) //' "/proc/$pid/task/$pid/stat" | awk '{ print $12 + $13 }'; }

wait_until "the window manager runs" manager_runs
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
opened wm.session --json
wait_until "the window is shown" state_is Normal

xdotool key super+i
wait_until "the window is minimised" state_is Iconic
sleep 0.15
before=$(wc -c <wm.session)
begin=$(cpu_time)
sleep 0.4
idle=$(($(cpu_time) - begin))
session_grew || fail "the servo loop does not run while the window is minimised"
[ $idle -le 4 ] || fail "the minimised window uses $idle hundredths of a second of processor time in 0.4 s, expected at most 4"
xdotool windowmap "$window" windowactivate "$window"
wait_until "the window is restored" state_is Normal
check_loop "after the window was restored"

was=$(size_of)
xdotool key super+m
wait_until "the window is maximised" size_changed
was=$(size_of)
xdotool key super+f
wait_until "the window is full-screen" size_changed
check "size of the full-screen window" "$(size_of)" 900x700
xdotool key super+f key super+m
was=900x700
wait_until "the window has its previous size" size_changed
xdotool key super+u
for size in "1 1" "3000 2500" "170 2000" "640 400"; do
    xdotool windowsize "$window" $size
    sleep 0.05
done
check_loop "after changes of the window's size"
for place in "-5000 -5000" "880 690" "-600 20" "30 20"; do
    xdotool windowmove "$window" $place
    sleep 0.05
done
check_loop "after the window was moved"
xdotool key super+i
wait_until "the window is minimised again" state_is Iconic
xdotool windowmap "$window" windowactivate "$window"
wait_until "the window is restored again" state_is Normal
xdotool key super+c
ended "after the button of the window's frame"
check "exit status after the window was closed" $status 0
check "reason of the end" "$(value end)" "it was interrupted"
[ "$(value renderer.frames)" -gt 0 ] || fail "no frame was drawn"
removed=$(value sha256)
run 0 replay wm.session --verify --json
check "replay of the session: equal, digest" "$(value equal) $(value sha256)" "true $removed"
finish
