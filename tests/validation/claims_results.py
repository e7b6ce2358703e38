# SPDX-License-Identifier: Apache-2.0
"""Rules of check_claims.py for what a bundle's page states about results: the verdict, the comparison of the backends, the
user's files, pictures, differences and the margins of differing decisions."""
import re
import shlex

from claims_bundle import (BAD, backends_of, commas, expect, findings_of, many, own_words, refused, rule,
                           same, verdict_of, words)
from claims_page import WrongClaim


@rule("", "title|h1", r"Backend equivalence verification report")
def _(c, b, m):
    return []


@rule("", "div", r"✓ EQUALEvery backend's results are byte-identical to the reference's: ([\d,]+) results?, (0) differing bytes\. From results\.json")
def _(c, b, m):
    r = c.file(b, "results.json")
    same(b, "EQUAL", r["verdict"])
    same(b, True, r["evidence"])
    return expect(r["results"]["equal"], sum(r["results"][k] for k in BAD))


@rule("", "div", r"⚠ REDUCED RUN: NO EVIDENCE ?Equal in (?:all|the) ([\d,]+) results? that (?:was|were) compared; too little was compared for evidence\. From results\.json")
def _(c, b, m):
    r = c.file(b, "results.json")
    same(b, "EQUAL", r["verdict"])
    same(b, False, r["evidence"])
    same(b, 0, sum(r["results"][k] for k in BAD))
    return expect(r["results"]["equal"])


@rule("", "div", r"⚠ NO VERDICT: NOTHING WAS COMPARED ?No backend other than the reference ran a case that the reference accepted\. From results\.json")
def _(c, b, m):
    same(b, (0, "NOT COMPARED"), tuple(c.file(b, "results.json")[k] for k in ("compared", "verdict")))
    return []


@rule("", "div", r"✗ NOT EQUAL ?In ([\d,]+) of ([\d,]+) results?, the result of a backend differs from the reference's\.(?: ?The other (backend is equal in all its cases|[\d,]+ backends are equal in all their cases)\.)?"
                 r"( This was also a reduced run\.)? From results\.json(?: and cases\.jsonl)?")
def _(c, b, m):
    r, cases, protocol = c.file(b, "results.json"), c.file(b, "cases.jsonl"), c.bundle.parsed("protocol.json")
    bad = sum(r["results"][k] for k in BAD)
    same(b, "NOT EQUAL", r["verdict"])
    others = 0
    for backend in backends_of(protocol)[1:]:
        verdicts = [verdict_of(case, backend["name"]) for case in cases]
        others += "equal" in verdicts and not any(v in BAD for v in verdicts)
    said = None if not others else "backend is equal in all its cases" if others == 1 else "%s are equal in all their cases" % many(others, "backend")
    return expect(bad, bad + r["results"]["equal"]) + [said, None if r["evidence"] else " This was also a reduced run."]


@rule("", "li", r"(.*): ([\d,]+) of ([\d,]+) cases?")
def _(c, b, m):
    box = next(x for x in c.section.blocks if x.tag == "div")
    cases, protocol = c.file(box, "cases.jsonl"), c.bundle.parsed("protocol.json")
    for backend in backends_of(protocol)[1:]:
        verdicts = [verdict_of(case, backend["name"]) for case in cases]
        bad, good = sum(v in BAD for v in verdicts), verdicts.count("equal")
        if bad and [backend["what"]] + expect(bad, bad + good) == list(m.groups()):
            return list(m.groups())
    raise WrongClaim("%s: names no backend of cases.jsonl" % b)


@rule("", "li", r"Sensitivity: ([\d,]+) of ([\d,]+) deliberate mistakes, made in a second implementation and in no backend, were detected; "
                r"of (\d+) kinds (\d+) changed nothing in this tier; ([\d,]+) false alarms? \(sensitivity\.json\)\.")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    silent = [k["name"] for k in s["kinds"] if not k["changed"]]
    same(b, s["kinds_silent"], silent)
    return expect(s["detected"], s["changed"]) + [str(len(s["kinds"])), str(len(silent))] + expect(s["false_alarms"])


@rule("", "li", r"Mistakes that all backends could have in common: the reference passed ([\d,]+) of ([\d,]+) checks by hand, by volume and by law \(common\.json\)\.")
def _(c, b, m):
    passed = [x["passed"] for x in c.file(b, "common.json")["checks"]]
    return expect(sum(passed), len(passed))


@rule("", "li", r"Limits: ([\d,]+) points are not shown; they are listed below \(deviations\.csv\)\.")
def _(c, b, m):
    return expect(len(c.file(b, "deviations.csv")))


@rule("", "p", r"osteon simulates the reaming of bone for surgery\. .* for ([\d,]+ backends?) on ([\d,]+ cases?), against the scalar reference\. osteon (\S+), arithmetic version (\d+); tier (\w+), seed (\d+) "
               r"\(protocol\.json\)\. The times are in times\.json; the log of all steps is audit\.log\.")
def _(c, b, m):
    p = c.file(b, "protocol.json")
    for name in ("times.json", "audit.log"):
        c.file(b, name)
    ran = sum(x["available"] for x in backends_of(p)[1:])
    return [many(ran, "backend"), many(len(c.bundle.parsed("cases.jsonl")), "case"), p["version"], str(p["arithmetic"]), p["tier"], p["seed"]]


def table_of(backend, cases, first):
    def cell(some):
        if first:
            return str(len(some))
        equal = sum(verdict_of(x, backend["name"]) == "equal" and not refused(x) for x in some)
        bad = sum(verdict_of(x, backend["name"]) not in ("equal", "not run") for x in some)
        return "%d of %d" % (equal, len(some)) + (" %d NOT equal" % bad if bad else "")
    return cell


@rule("Comparison of the backends", "tr", r"")
def _(c, b, m):
    protocol, cases = c.file(b, "protocol.json"), c.file(b, "cases.jsonl")
    families = c.bundle.once("families", lambda: sorted({x["id"].split("/")[0] for x in cases}))
    if b.cells[0] == "Backend, device, driver":
        same(b, set(b.cells[1:-1]), set(families))
        same(b, b.cells[-1], "all cases")
        c.columns = b.cells[1:-1]
        return None
    s = next((i for i, x in enumerate(backends_of(protocol)) if b.cells[0] == words("%s %s" % (x["what"], x["name"]))), None)
    if s is None:
        raise WrongClaim("%s: names no backend of protocol.json" % b)
    one = backends_of(protocol)[s]
    if not one["available"]:
        same(b, b.cells[1:], [words("not run: " + one["reason"])])
        return None
    cell = table_of(one, cases, s == 0)
    groups = [[x for x in cases if x["id"].split("/")[0] == f] for f in c.columns] + [cases]
    same(b, b.cells[1:], [cell(g) for g in groups])
    return None


@rule("Comparison of the backends", "p", r"(import|mesh|poses|sweep|session|operation|static|small|user): .*\.")
def _(c, b, m):
    for part in b.text[:-1].split("; "):
        name, about = part.split(": ", 1)
        same(b, about, words(c.file(b, "protocol.json")["families"][name]))
    return None


@rule("Comparison of the backends", "p", r"Criterion for passing, fixed before anything ran: (.*)")
def _(c, b, m):
    frozen = c.bundle.once("frozen", lambda: __import__("hashlib").sha256(c.bundle.raw("protocol.json")).hexdigest())
    log = c.file(b, "audit.log").decode().splitlines()
    places = {line.split("\t")[2]: (i, line) for i, line in enumerate(log)}
    same(b, places["protocol frozen"][1].split("\t")[3], frozen)
    same(b, True, places["protocol frozen"][0] < min(places[k][0] for k in places if k in ("results", "merged")))
    return [words(c.file(b, "protocol.json")["accept"])]


@rule("The user's own files", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "File":
        return None
    f = c.file(b, "protocol.json")["user"]["files"][int(b.cells[0]) - 1]
    kind = "CT" if f["option"] == "ct" else f["option"]
    if "builtin" in f:
        same(b, b.cells[1:], [kind, "-", "built in: " + f["builtin"]])
        return None
    same(b, b.cells[1:], [kind, commas(f["bytes"]), f["sha256"]])
    same(b, True, any(r["sha256"] == f["sha256"] and int(r["bytes"] or 0) == f["bytes"] for r in c.file(b, "inputs.csv")))
    return None


@rule("The user's own files", "li", r"(user/\d+): .*")
def _(c, b, m):
    one = next(x for x in c.file(b, "protocol.json")["user"]["cases"] if x["id"] == m.group(1))
    text = one["id"] + ": "
    if "ct" in one:
        text += "CT %d of %s voxels at %s mm, resampled to %s cubes of %s mm; " % (
            one["ct"], " × ".join(map(str, one["rect_dims"])), " × ".join(one["rect_spacing_mm"]), " × ".join(map(str, one["cubic_dims"])), one["cubic_mm"])
    same(b, b.text, text + many(one["ticks"], "tick") + " of movement")
    return None


@rule("Not shown", "li", r"(.*)")
def _(c, b, m):
    left = [words(x["what was not shown"]) for x in c.file(b, "deviations.csv")]
    same(b, True, m.group(1) in left)
    same(b, [x.text for x in c.section.blocks if x.tag == "li"], left)
    return None


@rule("Pictures", "p", r"Case (operation/0) as the reference computed it: .*")
def _(c, b, m):
    return [next(x["id"] for x in c.file(b, "cases.jsonl") if x["id"] == "operation/0" and x["reference"])]


@rule("Results of the reference", "p", r"([\d,]+ cases?) gave ([\d,]+ records?)\. Each record is compared with that of every backend, in the order of the table; cases\.jsonl contains the SHA-256 digests\.")
def _(c, b, m):
    cases = c.file(b, "cases.jsonl")
    return [many(len(cases), "case"), many(sum(len(x["reference"]) for x in cases), "record")]


@rule("Results of the reference", "tr", r"")
def _(c, b, m):
    cases = c.file(b, "cases.jsonl")
    stages = c.bundle.once("stages", lambda: [r["stage"] for x in cases for r in x["reference"]])
    if b.cells[0] == "Stage":
        same(b, {x.cells[0] for x in c.section.blocks if x.tag == "tr"} - {"Stage"}, set(stages))
        return None
    same(b, b.cells[1], commas(stages.count(b.cells[0])))
    return None


@rule("Differences", "p", r"None\. All compared results are byte-identical to the reference's\.")
def _(c, b, m):
    same(b, [], c.file(b, "anomalies.csv"))
    return []


@rule("Differences", "p", r"([\d,]+) results? differs? from the reference's\. .*")
def _(c, b, m):
    return expect(len(c.file(b, "anomalies.csv")))


@rule("Differences", "p", r"The first (\d+) of (\d+) are listed here\.")
def _(c, b, m):
    return [str(sum(x.tag == "tr" for x in c.section.blocks) - 1), str(len(c.file(b, "anomalies.csv")))]


def where_of(r):
    return r.get("stage", "") + (" %d" % r["item"] if r.get("stage") in ("tick", "collide", "tool") else "")


def what_of(r):
    text = r.get("text", "")
    if "voxel" in r:
        n, size = r["different_voxels"], r.get("chunk_size", 32)
        text = "%s in this record; the first at (%d, %d, %d), chunk (%d, %d, %d) of %d3: %d, the reference has %d" % (
            (many(n, "voxel"),) + tuple(r["voxel"]) + tuple(v // size for v in r["voxel"]) + (size, r["got"], r["reference"]))
    elif "word" in r:
        text = "reported: %s is %d, the reference has %d" % (r["word"], r["got"], r["reference"])
        if "chunk" in r:
            text += "; of chunk (%d, %d, %d) first" % tuple(r["chunk"])
    return text + (" Class %s: %s%s" % (r["class"], r["class_text"], "; " + r["class_hint"] if r["class_hint"] else "") if "class" in r else "")


@rule("Differences", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "No.":
        return None
    protocol, cases = c.bundle.parsed("protocol.json"), c.file(b, "cases.jsonl")
    n, case, s, r = findings_of(protocol, cases)[int(b.cells[0][1:]) - 1]
    same(b, b.cells, ["A%d" % n, "%s %s" % (case["id"], backends_of(protocol)[s]["what"]), r["verdict"], where_of(r), words(what_of(r))])
    same(b, c.file(b, "anomalies.csv")[n - 1]["case"], case["id"])
    return None


ONE_BY_ONE = "Each difference"


@rule(ONE_BY_ONE, "h3", r"A(\d+): (.*)")
def _(c, b, m):
    protocol, cases = c.bundle.parsed("protocol.json"), c.file(b, "cases.jsonl")
    c.finding = findings_of(protocol, cases)[int(m.group(1)) - 1]
    n, case, s, _ = c.finding
    return [str(n), "%s, %s" % (case["id"], backends_of(protocol)[s]["what"])]


@rule(ONE_BY_ONE, "p", r"The reduced case still differs in the same stage and with the same class: (.*) \((cases/\S+\.json)\)\. In the folder of this page:")
def _(c, b, m):
    n, case, s, r = c.finding
    same(b, c.file(b, r["reproduce"])["id"], case["id"])
    return [c.file(b, "cases.jsonl") and words(r["small_case"]), r["reproduce"]]


@rule(ONE_BY_ONE, "pre", r"osteon validate --case (\S+) --backends (\S+|'[^']*')(.*)")
def _(c, b, m):
    n, case, s, r = c.finding
    protocol = c.bundle.parsed("protocol.json")
    said = shlex.split(m.group(0))
    same(b, said[3:6], [r["reproduce"], "--backends", backends_of(protocol)[s]["name"]])
    same(b, said[6:], own_words(protocol) if case["id"].startswith("user/") else [])
    return None


@rule(ONE_BY_ONE, "p", r"Operands that decide voxel \((\d+), (\d+), (\d+)\), computed by the reference\. .*")
def _(c, b, m):
    c.file(b, "cases.jsonl")
    c.operands = iter(c.finding[3]["operands"])
    return [str(v) for v in c.finding[3]["voxel"]]


@rule(ONE_BY_ONE, "tr", r"")
def _(c, b, m):
    one = next(c.operands)
    same(b, b.cells, [words(one["name"]), words(one["value"])])
    return None


@rule(ONE_BY_ONE, "figcaption", r"(Reference: axial, coronal, sagittal|Backend|Difference) (\S+)")
def _(c, b, m):
    n, case, s, r = c.finding
    role = {"R": "reference", "B": "got", "D": "difference"}[m.group(1)[0]]
    same(b, b.links, ["pictures/%s-backend-%d-%s.png" % (re.sub("[^a-z0-9]", "-", case["id"]), s, role)])
    return [m.group(1)] + b.links


@rule(ONE_BY_ONE, "p", r"There are pictures of (\d+) of them and reduced cases of (\d+): .*")
def _(c, b, m):
    results = [r for _, _, _, r in findings_of(c.bundle.parsed("protocol.json"), c.bundle.parsed("cases.jsonl"))]
    return [str(sum(n.endswith("-difference.png") for n in c.bundle.names())), str(sum("reproduce" in r for r in results))]


MARGINS = "Margins of differing decisions"
MARGIN_KEYS = ["voxels", "inherited", "below_threshold", "unexplained", "decided"]


def margin_rows(c, b, what):
    names = {x["what"]: x["name"] for x in backends_of(c.bundle.parsed("protocol.json"))}
    return [r for r in c.file(b, "margins.csv") if r["backend"] == names[what]]


def margin_bins(row):
    return [int(v) for k, v in row.items() if k == "at_0" or k == "more" or k.startswith("below_") and k != "below_threshold"]


@rule(MARGINS, "h3", r"(.*)")
def _(c, b, m):
    c.rows = margin_rows(c, b, m.group(1))
    same(b, True, bool(c.rows))
    return None


@rule(MARGINS, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Stage":
        c.header = b
        return None
    rows = [r for r in c.rows if r["stage"] == b.cells[0]]
    same(b, b.cells[1:6], [commas(sum(int(r[k]) for r in rows)) for k in MARGIN_KEYS])
    most = max(int(r["max_2_20"]) for r in rows)
    decided = sum(int(r["decided"]) for r in rows)
    unit = rows[0]["unit"].split(" ", 1)[1]
    same(b, b.cells[6], "%d.%07d of a %s" % (most >> 20, (most & 0xfffff) * 10000000 >> 20, unit) if decided else "-")
    bins = [sum(x) for x in zip(*[margin_bins(r) for r in rows])] if decided else []
    same(b, b.cells[7].split(), " ".join(many(n, "voxel").replace(",", "") for n in bins if n).split())
    return None


@rule(MARGINS, "p", r"(?:For ([\d,]+) of these voxels, no border explains the other backend's value, so the difference is not only rounding\. ?)?"
                    r"(?:([\d,]+) of these decisions lay farther than 1/1024 of a voxel from the nearest border that could explain them, so the difference is not only rounding\. ?)?"
                    r"(?:([\d,]+) voxels were not measured, because there are too many\. ?)?"
                    r"(?:Decisions within 1/1024 of a voxel of a border: ([\d,]+), which are all measured decisions\. This is consistent with rounding at borders only but does not prove it: "
                    r"another mistake can also have its effect at borders, and the greatest margin is a bound for these cases only\.)?")
def _(c, b, m):
    c.file(b, "margins.csv")
    total = {k: sum(int(r[k]) for r in c.rows) for k in MARGIN_KEYS + ["unmeasured"]}
    near = sum(sum(margin_bins(r)[:11]) for r in c.rows)
    other, far = total["unexplained"] + total["below_threshold"], total["decided"] - near
    only = not other and not total["unmeasured"] and total["decided"] and not far
    return [commas(n) if n else None for n in (other, far, total["unmeasured"])] + [commas(total["decided"]) if only else None]
