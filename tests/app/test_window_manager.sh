#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon sim in a window that a window manager controls. The window is minimised, restored,
# maximised, moved off the screen, made very small and very large, and closed by its frame. The loop
# must run all the time, and a window that is not visible must not need processor time.
# Covers: REQ-WINDOW
. "${srcdir:-.}/tests/app/lib.sh"
need_part window "built without a window"
for program in Xvfb xdotool xprop openbox; do
    command -v $program >/dev/null || { echo "SKIP: no $program (Debian: xvfb, xdotool, x11-utils, openbox)"; exit 77; }
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

# soon WHAT COMMAND...: waits until the command succeeds, at most 30 s. The limit is long, because other work on the
# machine may delay the window manager. A step that depends on an earlier one cannot succeed after it, so a failure
# ends the test.
soon() {
    what=$1
    shift
    checks=$((checks + 1))
    begun=$(date +%s)
    while [ $(($(date +%s) - begun)) -lt 30 ]; do
        "$@" && return
        sleep 0.02
    done
    kill -0 $manager || echo "The window manager has ended."
    fail "$what: not within 30 s; openbox printed: $(cat openbox.log)"
    [ -z "${pid:-}" ] || kill $pid
    finish
}
manages() { xprop -root _NET_SUPPORTING_WM_CHECK 2>/dev/null | grep -q 'window id'; }
state_is() { xprop -id "$window" WM_STATE 2>/dev/null | grep -q "window state: $1"; }
size_of() { xdotool getwindowgeometry "$window" | sed -n 's/.*Geometry: //p'; }
sized() { [ "$(size_of)" != "$was" ]; }
grown() { [ "$(wc -c <wm.session)" -gt "$before" ]; }
goes_on() {
    before=$(wc -c <wm.session)
    soon "the loop goes on $1" grown
}
# spent: prints the CPU time of the window's thread in hundredths of a second. In the stat file, the
# thread's name is in brackets and may contain blanks, so the text up to the bracket is removed.
spent() { sed 's/.*) //' "/proc/$pid/task/$pid/stat" | awk '{ print $12 + $13 }'; }

soon "a window manager" manages
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
opened wm.session --json
soon "the window is there" state_is Normal

xdotool key super+i
soon "minimised" state_is Iconic
sleep 0.15
before=$(wc -c <wm.session)
begin=$(spent)
sleep 0.4
idle=$(($(spent) - begin))
grown || fail "the loop stands while the window is minimised"
[ $idle -le 4 ] || fail "minimised, the window takes $idle hundredths of a second in 0.4 s"
xdotool windowmap "$window" windowactivate "$window"
soon "restored" state_is Normal
goes_on "restored"

was=$(size_of)
xdotool key super+m
soon "maximised" sized
was=$(size_of)
xdotool key super+f
soon "over all of the screen" sized
check "its size then" "$(size_of)" 900x700
xdotool key super+f key super+m
was=900x700
soon "as it was" sized
xdotool key super+u
for size in "1 1" "3000 2500" "170 2000" "640 400"; do
    xdotool windowsize "$window" $size
    sleep 0.05
done
goes_on "after any size"
for place in "-5000 -5000" "880 690" "-600 20" "30 20"; do
    xdotool windowmove "$window" $place
    sleep 0.05
done
goes_on "anywhere"
xdotool key super+i
soon "minimised again" state_is Iconic
xdotool windowmap "$window" windowactivate "$window"
soon "restored again" state_is Normal
xdotool key super+c
ended "its frame's button"
check "the end's status" $status 0
check "what ended it" "$(value end)" "it was interrupted"
[ "$(value renderer.frames)" -gt 0 ] || fail "no frame was drawn"
removed=$(value sha256)
run 0 replay wm.session --verify --json
check "what was done, again" "$(value equal) $(value sha256)" "true $removed"
finish
