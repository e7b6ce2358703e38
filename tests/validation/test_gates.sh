#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Checks that docs/qualification/gates.md has a row for every gate of .ci/run and .ci/long and no
# other rows, and that docs/qualification/README.md has one row for each file of its folder.
root=${srcdir:-.}
ledger=$root/docs/qualification/gates.md
status=0

# gate_names FILE: prints the names after "gate" and "check". The name fuzz-${target##*/} is printed as
# fuzz-*.
gate_names() {
    sed -nE 's/^[[:blank:]]*(gate|check) "?([a-z][a-z-]*)(\$\{[^}]*\})?"? .*/\2\3/p' "$1" | sed 's/\$.*/*/' | sort -u
}

# listed_names PART: prints the first column of the section whose heading contains PART.
listed_names() {
    awk -v part="$1" '/^## / { on = index($0, part) > 0 } on && /^\| `/ { split($0, cell, "`"); print cell[2] }' "$ledger" | sort
}

for script in run long; do
    names=$(gate_names "$root/.ci/$script")
    [ "$(printf '%s\n' "$names" | wc -l)" -ge 5 ] || { echo ".ci/$script contains fewer than 5 gates"; status=1; }
    listed=$(listed_names ".ci/$script")
    for name in $(printf '%s\n%s\n' "$names" "$listed" | sort -u | sed 's/\*/STAR/'); do
        name=$(echo "$name" | sed 's/STAR/*/')
        printf '%s\n' "$names" | grep -qxF -- "$name" || { echo "$ledger: .ci/$script has no gate '$name'"; status=1; }
        [ "$(printf '%s\n' "$listed" | grep -cxF -- "$name")" -eq 1 ] || { echo "$ledger: .ci/$script's gate '$name' needs one row"; status=1; }
    done
done

index=$root/docs/qualification/README.md
count=0
for file in "$root"/docs/qualification/*; do
    name=${file##*/}
    count=$((count + 1))
    [ "$name" = README.md ] || [ "$(grep -cF "| [$name]($name) |" "$index")" -eq 1 ] || { echo "$index: $name needs one row"; status=1; }
done
[ "$count" -ge 15 ] || { echo "$root/docs/qualification has $count files, expected at least 15"; status=1; }
for name in $(sed -n 's/^| \[\([^]]*\)\].*/\1/p' "$index"); do
    [ -e "$root/docs/qualification/$name" ] || { echo "$index lists $name, which does not exist"; status=1; }
done
exit $status
