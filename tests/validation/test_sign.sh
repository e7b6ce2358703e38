#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Tests signatures of bundles: they are made by osteon sign and osteon validate --sign, and
# verified by osteon verify --trust and, independently, by openssl. An envelope that is broken,
# too large, or of another bundle or key must be reported in one line.
# Covers: REQ-SIGN
. "${srcdir:-.}/tests/app/lib.sh"
command -v openssl >/dev/null || { echo "skipped: openssl is not installed"; exit 77; }
python=$(command -v python3) || { echo "skipped: python3 is not installed"; exit 77; }

openssl genpkey -algorithm ed25519 -out tester.key 2>/dev/null
openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out reviewer.key 2>/dev/null
openssl genpkey -algorithm ed25519 -out stranger.key 2>/dev/null
openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-384 -out p384.key 2>/dev/null
mkdir trusted
for who in tester reviewer; do openssl pkey -in $who.key -pubout -out trusted/$who.pem; done
openssl pkey -in stranger.key -pubout -out stranger.pem
openssl pkey -in p384.key -pubout -out p384.pem
openssl pkey -in tester.key -aes128 -passout pass:open -out locked.key
echo open >passphrase
echo shut >wrong

one='cpu:isa=scalar,threads=1'
run 0 validate --only import/0 --backends "$one" --out b --sign tester.key --quiet
run 0 verify b
grep -q "signatures were not checked" out || fail "verify without --trust does not state that signatures were not checked: $(cat out)"
run 0 verify b --trust trusted --json
check "signatures_checked" "$(value signatures_checked)" true
check "meaning of the first signature" "$(value signatures.0.meaning)" "performed as the protocol says"
check "key of the first signature" "$(value signatures.0.keys.0)" "$(openssl pkey -in tester.key -pubout -outform DER | sha256sum | cut -d' ' -f1)"

# A reviewer also signs, with an encrypted key of the other type.
sleep 1
run 0 sign b --key reviewer.key --by "A. Reviewer" --meaning "reviewed and accepted"
sleep 1
run 0 sign b --key locked.key --passphrase-file passphrase --meaning "archived"
run 0 verify b --trust trusted/tester.pem --trust trusted/reviewer.pem --json
check "signer of the second signature" "$(value signatures.1.by)" "A. Reviewer"
check "meaning of the third signature" "$(value signatures.2.meaning)" archived
refuse 2 "locked.key: is encrypted, and the passphrase in wrong does not decrypt it" sign b --key locked.key --passphrase-file wrong --meaning x
: >empty
refuse 2 "empty: the first line is empty; expected the passphrase of locked.key" sign b --key locked.key --passphrase-file empty --meaning x
# Without a terminal, there must be no prompt.
refuse 2 "locked.key: is encrypted; pass --passphrase-file FILE" sign b --key locked.key --meaning x </dev/null
refuse 2 "not an Ed25519 or ECDSA P-256 key" sign b --key p384.key --meaning x
refuse 2 "not a private key in PEM; expected Ed25519 or ECDSA P-256" sign b --key trusted/tester.pem --meaning x
refuse 2 "no public key" verify b --trust tester.key
refuse 2 "not an Ed25519 or ECDSA P-256 key" verify b --trust p384.pem
openssl genpkey -algorithm RSA -pkeyopt rsa_keygen_bits:1024 2>/dev/null | openssl pkey -pubout -out rsa.pem
refuse 2 "not an Ed25519 or ECDSA P-256 key" verify b --trust rsa.pem
openssl req -x509 -key tester.key -days 1 -subj "/CN=a tester" -out certificate.pem 2>/dev/null
refuse 2 "is a certificate" verify b --trust certificate.pem
mkdir none
refuse 2 "no public key (*.pem) in this folder" verify b --trust none
refuse 2 "No such file" verify b --trust nowhere.pem
refuse 2 "--timestamp-ca needs --trust" verify b --timestamp-ca trusted/tester.pem
refuse 2 "--sign needs --out" validate --sign tester.key
refuse 2 "--meaning: contains a control character" sign b --key tester.key --meaning "$(printf 'two\nlines')"
refuse 2 "--by: contains a control character" sign b --key tester.key --meaning x --by "$(printf 'a\tb')"
refuse 2 "--by: is too long; expected one printable line of UTF-8 of at most 200 bytes" sign b --key tester.key --meaning x --by "$(printf '%0201d' 0)"

# A changed bundle must not be signed, and the output must state this.
cp -r b changed
echo >>changed/results.json
run 1 sign changed --key tester.key --meaning x
checks=$((checks + 1))
grep -q "^changed: not signed, because" out || fail "sign does not state that the bundle was not signed: $(cat out)"
if grep -rl "PRIVATE KEY" b; then fail "the bundle contains a private key"; fi

# The digest of the bundle must be the same with and without signatures.
run 0 validate --only import/0 --backends "$one" --out plain --quiet
check "results_root with and without signatures" "$("$json_get" results_root <b/manifest.json)" "$("$json_get" results_root <plain/manifest.json)"
run 1 verify plain --trust trusted
grep -q "signatures/ has no signature" out || fail "the output does not state that there is no signature: $(cat out)"

# Verifies the signature independently: the test computes the PAE (pre-authentication encoding), and
# openssl verifies the signature.
"$python" - b trusted <<'PY' || fail "openssl refuses a signature over the PAE of the specification"
import base64, glob, hashlib, json, subprocess, sys
bundle, keys = sys.argv[1:]
assert b"DSSEv1 29 http://example.com/HelloWorld 11 hello world" == b"DSSEv1 %d %s %d %s" % (29, b"http://example.com/HelloWorld", 11, b"hello world")
envelopes = sorted(glob.glob(bundle + "/signatures/*.intoto.jsonl"))
assert len(envelopes) == 3
for name, key in zip(envelopes, ("tester", "reviewer", "tester")):
    text = open(name, "rb").read()
    assert text.endswith(b"\n") and text.count(b"\n") == 1
    envelope = json.loads(text)
    kind, body = envelope["payloadType"].encode(), base64.b64decode(envelope["payload"], validate=True)
    open("pae", "wb").write(b"DSSEv1 %d %s %d %s" % (len(kind), kind, len(body), body))
    open("sig", "wb").write(base64.b64decode(envelope["signatures"][0]["sig"], validate=True))
    command = (["openssl", "dgst", "-sha256", "-verify", f"{keys}/{key}.pem", "-signature", "sig", "pae"] if key == "reviewer" else
               ["openssl", "pkeyutl", "-verify", "-pubin", "-inkey", f"{keys}/{key}.pem", "-rawin", "-in", "pae", "-sigfile", "sig"])
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    statement = json.loads(body)
    digest = lambda file: hashlib.sha256(open(f"{bundle}/{file}", "rb").read()).hexdigest()
    assert statement["_type"] == "https://in-toto.io/Statement/v1"
    assert statement["predicateType"] == "https://in-toto.io/attestation/test-result/v0.1"
    assert statement["subject"][0]["name"] == "manifest.json" and statement["subject"][0]["digest"] == {"sha256": digest("manifest.json")}
    assert statement["subject"][0]["annotations"]["results_root"] == json.load(open(bundle + "/manifest.json"))["results_root"]
    predicate = statement["predicate"]
    assert predicate["result"] == "WARNED", "equal, but one case alone is no evidence"
    assert predicate["configuration"] == [{"name": "protocol.json", "digest": {"sha256": digest("protocol.json")}}]
    assert predicate["passedTests"] == ["import/0 on cpu:isa=scalar,threads=1"] and predicate["failedTests"] == []
PY

# ---------------------------------------------------------------- forgeries
# check_forgery TEXT: checks that bundle x, with the trusted keys, gives status 1 and a line that
# contains TEXT
check_forgery() {
    run 1 verify x --trust trusted
    check "lines about signatures for: $1" "$(grep -c '^  signatures' out)" 1
    grep -qF -- "$1" out || fail "the output '$(cat out)' does not contain '$1'"
}
sign_copy() {
    rm -rf x
    cp -r plain x
    run 0 sign x --key tester.key --meaning "performed"
    envelope=$(ls x/signatures/*.intoto.jsonl)
}
# edit EXPRESSION: changes the envelope e (p: its payload, s: its first signature)
edit() {
    "$python" - "$envelope" "$1" <<'PY'
import base64, json, sys
name, how = sys.argv[1:]
e = json.load(open(name))
p, s = json.loads(base64.b64decode(e["payload"])), e["signatures"][0]
pack = lambda o: base64.b64encode(json.dumps(o).encode()).decode()
exec(how)
open(name, "w").write(json.dumps(e))
PY
}
sign_copy
run 0 verify x --trust trusted
edit 'e["payload"] = e["payload"].replace("+", "-").replace("/", "_"); s["keyid"] = "somebody"; e["more"] = 1'
run 0 verify x --trust trusted # DSSE allows URL-safe base64, a wrong key hint and an unknown field
edit 'del s["keyid"]'
run 0 verify x --trust trusted
sign_copy; edit 'p["subject"][0]["digest"]["sha256"] = "0" * 64; e["payload"] = pack(p)'; check_forgery "wrong signature: the key that it names did not sign this"
sign_copy; edit 'p["predicate"]["result"] = "PASSED"; e["payload"] = pack(p); s["keyid"] = ""'; check_forgery "by a key that is not trusted"
sign_copy; edit 's["sig"] = s["sig"][:-4] + "AAA="'; check_forgery "signature"
sign_copy; edit 's["sig"] = s["sig"][:-1]'; check_forgery "not base64"
sign_copy; edit 's["sig"] = "*" + s["sig"][1:]'; check_forgery "not base64"
sign_copy; edit 's["sig"] = ""'; check_forgery "wrong signature"
sign_copy; edit 's["sig"] = 7'; check_forgery "not {keyid, sig}"
sign_copy; edit 'e["payload"] = "\n" + e["payload"]'; check_forgery "not base64"
sign_copy; edit 'e["payloadType"] = "application/json"'; check_forgery "payloadType"
sign_copy; edit 'e["signatures"] = []'; check_forgery "no signature, or more than 16"
sign_copy; edit 'e["signatures"] = [s] * 17'; check_forgery "no signature, or more than 16"
sign_copy; edit 'e["signatures"] = [s, s]'; check_forgery "two signatures by one key"
sign_copy; edit 'e["signatures"] = [s, {"sig": "AAAA"}]'; check_forgery "by a key that is not trusted"
sign_copy; edit 'del e["payload"]'; check_forgery "lacks payload"
sign_copy; echo '{"payload": "", "payload": "", "payloadType": "x", "signatures": []}' >"$envelope"; check_forgery "not one JSON object"
sign_copy; "$python" -c 'print("[" * 100000)' >"$envelope"; check_forgery "not one JSON object"
sign_copy; : >"$envelope"; check_forgery "not one JSON object"
sign_copy; cat "$envelope" "$envelope" >two; mv two "$envelope"; check_forgery "not one JSON object"
sign_copy; truncate -s 17M "$envelope"; check_forgery "larger than a signature can be"
sign_copy; rm "$envelope"; mkfifo "$envelope"; check_forgery "not a regular file"
sign_copy; mv "$envelope" e; ln -s "$PWD/e" "$envelope"; check_forgery "not a regular file"
sign_copy; echo hello >x/signatures/note.txt; check_forgery "neither an envelope"
sign_copy; echo hello >x/signatures/note.intoto.jsonl.tsr; check_forgery "neither an envelope"
sign_copy; mkdir x/signatures/more; check_forgery "neither an envelope"
sign_copy; mv x/signatures y; ln -s "$PWD/y" x/signatures; check_forgery "is not a folder"
rm -rf x y; cp -r b x
run 1 verify x --trust trusted/reviewer.pem
check "number of signatures by a key that is not trusted" "$(grep -c 'by a key that is not trusted' out)" 2
run 1 verify x --trust stranger.pem
# Tests a valid signature by a trusted key that belongs to another bundle.
run 0 validate --only import/1 --backends "$one" --out other --sign tester.key --quiet
sign_copy; rm "$envelope"; cp other/signatures/* x/signatures/; check_forgery "about another bundle"
# The contents of the envelope must be compared even without --trust.
run 1 verify x
grep -q "about another bundle" out || fail "verify without --trust does not report the envelope of another bundle: $(cat out)"
# osteon sign must refuse a changed bundle and a bundle with broken signatures.
rm -rf x; cp -r plain x; echo >>x/README.md
run 1 sign x --key tester.key --meaning performed
[ ! -e x/signatures ] || fail "a changed bundle was signed"
sign_copy; echo hello >x/signatures/note.txt
run 1 sign x --key tester.key --meaning performed

# ------------------------------------------------------------- time stamps
cat >tsa.cnf <<'CNF'
[tsa]
default_tsa = one
[one]
serial = serial
crypto_device = builtin
default_policy = 1.2.3.4.1
digests = sha256
signer_digest = sha256
accuracy = secs:1
ordering = yes
tsa_name = no
ess_cert_id_chain = no
ess_cert_id_alg = sha256
[ext]
extendedKeyUsage = critical,timeStamping
CNF
echo 01 >serial
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout ca.key -out ca.pem -days 2 -subj "/CN=a root" 2>/dev/null
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout no.key -out no.pem -days 2 -subj "/CN=another root" 2>/dev/null
openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout tsa.key -out tsa.csr -subj "/CN=a time stamp" 2>/dev/null
openssl x509 -req -in tsa.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile tsa.cnf -extensions ext -out tsa.pem 2>/dev/null
# stamp FILE: makes the authority's response for FILE
stamp() {
    openssl ts -query -data "$1" -sha256 -cert -out query.tsq 2>/dev/null
    openssl ts -reply -config tsa.cnf -queryfile query.tsq -signer tsa.pem -inkey tsa.key -out "$1.tsr" 2>/dev/null || fail "openssl ts made no response"
}
sign_copy
run 1 verify x --trust trusted --timestamp-ca ca.pem
grep -q "has no time stamp" out || fail "the output does not state that there is no time stamp: $(cat out)"
stamp "$envelope"
run 0 verify x --trust trusted --json
check "time stamp without a trusted authority: stamped, time_stamp" "$(value signatures.0.stamped) '$(value signatures.0.time_stamp)'" "true ''"
run 0 verify x --trust trusted --timestamp-ca ca.pem --json
case $(value signatures.0.time_stamp) in
20??-??-??T??:??:??Z) ;;
*) fail "wrong time of the time stamp: $(value signatures.0.time_stamp)" ;;
esac
run 1 verify x --trust trusted --timestamp-ca no.pem
grep -q "no time stamp of this envelope" out || fail "verify accepts a time stamp of another authority: $(cat out)"
refuse 2 "no certificate" verify x --trust trusted --timestamp-ca tester.key
cp "$envelope.tsr" of_another.tsr
sign_copy
edit 'e["more"] = 1' # the signature is valid, but the time stamp was made for other bytes
cp of_another.tsr "$envelope.tsr"
run 1 verify x --trust trusted --timestamp-ca ca.pem
grep -q "no time stamp of this envelope" out || fail "verify accepts the time stamp of another envelope: $(cat out)"
echo hello >"$envelope.tsr"
run 1 verify x --trust trusted --timestamp-ca ca.pem
grep -q "no response of a time-stamping authority" out || fail "verify accepts a file that is not a response of an authority: $(cat out)"

# -------------------------------------------------- in-toto's own tools
"$python" -c "import securesystemslib.dsse, in_toto_attestation.v1.statement" 2>/dev/null || { echo "not tested, because securesystemslib or in-toto-attestation is not installed: the tools of in-toto"; finish; }
"$python" - b trusted <<'PY' || fail "in-toto's own tools refuse the envelopes"
import glob, json, sys
from cryptography.hazmat.primitives.serialization import load_pem_public_key
from google.protobuf import json_format
from in_toto_attestation.v1.statement import Statement
import in_toto_attestation.v1.statement_pb2 as pb
from securesystemslib.dsse import Envelope
from securesystemslib.signer import SSlibKey
bundle, keys = sys.argv[1:]
for name, key in zip(sorted(glob.glob(bundle + "/signatures/*.intoto.jsonl")), ("tester", "reviewer", "tester")):
    e = json.load(open(name))
    keyid = e["signatures"][0]["keyid"] # from_dict removes this field
    envelope = Envelope.from_dict(e)
    trusted = SSlibKey.from_crypto(load_pem_public_key(open(f"{keys}/{key}.pem", "rb").read()), keyid=keyid)
    envelope.verify([trusted], 1)
    statement = json_format.Parse(envelope.payload, pb.Statement())
    Statement.copy_from_pb(statement).validate()
PY
finish
