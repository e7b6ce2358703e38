#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests the files of a bundle other than the comparison: requirements traced in both directions,
# tools and libraries as present on the machine, a bill of materials in the form of SPDX 2.3,
# checks for common mistakes, and a signature over the manifest.
# Covers: REQ-RECORD, REQ-TRACE
. "${srcdir:-.}/tests/app/lib.sh"

run 0 validate --only import/ --backends 'cpu:isa=scalar,threads=1' --out b --json
check "checks of common mistakes that failed" "$(value common_mistakes.failed)" 0
checks=$((checks + 1))
[ "$(value common_mistakes.passed)" -ge 20 ] || fail "$(value common_mistakes.passed) checks of common mistakes passed, expected at least 20"
run 0 verify b

# The table in the bundle must equal that of the source tree, including the tests that no requirement names.
"$source_folder/docs/check-requirements" --table "$source_folder" >table
checks=$((checks + 1))
cmp -s table b/requirements.csv || fail "requirements.csv differs from the output of check-requirements --table"
check "requirements traced" "$(grep -c '^requirement,\|^orphan requirement,' b/trace.csv)" "$(sed 1d table | grep -c '^[^,]')"
check "requirements without a test" "$(grep -c '^orphan requirement,' b/trace.csv)" "$(grep -c ',planned: ' table)"
check "tests without a requirement" "$(grep -c '^orphan test,' b/trace.csv)" "$(grep -c '^,,,' table)"
checks=$((checks + 1))
grep '^requirement,"AR-CUB-2",' b/trace.csv | grep -q '"stage cubic; check layers-linear","cubic: [1-9][0-9]* records equal; layers-linear: passed","cases.jsonl common.json"$' ||
    fail "AR-CUB-2 is not traced to its stage and check: $(grep AR-CUB-2 b/trace.csv)"

# The digests must be those of the files.
check "the program's SHA-256" "$("$json_get" program.sha256 <b/tools.json)" "$(sha256sum <"$osteon" | cut -d' ' -f1)"
"$json_get" libraries <b/tools.json >/dev/null || fail "tools.json contains no libraries"
sed -n 's/^ *"file": "\(.*\)",$/\1/p' b/tools.json >files
sed -n 's/^ *"sha256": "\(.*\)",$/\1/p' b/tools.json | head -n "$(wc -l <files)" >digests
checks=$((checks + 1))
paste -d' ' digests files | sed 's/ /  /' | sha256sum --quiet -c - >out 2>&1 || fail "the digests of libraries differ from those in tools.json: $(head -n 3 out)"
# Each library that the dynamic loader maps for the command must be listed.
if command -v ldd >/dev/null; then
    checks=$((checks + 1))
    ldd "$osteon" 2>/dev/null | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p' | while read -r file; do
        grep -qxF "$file" files || echo "$file"
    done >absent
    [ ! -s absent ] || fail "loaded libraries that are not in tools.json: $(tr '\n' ' ' <absent)"
fi
check "libraries in soup.csv" "$(grep -c '"linked"\|"loaded by another library' b/soup.csv)" "$(wc -l <files | tr -d ' ')"

if command -v python3 >/dev/null; then
    checks=$((checks + 1))
    python3 "$source_folder/tests/validation/spdx.py" b/sbom.spdx.json >out 2>&1 || fail "spdx.py reports problems in sbom.spdx.json: $(cat out)"
    # The format check must refuse a broken file.
    sed 's/"SPDX-2.3"/"SPDX-9"/' b/sbom.spdx.json >broken
    checks=$((checks + 1))
    ! python3 "$source_folder/tests/validation/spdx.py" broken >out 2>&1 || fail "spdx.py accepts a broken bill of materials"
else
    echo "not tested, because python3 is not installed: the form of sbom.spdx.json"
fi

# No field of the list may refer the reader to another document, and independent checkers must
# accept the bill of materials.
checks=$((checks + 2))
! grep -q 'see its package\|not known here' b/soup.csv || fail "soup.csv refers to another document: $(grep 'see its package\|not known here' b/soup.csv | head -n 2)"
! grep -q '"supplier": "NOASSERTION"' b/sbom.spdx.json || ! command -v dpkg-query >/dev/null || fail "number of packages without a supplier: $(grep -c '"supplier": "NOASSERTION"' b/sbom.spdx.json)"
if command -v ntia-checker >/dev/null; then
    checks=$((checks + 1))
    ntia-checker --file b/sbom.spdx.json >out 2>&1
    { grep -q 'Conformant: *True' out && ! grep -q floating out; } || fail "ntia-checker reports that sbom.spdx.json is not conformant: $(cat out)"
else
    echo "not tested, because ntia-checker is not installed: the minimum elements of sbom.spdx.json"
fi
if command -v pyspdxtools >/dev/null; then
    checks=$((checks + 1))
    pyspdxtools -i b/sbom.spdx.json >out 2>&1 || fail "pyspdxtools refuses sbom.spdx.json: $(cat out)"
else
    echo "not tested, because pyspdxtools is not installed: sbom.spdx.json"
fi

finish
