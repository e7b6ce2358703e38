# SPDX-License-Identifier: Apache-2.0
# Starts a virtual display, and osteon sim in a window on it, for tests with Xvfb and xdotool. The
# display is closed at the end of the test.

# Without -noreset, Xvfb resets when its last client ends, and refuses a client that connects at that moment.
Xvfb -noreset -displayfd 3 -screen 0 900x700x24 -fbdir . -nolisten tcp 3>display 2>xvfb.log &
xvfb=$!
trap 'kill $xvfb 2>/dev/null; rm -rf "$scratch"' EXIT
for i in $(seq 400); do
    [ -s display ] && break
    sleep 0.05
done
[ -s display ] || { fail "Xvfb does not start: $(cat xvfb.log)"; finish; }
DISPLAY=:$(cat display)
export DISPLAY

# Mesa's software driver leaks two small blocks. After the driver is unloaded, LeakSanitizer cannot
# attribute these blocks to a library. Preloaded libraries are never unloaded, which avoids this.
preload=
case ${OST_SAN_CFLAGS:-} in
*address*)
    for file in "$(${CC:-cc} -print-file-name=libasan.so)" /usr/lib/*/dri/swrast_dri.so; do
        [ -e "$file" ] && preload="$preload${preload:+ }$file"
    done
    ;;
esac

# opened SESSION OPTION...: opens a window with bone.nrrd and waits until its loop records. Sets $window
# to the window and $pid to the process
opened() {
    recorded=$1
    shift
    LD_PRELOAD=$preload "$osteon" sim --bone bone.nrrd --size 640x400 --record "$recorded" "$@" >out 2>err &
    pid=$!
    window=
    for i in $(seq 600); do
        [ -s "$recorded" ] && window=$(xdotool search --name '^osteon sim' 2>/dev/null | head -n 1) && [ -n "$window" ] && break
        kill -0 $pid 2>/dev/null || break
        sleep 0.05
    done
    [ -n "$window" ] && return
    fail "no window opens within 30 s: $(cat err)"
    kill $pid
    finish
}

# ended WHAT: waits at most 20 s until the process ends, and sets $status to its exit status
ended() {
    for i in $(seq 400); do
        kill -0 $pid 2>/dev/null || break
        sleep 0.05
    done
    kill -0 $pid 2>/dev/null && { fail "$1: osteon sim does not end within 20 s"; kill $pid; }
    wait $pid
    status=$?
}

# store_picture: stores a picture of the window by the key F12, and sets $picture to its name
pictures=0
store_picture() {
    pictures=$((pictures + 1))
    picture=$(printf 'osteon-%03d.png' $pictures)
    xdotool key F12
    for i in $(seq 100); do
        [ -s $picture ] && break
        sleep 0.1
    done
}

# on_screen: returns 0 if the screen shows the last stored picture; otherwise the file `differs` contains the first pixel
# that differs
on_screen() {
    [ -e "$picture" ] && command -v python3 >/dev/null || return 0
    set -- $(xdotool getwindowgeometry "$window" | sed -n 's/.*Position: \([-0-9]*\),\([-0-9]*\).*/\1 \2/p')
    for try in $(seq 10); do
        python3 "$source_folder/tests/app/same_screen.py" Xvfb_screen0 $1 $2 $picture 2>differs && return
        sleep 0.1
    done
    return 1
}

# same_picture WHAT: stores a picture and checks that the screen still shows it half a second later.
# A picture that was stored while the view or the tool moved is never shown again, so another one is
# then stored. The HUD changes ten times per second, so the screen then shows a later frame.
same_picture() {
    for attempt in $(seq 10); do
        store_picture
        [ -s $picture ] || { fail "$1: key F12 stores no picture within 10 s"; return; }
        sleep 0.5
        on_screen && return
    done
    fail "$1: the screen differs from each of $attempt stored pictures: $(cat differs)"
}
