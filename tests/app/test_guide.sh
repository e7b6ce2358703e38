#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the commands of docs/guide, each page in a folder of its own. The commands are the lines of
# all blocks that begin with ```sh, in order. If a line ends in "# status N", its exit status must
# be N.
# Covers: REQ-CLI-HELP
. "${srcdir:-.}/tests/app/lib.sh"
needs ASSIMP NIFTI PNG

mkdir bin
ln -s "$osteon" bin/osteon
PATH=$PWD/bin:$PATH
pages=0
commands=0
for page in "$source_folder"/docs/guide/*.md; do
    pages=$((pages + 1))
    if grep -q '^openssl ' "$page" && ! command -v openssl >/dev/null; then
        echo "not tested, because openssl is not installed: $page"
        continue
    fi
    folder=$(basename "$page" .md)
    mkdir "$folder"
    awk '/^```sh$/ { on = 1; next } /^```/ { on = 0 } on' "$page" >"$folder.sh"
    checks=$((checks + 1))
    [ -s "$folder.sh" ] || fail "$page contains no command"
    while IFS= read -r line; do
        expected=$(printf '%s\n' "$line" | sed -n 's/.*# status \([0-9]\)$/\1/p')
        commands=$((commands + 1))
        checks=$((checks + 1))
        (cd "$folder" && sh -c "$line") >out 2>err </dev/null
        status=$?
        [ $status -eq "${expected:-0}" ] || fail "$page: $line: status $status: $(tail -n 1 err)"
    done <"$folder.sh"
done
check "pages of the guide" "$pages" 8
checks=$((checks + 1))
[ $commands -ge 20 ] || fail "only $commands commands were run"
finish
