#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests frames that OpenGL draws directly into the window, without reading them back. This needs a
# graphics card; with force_gl_renderer, Mesa's software renderer has the name of a card. The screen
# must show the picture that key F12 stores, which is drawn in memory. With a ghost, frames are
# drawn in memory. If the display is closed, the session must be complete.
# Covers: REQ-GL-SHOW
. "${srcdir:-.}/tests/app/lib.sh"

if ! "$osteon" devices | grep -q '^  window *yes' || ! command -v Xvfb >/dev/null || ! command -v xdotool >/dev/null; then
    echo "SKIP: built without a window, or Xvfb or xdotool is not installed (Debian: xvfb, xdotool)"
    exit 77
fi
. "$source_folder/tests/app/display.sh"
run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd
export force_gl_renderer="a card"

opened direct.session --json
sleep 0.5
xdotool key 2
sleep 1
if "$osteon" devices | grep -q '^  png *yes'; then
    same_picture "the view en face"
    xdotool key g
    sleep 0.5
    same_picture "a view with a ghost"
    xdotool key g F10
    sleep 0.5
    same_picture "a view with flat faces"
    xdotool windowsize "$window" 500 333
    sleep 0.5
    same_picture "a window of another size"
fi
xdotool key ctrl+q
ended "after Ctrl Q"
check "exit status after Ctrl Q" $status 0
case $(value renderer.driver) in
"a card") ;;
*)
    [ $failures -eq 0 ] || finish
    echo "SKIP: this driver does not rename its renderer: $(value renderer.driver)"
    exit 77
    ;;
esac
check "name of the renderer" "$(value renderer.name)" "gl"
[ "$(value renderer.shown_directly)" -gt 0 ] || fail "no frame was drawn directly into the window"
[ "$(value renderer.shown_directly)" -lt "$(value renderer.frames)" ] || fail "no frame was drawn in memory, although a picture was stored"

# A video needs every frame in memory.
opened film.session --json --video film.y4m
sleep 0.5
xdotool key ctrl+q
ended "after Ctrl Q"
check "with a video: exit status, renderer, frames drawn directly" "$status $(value renderer.name) $(value renderer.shown_directly)" "0 gl 0"

opened gone.session --tool builtin:burr
kill $xvfb
ended "after the display was closed"
check "after the display was closed: exit status" $status 3
grep -qF "lost the connection to the display" err || fail "the error does not state that the connection to the display was lost: $(cat err)"
run 0 info gone.session --json
check "after the display was closed: session: ended, missing" "$(value ended) $(value missing)" "true "
finish
