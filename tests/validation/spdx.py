# SPDX-License-Identifier: Apache-2.0
"""Checks that a file has the form of an SPDX 2.3 document in JSON.

The checks were written from the specification (clauses 6, 7, 10 and 11), independently
of the code that writes the file. They cover required fields, identifiers, licence
expressions, checksums, relationships whose ends must exist, and the number of
described elements, which must be one.

    python3 spdx.py FILE       prints one line per problem; status 1 if there is one
"""
import json
import re
import sys

LICENCES = {"Apache-2.0", "Artistic-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSD-4-Clause", "BSL-1.0", "CC0-1.0", "ISC", "Libpng", "MIT", "MPL-1.1", "MPL-2.0",
            "NCSA", "Python-2.0", "X11", "Zlib", "curl", "libtiff", "libpng-2.0", "GPL-1.0-or-later"} | {
    "%s-%s" % (name, which) for name in ("GPL-2.0", "GPL-3.0", "LGPL-2.0", "LGPL-2.1", "LGPL-3.0") for which in ("only", "or-later")}
EXCEPTIONS = {"GCC-exception-3.1", "LLVM-exception"}
RELATIONS = {"DESCRIBES", "DYNAMIC_LINK", "RUNTIME_DEPENDENCY_OF", "DEPENDS_ON", "CONTAINS"}


def licence(text, extracted):
    if text in ("NOASSERTION", "NONE"):
        return True
    if text.startswith("LicenseRef-"):
        return text in extracted
    for term in re.split(r" AND | OR ", text):
        name, _, exception = term.partition(" WITH ")
        if name not in LICENCES or (exception and exception not in EXCEPTIONS):
            return False
    return True


def problems(d):
    extracted = {x.get("licenseId") for x in d.get("hasExtractedLicensingInfos", [])}
    for key, form in {"spdxVersion": r"SPDX-2\.3", "dataLicense": r"CC0-1\.0", "SPDXID": r"SPDXRef-DOCUMENT", "name": r".+",
                      "documentNamespace": r"https?://[^#\s]+"}.items():
        if not re.fullmatch(form, str(d.get(key, ""))):
            yield "%s is %r" % (key, d.get(key))
    made = d.get("creationInfo", {})
    if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", made.get("created", "")):
        yield "created is %r" % made.get("created")
    if not made.get("creators") or not all(re.match(r"(Tool|Person|Organization): .+", c) for c in made["creators"]):
        yield "creators are %r" % made.get("creators")
    ids = {"SPDXRef-DOCUMENT"}
    for p in d.get("packages", []):
        who = p.get("name", "?")
        if not re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", p.get("SPDXID", "")) or p["SPDXID"] in ids:
            yield "%s: SPDXID %r is invalid or not unique" % (who, p.get("SPDXID"))
        ids.add(p.get("SPDXID"))
        for key in ("name", "downloadLocation"):
            if not p.get(key):
                yield "%s has no %s" % (who, key)
        for key in ("licenseConcluded", "licenseDeclared"):
            if not licence(p.get(key, ""), extracted):
                yield "%s: %s is %r" % (who, key, p.get(key))
        if p.get("filesAnalyzed") is not False:
            yield "%s: filesAnalyzed is not false" % who
        if p.get("supplier") != "NOASSERTION" and not re.match(r"(Person|Organization): .+", p.get("supplier", "Organization: it is optional")):
            yield "%s: supplier is %r" % (who, p.get("supplier"))
        for c in p.get("checksums", []):
            if c.get("algorithm") != "SHA256" or not re.fullmatch("[0-9a-f]{64}", c.get("checksumValue", "")):
                yield "%s: checksum %r is invalid" % (who, c)
        for r in p.get("externalRefs", []):
            if r.get("referenceCategory") != "PACKAGE-MANAGER" or r.get("referenceType") != "purl" or \
                    not re.fullmatch(r"pkg:[a-z]+/[a-z0-9._-]+/[a-z0-9.+-]+@[A-Za-z0-9.~%_-]+", r.get("referenceLocator", "")):
                yield "%s: external reference %r is invalid" % (who, r)
    described = 0
    for r in d.get("relationships", []):
        described += r.get("relationshipType") == "DESCRIBES" and r.get("spdxElementId") == "SPDXRef-DOCUMENT"
        if r.get("relationshipType") not in RELATIONS or r.get("spdxElementId") not in ids or r.get("relatedSpdxElement") not in ids:
            yield "relationship %r has an unknown type or an end that does not exist" % r
    if described != 1:
        yield "the document describes %d elements, expected 1" % described
    related = {x for r in d.get("relationships", []) for x in (r.get("spdxElementId"), r.get("relatedSpdxElement"))}
    for lost in sorted(ids - related):
        yield "%s is not in any relationship" % lost


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        found = list(problems(json.load(file)))
    print("\n".join(found))
    sys.exit(1 if found else 0)
