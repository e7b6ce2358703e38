#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests sessions with the command: they are recorded, replayed on every backend, truncated, damaged
# and repaired. The position of a difference must be reported.
# Covers: REQ-FILM, REQ-PART-FILES, REQ-REPLAY, REQ-SESSION-FILE, REQ-VERIFY-ANSWERS
. "${srcdir:-.}/tests/app/lib.sh"
long=${OST_TEST_LONG:-0}

run 0 phantom glenoid --out ct.nrrd
run 0 import ct.nrrd --out bone.nrrd

# Records 7,652 ticks with two tools, from a built-in bone to a complete session.
run 0 ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --tool builtin:reamer --path builtin:glenoid-ream --out whole.nrrd \
    --record whole.session --json
check "name of the session" "$(value session)" whole.session
whole=$(value sha256)
ticks=$(value ticks)
run 0 replay whole.session --verify --out again.nrrd --json
has ticks equal end_compared removed_voxels sha256 file_sha256
check "ticks of the replay" "$(value ticks)" "$ticks"
check "replay of the session: equal, end compared, digest" "$(value equal) $(value end_compared) $(value sha256)" "true true $whole"
cmp -s whole.nrrd again.nrrd || fail "the file of the replayed bone differs from that of the recorded bone"
run 0 info whole.session --json
has kind header.bone_sha256 header.config_sha256 header.build
check "info of the session: kind, ticks, replayable ticks, ended, missing" "$(value kind) $(value ticks) $(value replayable_ticks) $(value ended) '$(value missing)'" "session $ticks $ticks true ''"
run 0 info whole.session
grep -q "a session of 7,652 ticks in 7.651 s" out || fail "the first line of info is wrong: $(head -1 out)"

# Exports a table whose first columns are a path. It contains the last part of the hole and the
# first contact of the reamer.
run 0 export whole.session --out whole.csv --json
check "lines of the table" "$(wc -l <whole.csv | tr -d ' ')" $((ticks + 1))
cut -d, -f1-9 <whole.csv >path.csv
sed -n '1p;2600,2660p;5000,5060p' whole.csv | cut -d, -f1-9 >short.csv

# The digests must be the same on every backend, instruction set and number of threads.
run 0 ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path short.csv --out short.nrrd --record short.session --backend ref --json
short=$(value sha256)
isas=$("$osteon" devices --json | tee devices.json >/dev/null; i=0; while isa=$("$json_get" backends.0.isas.$i <devices.json 2>/dev/null); do echo "$isa"; i=$((i + 1)); done)
[ -n "$isas" ] || fail "osteon devices lists no instruction set"
tried=0
for isa in $isas; do
    for threads in 1 2 3; do
        [ "$long" = 1 ] || [ $((tried % 4)) -eq 0 ] || { tried=$((tried + 1)); continue; }
        run 0 replay short.session --verify --backend "cpu:isa=$isa,threads=$threads" --json
        check "replay on cpu:isa=$isa,threads=$threads: equal, ticks, digest" "$(value equal) $(value ticks) $(value sha256)" "true 122 $short"
        tried=$((tried + 1))
    done
done
run 0 replay short.session --verify --backend ref --json
check "replay on ref: equal, digest" "$(value equal) $(value sha256)" "true $short"
run 0 ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path short.session --out short2.nrrd --json
check "digest of ream with a session as its path" "$(value sha256)" "$short"
if [ "$long" = 1 ]; then
    run 0 replay whole.session --verify --backend ref --json
    check "replay of the complete session on ref: equal, digest" "$(value equal) $(value sha256)" "true $whole"
fi

# The session must contain a different chunk size, the option for no sweep, a rate and the user's
# own classes.
run 0 ream --bone ct.nrrd --chunk 16 --threshold 150 --sweep off --rate 333 --classes 'soft:150,hard:600' --tool builtin:peg --tool builtin:reamer \
    --voxel 0.75 --path short.csv --out other.nrrd --record other.session
run 0 replay other.session --verify --video other.y4m --video-fps 40 --size 64x36 --json
check "replay of a session with other options: equal" "$(value equal)" true
check "frames in the video file and dropped frames" "$(($(wc -c <other.y4m) / (6 + 3 * 64 * 36))) $(value video.dropped)" "$(value video.frames) 0"
frames=$(value video.frames)
[ "$frames" -gt 1 ] || fail "the video has $frames frames, expected at least 2"
# The view options are those of osteon sim. Each option must give different pictures and the same
# number of pictures.
run 0 replay other.session --video plain.y4m --video-fps 40 --size 320x180
for look in "--colour depth" "--clip axial" "--ghost implant" "--overlay chunks" "--contact"; do
    run 0 replay other.session --video other2.y4m --video-fps 40 --size 320x180 $look --json
    check "video with $look: frames, equal" "$(value video.frames) $(value equal)" "$frames true"
    cmp -s other2.y4m plain.y4m && fail "$look does not change the video"
    rm other2.y4m
done
# After a signal while an encoder runs, no part of the video may remain, neither immediately nor
# after the end of the encoder.
mkdir bin
cat >bin/ffmpeg <<'EOF'
#!/bin/sh
for last; do :; done
: >encoder-began
while [ ! -e encoder-continues ]; do sleep 0.05; done
cat >"$last"
: >encoder-ended
EOF
chmod +x bin/ffmpeg
PATH="$PWD/bin:$PATH" "$osteon" replay other.session --video killed.mp4 --video-fps 40 --size 320x180 --quiet >out 2>err &
wait_for() {
    i=0
    while [ ! -e "$1" ] && [ $i -lt 400 ]; do sleep 0.05; i=$((i + 1)); done
    [ -e "$1" ] || fail "$1 did not appear in 20 s"
}
wait_for encoder-began
kill -TERM $!
wait $!
check "exit status of a replay after SIGTERM" $? 143
check "files of the video after SIGTERM" "$(ls -A | grep -E 'killed|part$|part\.')" ""
: >encoder-continues
wait_for encoder-ended
check "files of the video after the encoder has ended" "$(ls -A | grep -E 'killed|part$|part\.')" ""
refuse 2 "unknown overlay" replay other.session --video other2.y4m --overlay chunk
refuse 2 "v.avi: unknown format" replay other.session --video v.avi
[ ! -e v.avi ] || fail "a video of an unknown format left a folder"
run 0 replay other.session --verify --backend cpu:isa=scalar --ticks 61 --out half.nrrd --json
check "replay with --ticks 61: ticks, end compared" "$(value ticks) $(value end_compared)" "61 false"

# Tests inputs that must be refused: another bone, another tool, no bone, and a file that is not a
# session.
refuse 2 "is not the bone of this session" replay short.session --bone whole.nrrd
refuse 2 "is not the tool 0 of this session" replay short.session --tool builtin:reamer --tool builtin:peg
refuse 2 "1 tools given; the session has 2" replay short.session --tool builtin:peg
mkdir moved && cp short.session moved/
(cd moved && "$osteon" replay short.session 2>../err >/dev/null) && fail "replay accepts a session whose bone is missing"
(cd moved && "$osteon" replay short.session --bone ../bone.nrrd >/dev/null) || fail "replay refuses a bone in another folder"
refuse 2 "not a session" replay bone.nrrd
refuse 2 "No such file" replay nothing.session
refuse 2 "--repair needs a session" info bone.nrrd --repair x.session
refuse 2 "must end in .session" ream --bone bone.nrrd --tool builtin:peg --path builtin:peg-hole --out x.nrrd --record x.log
refuse 2 "is a session, not a CT" import short.session --out x.nrrd

# For a truncated or damaged session, replay must report the damage and replay the complete part. It
# must be possible to repair the session.
size=$(wc -c <whole.session | tr -d ' ')
head -c $((size / 2)) whole.session >cut.session
run 0 replay cut.session --json
check "truncated session: equal, end compared" "$(value equal) $(value end_compared)" "true false"
[ "$(value ticks)" -gt 1000 ] || fail "the truncated session has $(value ticks) ticks, expected more than 1000"
grep -q "the recording is incomplete: it was cut off after tick" err || fail "wrong message for the truncated session: $(cat err)"
# Tests the results of --verify: equal to the end, different, or equal up to the end of the file.
run 0 replay whole.session --verify --json
check "complete session: complete, equal, verified ticks, recorded ticks" "$(value complete) $(value equal) $(value verified_ticks) $(value recorded_ticks)" "true true $ticks $ticks"
# Every verb that reads ticks from a session must warn that the session is incomplete.
warns_of_cut() {
    run 0 "$@"
    grep -q "cut.session: the recording is incomplete: it was cut off after tick" err || fail "osteon $*: no warning: $(cat err)"
}
warns_of_cut info cut.session
warns_of_cut export cut.session --out cut.csv
warns_of_cut ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path cut.session --out cut_reamed.nrrd
warns_of_cut sim --headless --no-clock --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --device replay --path cut.session
warns_of_cut sim --headless --no-clock --device null --resume cut.session --seconds 0.01
run 2 replay cut.session --verify --out cut.nrrd --json
check "truncated session with --verify: complete, equal, end compared" "$(value complete) $(value equal) $(value end_compared)" "false true false"
verified=$(value verified_ticks)
check "truncated session: recorded ticks" "$(value recorded_ticks)" "$verified"
grep -qF "cut.session: the first $verified ticks are equal; the recording is incomplete after them" err || fail "wrong message for the truncated session: $(cat err)"
[ ! -e cut.nrrd ] || fail "replay wrote a bone although the session was not verified to its end"
run 0 replay cut.session --verify --ticks 100 --json
check "truncated session with --ticks: complete, verified ticks" "$(value complete) $(value verified_ticks)" "false 100"
# If a block in the middle is damaged, the ticks before it must be compared, and the end record
# gives the total.
cp whole.session hole.session
printf 'xxxx' | dd of=hole.session bs=1 seek=$((size / 2)) conv=notrunc 2>/dev/null
run 2 replay hole.session --verify --json
verified=$(value verified_ticks)
check "session with a damaged block: complete, equal, recorded ticks" "$(value complete) $(value equal) $(value recorded_ticks)" "false true $ticks"
[ "$verified" -gt 100 ] && [ "$verified" -lt "$ticks" ] || fail "session with a damaged block: $verified of $ticks ticks were verified"
grep -qF "the first $verified of $ticks ticks are equal; the recording is incomplete after them" err || fail "wrong message for the session with a damaged block: $(cat err)"
run 0 info cut.session --repair repaired.session --json
complete_ticks=$(value replayable_ticks)
run 0 info repaired.session --json
check "repaired session: replayable ticks, cut bytes, damaged bytes" "$(value replayable_ticks) $(value cut_bytes) $(value damaged_bytes)" "$complete_ticks 0 0"
cp short.session damaged.session
printf 'x' | dd of=damaged.session bs=1 seek=$(($(wc -c <short.session) - 100)) conv=notrunc 2>/dev/null
run 0 info damaged.session
grep -q "bytes" err || fail "the message for a damaged session does not state the bytes: $(cat err)"

# Without disk space, or with a link in place of the file, the operation must not start.
ln -s victim link.session
refuse 2 "link.session: is a symbolic link" ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path short.csv --out x.nrrd --record link.session --quiet
[ ! -e x.nrrd ] && [ ! -e victim ] || fail "ream recorded to a file through a link"
if [ -w /dev/full ]; then
    refuse 2 "the disk is full" ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path short.csv --out x.nrrd --record /dev/full --quiet
    [ ! -e x.nrrd ] || fail "ream wrote a bone although its session could not be recorded"
fi
# If the disk becomes full during the recording, the bone must be complete, and the command must
# report the incomplete session.
(
    ulimit -f 600 # blocks of 512 or 1024 bytes: less than the session, more than the bone
    "$osteon" ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path path.csv --out limited.nrrd --compress \
        --record limited.session >/dev/null 2>err
)
check "exit status if the file size of the session is limited" $? 2
grep -q "limit of a file's size is reached" err || fail "the error does not state that the file size is limited: $(cat err)"
run 0 info limited.nrrd
run 0 info limited.session --json
[ "$(value replayable_ticks)" -gt 0 ] || fail "the session with a limited file size has no replayable ticks"

# Another program, written only from docs/spec/session.md, reads the file. Then a recording is
# changed.
if [ -n "${PYTHON3:-}" ] && [ "$PYTHON3" != no ]; then
    tool="$PYTHON3 $source_folder/tests/app/session_tool.py"
    check "complete session read by session_tool.py" "$($tool check whole.session)" "$ticks ended"
    check "repaired session read by session_tool.py" "$($tool check repaired.session)" "$complete_ticks cut off"
    fields='digest tool'
    [ "$long" = 1 ] && fields='digest removed tool'
    for field in $fields; do
        $tool change short.session changed.session 70 $field -1
        "$osteon" replay changed.session --verify --json >out 2>err
        status=$?
        if [ $field = tool ]; then
            check "session with another tool in tick 70: exit status, first difference" "$status $(value first_difference.tick)" "1 70"
        else
            check "session with a changed $field in tick 70: exit status, equal, first difference, the other backend agrees" "$status $(value equal) $(value first_difference.tick) $(value first_difference.other_agrees_with_recording)" \
                "1 false 70 false"
            has first_difference.chunks.0
        fi
    done
    run 1 replay changed.session
    grep -q "differs from what was recorded from tick 70 on; pass --verify to find where" out || fail "wrong message without --verify: $(cat out)"
fi

# With a wrong backend, the tick, chunk and voxel of the difference must be reported.
LD_LIBRARY_PATH=$build/.libs${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
if cp "$build/.libs/mirror.so" . 2>/dev/null; then
    run 0 replay short.session --verify --backend plugin:./mirror.so --json
    # The backend omits its 62nd removal, the first with the reamer.
    run 1 replay short.session --verify --backend plugin:./mirror.so,break=forgets --json
    check "backend that omits a removal: equal, tick, other backend, the other backend agrees" "$(value equal) $(value first_difference.tick) $(value first_difference.other_backend) $(value first_difference.other_agrees_with_recording)" \
        "false 61 ref true"
    [ "$(value first_difference.density_here)" -ge 120 ] || fail "backend that omits a removal: density $(value first_difference.density_here), expected at least 120"
    check "backend that omits a removal: density of the reference" "$(value first_difference.density_there)" 0
fi
if [ -e mirror.so ] && [ "$long" = 1 ]; then
    # After the 20th removal a distant voxel becomes bone. The digest of a tick cannot show this.
    run 1 replay short.session --verify --backend plugin:./mirror.so,break=slips --json
    check "backend that adds a voxel: position, tick, chunk" "$(value first_difference.at) $(value first_difference.tick) $(value first_difference.chunk) \
$(value first_difference.voxel.0) $(value first_difference.voxel.1) $(value first_difference.voxel.2)" "end 19 0 1 2 3"
    check "backend that adds a voxel: its density, number of different voxels" "$(value first_difference.density_here) $(value first_difference.different_voxels)" "777 1"
fi

# If the command is killed while reaming, the recorded part must replay bit-identically.
kills=1
[ "$long" = 1 ] && kills=20
k=0
while [ $k -lt $kills ]; do
    rm -f killed.session
    "$osteon" ream --bone bone.nrrd --tool builtin:peg --tool builtin:reamer --path path.csv --out killed.nrrd --record killed.session \
        --backend ref >/dev/null 2>&1 &
    while [ ! -s killed.session ] && kill -0 $! 2>/dev/null; do sleep 0.05; done
    sleep "0.$((1 + k % 5))"
    kill -9 $! 2>/dev/null
    wait $! 2>/dev/null
    k=$((k + 1))
    run 0 info killed.session --json || continue
    [ "$(value replayable_ticks)" -gt 0 ] || continue
    expected=2
    [ "$(value ended)" = true ] && expected=0
    run $expected replay killed.session --verify --json
    check "session of a killed command: equal" "$(value equal)" true
done
finish
