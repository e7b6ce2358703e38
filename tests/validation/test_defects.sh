#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests the maintainers' own defects (tests/validation/defects): every patch must apply to the
# tree, contain a description, and have a row in docs/qualification/defects.md. With
# OST_TEST_LONG=1 each patch is tried. A defect that the table lists as noticed must be detected
# in that tier. A defect listed as unnoticed is printed if it is detected now. OST_TEST_ONLY=NAME
# selects the patches whose names begin with NAME.
# Covers: REQ-DEFECTS
. "${srcdir:-.}/tests/app/lib.sh"

command -v patch >/dev/null || { echo "skipped: no patch"; exit 77; }
table=$source_folder/docs/qualification/defects.md

for one in "$source_folder"/tests/validation/defects/*.patch; do
    name=$(basename "$one" .patch)
    checks=$((checks + 1))
    patch -p1 --dry-run -s -f -r - -d "$source_folder" -i "$one" >patch.out 2>&1 || fail "$name.patch does not apply: $(head -n 1 patch.out)"
    check "$name.patch: what it is" "$(sed -n '1s/^Defect: .*\.$/yes/p; 2s/^Kind: .*\.$/yes/p' "$one" | tr -d '\n')" yesyes
    check "$name: rows in defects.md" "$(grep -c "^| $name |" "$table")" 1
done
check "rows without a patch" "$(sed -n 's/^| \([a-z]*-[a-z-]*\) |.*/\1/p' "$table" | while read -r name; do
    [ -f "$source_folder/tests/validation/defects/$name.patch" ] || echo "$name"; done)" ""
check "at least twenty" "$([ "$(ls "$source_folder"/tests/validation/defects | grep -c 'patch$')" -ge 20 ] && echo yes)" yes
[ -n "${OST_TEST_LONG:-}" ] || finish

command -v python3 >/dev/null || { echo "skipped: python3 is not installed"; exit 77; }
for one in "$source_folder"/tests/validation/defects/"${OST_TEST_ONLY:-}"*.patch; do
    name=$(basename "$one" .patch)
    tier=$(awk -F' *[|] *' -v name="$name" '$2 == name { print $4 }' "$table") # smoke, standard, or "not"
    [ "$tier" = not ] && first=smoke || first=$tier
    "$source_folder/validation/try-patch" --build "$build" --tier "$first" --keep "$scratch" "$one" >out 2>err
    status=$?
    rm -rf "$scratch"/try-patch-*
    [ "$tier:$status" = not:0 ] && echo "$name is noticed now, but defects.md lists it as unnoticed: $(head -n 1 out)"
    [ "$tier" = not ] && [ $status -lt 2 ] && continue
    check "$name in tier $tier: $(cat out err | head -n 1)" $status 0
done
finish
