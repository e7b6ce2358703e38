# SPDX-License-Identifier: Apache-2.0
"""Rules of check_claims.py for what a bundle's page states about the evidence: the sensitivity proof, dates and machines,
code paths, changes since an older bundle, common mistakes, requirements, the test suite, and how the bundle was made."""
import csv
import io
import re
import shlex

from claims_bundle import backends_of, commas, expect, many, own_words, rule, same, words
from claims_page import WrongClaim


SENSITIVITY = "Sensitivity proof"
COUNTS = ["injected", "changed", "detected", "localized", "survived"]


@rule(SENSITIVITY, "p", r"The second implementation \(validation/dense\), which is no backend, was run with deliberate mistakes at random positions, and its results were compared in the same way\. ([\d,]+) of the ([\d,]+) mistakes that changed a result were detected and "
                        r"([\d,]+) located; ([\d,]+) false alarms in ([\d,]+) runs without a mistake\. (.*)")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    whole = s["proved"] and s["detected"] == s["changed"] == s["localized"] and not s["false_alarms"]
    return expect(s["detected"], s["changed"], s["localized"], s["false_alarms"], s["clean_runs"]) + [
        "Every mistake that had an effect was detected and located." if whole else "This does not show that mistakes are detected."]


@rule(SENSITIVITY, "tr", r"")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    if b.cells[0] in ("Mistakes in", "Mistake"):
        return None
    by_stage = re.fullmatch(r"(\w+), ([\d,]+ kinds?)", b.cells[0])
    if b.cells[0] == "all":
        rows = s["kinds"]
        same(b, b.cells[1:], [commas(s[k]) for k in COUNTS])
    elif by_stage:
        rows = [k for k in s["kinds"] if k["stage"] == by_stage.group(1)]
        same(b, by_stage.group(2), many(len(rows), "kind"))
    else:
        rows = [k for k in s["kinds"] if b.cells[0] == "%s (%s) %s" % (k["name"], k["stage"], k["what"])]
        same(b, len(rows), 1)
    same(b, b.cells[1:], [commas(sum(r[k] for r in rows)) for k in COUNTS])
    return None


@rule(SENSITIVITY, "label", r"Kind by kind: ([\d,]+ kinds?) of mistakes")
def _(c, b, m):
    return [many(len(c.file(b, "sensitivity.json")["kinds"]), "kind")]


@rule(SENSITIVITY, "p", r"Not all detected, or not all located:")
def _(c, b, m):
    same(b, True, any(not k["changed"] == k["detected"] == k["localized"] for k in c.file(b, "sensitivity.json")["kinds"]))
    return []


def machines_of(environment):
    return [("Machine", environment)] if isinstance(environment.get("machine"), str) else [("Machine of shard " + k, v) for k, v in sorted(environment.items())]


@rule("Date and machine", "tr", r"")
def _(c, b, m):
    head, said, source = b.cells
    same(b, b.links, [source])
    if head == "Begun":
        begun = c.bundle.raw(source).decode().split("\n")[0].split("\t")
        same(b, begun[2], "begun")
        same(b, said, begun[1].replace("T", " ").replace("Z", " UTC"))
        return None
    if head == "OpenCL":
        p = c.file(b, source)
        sets = [(x["what"], re.search(r"kernels=(\w+)", x["name"])) for x in backends_of(p)[1:] if x["name"].startswith("cl") and x["available"]]
        rows = [words(what if found and "kernels for" in what else "%s; kernels%s" % (what, " for %sPUs" % found.group(1)[0].upper() if found else ": the set that the device's type chooses"))
                for what, found in sets]
        same(b, said, " ".join(rows) or "no device was compared")
        return None
    machines = machines_of(c.file(b, source))
    if head == "Threads":
        shared = {int(n) for _, e in machines for x in e.get("paths", {}).values() for path, count in x["entered"].items() if count for n in re.findall(r" on (\d+) threads$", path)}
        text = "work was shared by %s threads, according to the backends' counters" % ", ".join(str(n) for n in sorted(shared))
        same(b, said, text if shared else "no backend counted work shared by threads")
    elif head == "Processor":
        same(b, True, said in [words("%s, %s" % (e["processor"] or "not reported by the system", many(e["cores_online"], "core"))) for _, e in machines])
    else:
        e = dict(machines)[head]
        same(b, said, words("%s%s, kernel %s, %s" % (e["host"] + ": " if e.get("host") else "", e["system"], e["kernel"], e["machine"])))
    return None


@rule("Code paths of each backend", "tr", r"")
def _(c, b, m):
    paths = c.file(b, "environment.json")["paths"]
    if b.cells[0] == "Backend":
        return None
    mine = paths[b.cells[0]]
    same(b, b.cells[1:], [str(len(mine["entered"])), str(len(mine["not_entered"])), words(", ".join(mine["not_entered"])) or "none"])
    return None


CHANGES = "Changes since an older bundle"


@rule(CHANGES, "p", r"([\d,]+ cases?) compared by the digests of the reference's results: ([\d,]+) different; ([\d,]+ cases?) not compared; ([\d,]+ verdicts?) of backends changed\. Conclusion: (.*)\.")
def _(c, b, m):
    i = c.file(b, "impact.json")
    r = i["results"]
    return [many(r["compared"], "case"), commas(len(r["differences"])), many(len(r["not_compared"]), "case"), many(len(i["verdicts"]), "verdict"), i["conclusion"]]


@rule(CHANGES, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Changed":
        return None
    i = c.file(b, "impact.json")
    rows = [[kind] + [words(x[k]) for k in ("what", "old", "new")] for kind, key in (("run", "causes"), ("library", "libraries"), ("device", "devices")) for x in i[key]]
    rows += [["requirement", x["what"], "absent" if x["old"] == "absent" else "present",
              "present" if x["old"] == "absent" else "absent" if x["new"] == "absent" else "another text or other tests"] for x in i["requirements"]]
    same(b, True, b.cells in rows)
    return None


COMMON = "Mistakes that all backends could have in common"
ABOUT = {"golden": "by hand", "volume": "by volume"}


@rule(COMMON, "p", r"If every backend made the same mistake, .* (All checks passed|Some checks failed)\. Passed by hand: (\d+) of (\d+); by volume: (\d+) of (\d+); by law: (\d+) of (\d+)\.")
def _(c, b, m):
    checks = c.file(b, "common.json")["checks"]
    sums = []
    for about in ("by hand", "by volume", "by law"):
        mine = [x["passed"] for x in checks if ABOUT.get(x["kind"], "by law") == about]
        sums += [str(sum(mine)), str(len(mine))]
    return ["All checks passed" if all(x["passed"] for x in checks) else "Some checks failed"] + sums


@rule(COMMON, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Check":
        return None
    rows = [[words(t) for t in ("%s %s" % (x["name"], ABOUT.get(x["kind"], "by law")), x["what"], x["expected"], x["got"], "✓" if x["passed"] else "✗ FAILED")]
            for x in c.file(b, "common.json")["checks"]]
    same(b, True, b.cells in rows)
    return None


@rule(COMMON, "p", r"Not part of this bundle, because these checks need the source tree and its tests \(make check\):")
def _(c, b, m):
    same(b, True, bool(c.file(b, "common.json")["by_the_tests"]))
    return []


@rule(COMMON, "li", r"(.*)")
def _(c, b, m):
    same(b, True, m.group(1) in ["%s (%s)" % (x["what"], x["tests"]) for x in c.file(b, "common.json")["by_the_tests"]])
    return None


@rule("Requirements", "p", r"Of (\d+) requirements, (\d+) have tests, and (\d+) of these are also supported by results in this bundle\. Orphans in both directions: "
                           r"(\d+) requirements without a test, (\d+) tests that no requirement names, (\d+) results that concern no requirement\.")
def _(c, b, m):
    rows = c.file(b, "trace.csv")
    kinds = [r["kind"] for r in rows]
    listed = [r for r in csv.DictReader(io.StringIO(c.file(b, "requirements.csv") and c.bundle.raw("requirements.csv").decode()))]
    tested, untested = kinds.count("requirement"), kinds.count("orphan requirement")
    same(b, tested + untested + kinds.count("orphan test"), len(listed))
    shown = sum(r["kind"] == "requirement" and bool(r["files"]) for r in rows)
    return [str(n) for n in (tested + untested, tested, shown, untested, kinds.count("orphan test"), kinds.count("orphan result"))]


@rule("", "div", r"✗ THE TEST SUITE FAILED ?([\d,]+ tests?) that requirements name failed; they are listed below\. From suite\.json")
def _(c, b, m):
    return [many(sum(t["result"] == "failed" for t in c.file(b, "suite.json")["tests"]), "test")]


@rule("The test suite", "p", r"The programs that requirements name as their tests were run with this campaign: ([\d,]+) passed, ([\d,]+) failed, ([\d,]+) were skipped\. .*")
def _(c, b, m):
    results = [t["result"] for t in c.file(b, "suite.json")["tests"]]
    return expect(*[results.count(r) for r in ("passed", "failed", "skipped")])


@rule("The test suite", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Test":
        return None
    rows = [[words(x) for x in (t["test"], "✗ FAILED" if t["result"] == "failed" else "skipped", t["reason"])]
            for t in c.file(b, "suite.json")["tests"] if t["result"] != "passed"]
    same(b, True, b.cells in rows)
    return None


@rule("Made with", "tr", r"")
def _(c, b, m):
    tools, devices = c.leaves(b, "tools.json"), c.leaves(b, "devices.json")
    if b.cells[0] in ("Source", "Compiler", "Flags", "Program, SHA-256"):
        build = c.file(b, "tools.json")
        expected = {"Source": "commit", "Compiler": "compiler", "Flags": "cflags"}
        same(b, b.cells[1], words(build["program"]["sha256"] if b.cells[0].startswith("Program") else build["build"][expected[b.cells[0]]]))
        return None
    if b.cells[0] == "Machines":
        same(b, "build" in c.file(b, "tools.json"), False)
        return None
    for one in c.file(b, "devices.json")["opencl"]["devices"]:
        version = one.get("driver_says", {}).get("CL_DEVICE_VERSION", "")
        says = (version + "; " if version else "") + (one.get("fingerprint") or one.get("reason", ""))
        if b.cells == [words(t) for t in ("%s %s" % (one.get("name") or one.get("platform"), one["backend"]), says)]:
            return None
    raise WrongClaim("%s: names no device of devices.json" % b)


@rule("Made with", "p", r"(\d+) libraries were loaded, drivers included\. .*")
def _(c, b, m):
    return [str(len(c.file(b, "tools.json").get("libraries", [])))]


@rule("Verification and repetition", "pre", r"osteon verify \.")
def _(c, b, m):
    return []


@rule("Verification and repetition", "pre", r"osteon validate (.*) --out BUNDLE")
def _(c, b, m):
    p = c.file(next(x for x in c.section.blocks if "protocol.json" in x.links), "protocol.json")
    said = ["--tier", p["tier"], "--seed", p["seed"]]
    said += ["--shard", "%d/%d" % tuple(p["shard"])] if p["shard"][1] > 1 else []
    said += ["--case", "case.json"] if "case" in p else []
    said += ["--only", p["only"]] if p["only"] else []
    said += ["--cpu-only"] if p["cpu_only"] else []
    said += ["--backends", p["chosen"]] if p["chosen"] else []
    same(b, shlex.split(m.group(1)), said + own_words(p) + (["--with-suite", "FOLDER"] if "suite" in p else []))
    return None


@rule("Files", "tr", r"")
def _(c, b, m):
    if b.cells[0] != "File":
        same(b, b.links, [b.cells[0]])
    return None
