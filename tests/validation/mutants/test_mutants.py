#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the generator of mutants and their measurement, on snippets and on a toy program.

    snippet --> exactly the mutants computed by hand
    toy program with three mutants --> one has identical code, one is killed by its trace, one survives

Covers: REQ-MUTANTS
"""
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
SOURCE = os.environ.get("top_srcdir", os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
sys.path.insert(0, os.path.join(SOURCE, "validation/mutants"))
import build as building  # noqa: E402
import measure  # noqa: E402
import operators  # noqa: E402
import scope  # noqa: E402
import table  # noqa: E402
import trial  # noqa: E402


def changes(text, *names, file="src/core/a.c"):
    """Returns the lines into which the mutants of some operators change a one-line source."""
    return sorted(operators.applied(text, m) for m in operators.mutants_of(file, text) if m.operator in names)


def read(file):
    with open(os.path.join(SOURCE, file), newline="", encoding="utf-8") as f:
        return f.read()


class Generator(unittest.TestCase):
    def test_bounds(self):
        self.assertEqual(changes("a = b < c;", "bound"), ["a = b <= c;"])
        self.assertEqual(changes("a = b >= c;", "bound"), ["a = b > c;"])

    def test_masks_and_shifts(self):
        self.assertEqual(changes("a = b & 0x38;", "mask"), ["a = b & 0x18;", "a = b & 0x39;", "a = b & 0x78;"])
        self.assertEqual(changes("a = b >> 3;", "shift"), ["a = b >> 2;", "a = b >> 4;"])

    def test_widths(self):
        self.assertEqual(changes("a = (int64_t)b;", "width"), ["a = (int32_t)b;", "a = 0x1ffffffffff & (int64_t)b;"])
        self.assertEqual(changes("a = (uint16_t)b;", "width", "signedness"), ["a = (int16_t)b;", "a = (uint8_t)b;"])
        self.assertEqual(changes("size_t a;", "width", file="src/cl/kernels/a.cl"), ["uint a;", "ushort a;"])

    def test_axes_and_order(self):
        self.assertEqual(changes("a = p.x;", "axis"), ["a = p.y;"])
        self.assertEqual(changes("a[1] = 3;", "axis"), ["a[2] = 3;"])
        self.assertEqual(changes("f(a, b + 1, c);", "order"), [])
        self.assertEqual(changes("f(a, b);", "order"), ["f(b, a);"])

    def test_intrinsics(self):
        self.assertEqual(changes("m = _mm256_cmpgt_epi16(a, b);", "intrinsic", "order"),
                         ["m = _mm256_cmpeq_epi16(a, b);", "m = _mm256_cmpgt_epi16(b, a);", "m = _mm256_cmpgt_epu16(a, b);"])
        self.assertEqual(changes("m = _mm256_permute4x64_epi64(a, 2);", "lane"),
                         [f"m = _mm256_permute4x64_epi64(a, {n});" for n in (0, 3)])

    def test_barriers_and_clears(self):
        self.assertEqual(changes("barrier(CLK_LOCAL_MEM_FENCE);", "barrier"), ["(void)0;"])
        self.assertEqual(changes("atomic_add(&p[i], n);", "barrier"), ["(*(&p[i]) += (n));"])
        self.assertEqual(changes("uint sum = 0;", "clear"), ["uint sum ;"])
        self.assertEqual(changes("#pragma omp critical\na++;", "barrier"), ["\na++;"])

    def test_statements_and_conditions(self):
        self.assertEqual(changes("void f(void) { int a = 1; a += 2; g(a); }", "statement"),
                         ["void f(void) { int a = 1; ; g(a); }", "void f(void) { int a = 1; a += 2; ; }"])
        self.assertEqual(changes("if (a) b = 1;", "negation"), ["if (!(a)) b = 1;"])
        self.assertEqual(changes("a = b < c ? b : c;", "branches"), ["a = b < c ? c : b;"])

    def test_last_iteration(self):
        self.assertEqual(changes("for (int i = 0; i < n; i++) f(i);", "last"), ["for (int i = 0; i + 1 < n; i++) f(i);"])

    def test_text_without_mutants(self):
        for text in ("/* a < b */", "// a < 3\n", 'char *s = "a < 3";', "#if A < 3\n#endif\n", "assert(a < 3);", "_Static_assert(2 < 3, \"\");",
                     '#include <a.h>\n'):
            self.assertEqual([m for m in operators.mutants_of("src/core/a.c", text)], [], text)

    def test_bodies_of_macros(self):
        self.assertEqual(changes("#define F(a) ((a) >> 4)\n", "shift"), ["#define F(a) ((a) >> 3)\n", "#define F(a) ((a) >> 5)\n"])

    def test_identifiers_are_stable(self):
        one = {m.id: m.text for m in operators.mutants_of("src/core/a.c", "int a;\nb = c < 3;\n")}
        two = {m.id: m.text for m in operators.mutants_of("src/core/a.c", "/* more */\nint z;\nint a;\n   b = c < 3;\n")}
        self.assertTrue(one and set(one) <= set(two))
        self.assertEqual(len(operators.mutants_of("src/core/a.c", "b = c < 3;\nb = c < 3;\n")), 2 * len(operators.mutants_of("src/core/a.c", "b = c < 3;\n")))

    def test_sample(self):
        mutants = [m for f in scope.files(SOURCE)[:6] for m in operators.mutants_of(f, read(f))]
        self.assertEqual(operators.sample(mutants, 80, 5)[:40], operators.sample(mutants, 40, 5))
        self.assertNotEqual(operators.sample(mutants, 40, 5), operators.sample(mutants, 40, 6))
        self.assertEqual(len({m.id for m in mutants}), len(mutants))

    def test_backends_of_files(self):
        """The mutants of a file that no known backend runs would count as survived. Each file that is built must have one."""
        lists = (["ref", "cpu:isa=scalar,threads=1", "cpu:isa=scalar,threads=2", "cpu:isa=avx2,threads=1", "cpu:isa=avx2,threads=2", "cpu:isa=avx512,threads=2",
                  "cpu:voxelizer=embree,threads=2", "cl:platform=0,device=0"],
                 ["ref", "dense", "cpu:isa=scalar,threads=1", "cpu:isa=scalar,threads=2,grain=1", "cpu:isa=avx2,threads=3,grain=1", "cpu:isa=avx512,threads=1",
                  "cpu:isa=avx512,threads=7,grain=1", "cpu:threads=3", "cpu:voxelizer=embree,threads=2", "cl:platform=0,device=0,kernels=gpu"])
        for available in lists:
            for file in scope.files(SOURCE):
                if file in scope.OUTSIDE or "/arm/" in file or file.endswith("_cpu.cl"):
                    continue
                found = scope.subjects(file, available)
                self.assertTrue(found, file)
                self.assertLessEqual(set(found), set(available))

    def test_backends_of_survivors(self):
        """The result "survived" applies to a tier, so no backend of the tier that runs the file may be omitted."""
        cpu = ["cpu:isa=scalar,threads=1", "cpu:isa=scalar,threads=2,grain=1", "cpu:isa=avx2,threads=1", "cpu:isa=avx2,threads=3,grain=1",
               "cpu:isa=avx512,threads=7,grain=1", "cpu:isa=avx512vbmi,threads=1", "cpu:threads=3", "cpu:voxelizer=embree,threads=2"]
        cl = ["cl:platform=0,device=0,kernels=cpu", "cl:platform=0,device=0,kernels=gpu,staging=65536"]
        available = ["ref", "dense", *cpu, *cl]
        for file, found in (("src/cpu/remove/shape.c", cpu), ("src/cpu/x86/remove_avx2.c", cpu[2:]), ("src/cpu/x86/remove_avx512.c", cpu[4:]),
                            ("src/cpu/import/scalar.c", cpu), ("src/cpu/ref/remove.c", ["ref"]), ("src/cl/remove.c", cl),
                            ("src/cl/kernels/remove.cl", cl), ("src/cl/kernels/remove_cpu.cl", cl[:1]), ("src/cpu/arm/remove_neon.c", [])):
            subjects = scope.subjects(file, available)
            self.assertEqual(sorted(subjects), sorted(found), file)
        self.assertIn("grain=1", scope.subjects("src/cpu/remove/shape.c", available)[0])
        self.assertEqual(scope.subjects("src/cpu/x86/remove_avx2.c", available)[0], "cpu:isa=avx2,threads=3,grain=1")

    def test_order_of_families(self):
        """The family that detects the most mutants per second must run first."""
        campaign = trial.Campaign("none", tempfile.mkdtemp(prefix="osteon-mutants-"), trial.Limits(), ["case"], ["slow", "quick", "useless"])
        self.addCleanup(shutil.rmtree, campaign.work)
        campaign.tried = {"slow": [9, 90.0], "quick": [3, 5.0], "useless": [1, 50.0]}
        self.assertEqual(campaign.order(), ["quick", "slow", "useless"])

    def test_stages(self):
        names = trial.stage_names(SOURCE)
        self.assertEqual((names[0], names[1], names[-1]), ("case", "rect", "end"))
        self.assertIn("failed", names)
        families = trial.family_names(SOURCE)
        self.assertLessEqual({"import", "mesh", "poses", "sweep", "session", "operation", "steps", "reach"}, set(families))
        self.assertNotIn("static", families)

    def test_foreign_mutant(self):
        m = operators.from_file("src/core/a.c", "a = b + c;\n", "a = b - c;\n", {})
        self.assertEqual((m.at, m.old, m.new), (6, "+", "-"))
        self.assertIsNone(operators.from_file("src/core/a.c", "a;\n", "a;\n", {}))

    def test_every_source(self):
        for file in scope.files(SOURCE)[::7]:
            text = read(file)
            for m in operators.mutants_of(file, text)[::50]:
                self.assertNotEqual(operators.applied(text, m), text, m)


TOY = """
static int scaled(int v) { return v * 3 + 1; }
static int unused_half(int v) { return v & 7; }
int toy_value(int v);
int toy_value(int v) { return v > 100 ? unused_half(v) : scaled(v); }
"""
# The source of a worker with one case. The trace of the worker contains a record of stage `case`, a
# record of stage `rect` with the values, and the end record.
MAIN = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
int toy_value(int v);
static void put(FILE *to, uint32_t stage, const int *values, uint64_t bytes)
{
    const uint32_t head[3] = {stage, 0, 0};
    const uint64_t sizes[2] = {bytes, 0};
    fwrite("OSTR", 1, 4, to), fwrite(head, 1, 12, to), fwrite(sizes, 1, 16, to), fwrite(values, 1, bytes, to);
}
int main(int argc, char **argv)
{
    int values[20];
    FILE *to = fopen(argv[argc - 1], "wb");
    for (int i = 0; i < 20; i++) values[i] = toy_value(i);
    put(to, 0, values, 4), put(to, 1, values, sizeof values), put(to, STAGE_END, &argc, sizeof argc);
    return fclose(to);
}
"""


class OnToyProgram(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="osteon-mutants-")
        self.addCleanup(shutil.rmtree, self.folder)
        compiler = os.environ.get("CC", "cc").split()
        tree = os.path.join(self.folder, "tree")
        for name, text in (("src/cpu/ref/toy.c", TOY), ("src/main.c", MAIN)):
            os.makedirs(os.path.dirname(os.path.join(tree, name)), exist_ok=True)
            with open(os.path.join(tree, name), "w", encoding="utf-8") as f:
                f.write(text)
        made = os.path.join(tree, "build")
        os.makedirs(os.path.join(made, "src/cpu/ref"))
        log = []
        for name in ("cpu/ref/toy", "main"):
            words = [*compiler, "-O2", f"-DSTAGE_END={trial.stage_names(SOURCE).index('end')}", "-MD", "-MF", f"src/{name}.Po", "-c", f"../src/{name}.c", "-o", f"src/{name}.o"]
            log.append("libtool: compile:  " + " ".join(words))
            subprocess.run(words, cwd=made, check=True)
        subprocess.run(["ar", "cr", "libtoy.a", "src/cpu/ref/toy.o"], cwd=made, check=True)
        words = [*compiler, "-o", "osteon", "src/main.o", "libtoy.a"]
        log.append("libtool: link: " + " ".join(words))
        subprocess.run(words, cwd=made, check=True)
        with open(os.path.join(made, "build.log"), "w", encoding="utf-8") as f:
            f.write("\n".join(log) + "\n")
        self.build = building.Build(made, os.path.join(self.folder, "objects"), linker="")
        campaign = trial.Campaign(os.path.join(made, "osteon"), os.path.join(self.folder, "baseline"), trial.Limits(2048),
                                  trial.stage_names(SOURCE), families=["import"])
        campaign.lists["smoke"] = ["ref"]
        self.one = measure.Measurement(self.build, campaign, ["smoke"])

    def outcome(self, old, new, line):
        found = [m for m in operators.mutants_of("src/cpu/ref/toy.c", TOY) if (m.old, m.new) == (old, new) and line in m.text]
        self.assertEqual(len(found), 1, (old, new))
        return self.one.measure(found[0], os.path.join(self.folder, "job"))

    def test_outcomes(self):
        killed = self.outcome("3", "4", "scaled(int v) {")
        self.assertEqual((killed["outcome"], killed["by"], killed["stage"], killed["how"]), ("killed by smoke", "import/0", "rect", "differs"))
        self.assertEqual(self.outcome("7", "15", "unused_half(int v) {")["outcome"], "survived")
        self.assertEqual(self.outcome("100", "101", "toy_value(int v) {")["outcome"], "survived")
        self.assertEqual(self.outcome(">", ">=", "toy_value(int v) {")["outcome"], "survived")
        # No value is greater than this one, so the compiler removes the code after the test and
        # the object code is identical.
        text = TOY.replace("v > 100", "v > 0x7fffffff")
        with open(os.path.join(self.build.source, "src/cpu/ref/toy.c"), "w", encoding="utf-8") as f:
            f.write(text)
        shutil.rmtree(os.path.join(self.folder, "objects/unmutated"))
        os.makedirs(os.path.join(self.folder, "objects/unmutated"))
        dead = [m for m in operators.mutants_of("src/cpu/ref/toy.c", text) if m.old == "7"][0]
        self.assertEqual(self.one.measure(dead, os.path.join(self.folder, "job"))["outcome"], "identical")
        broken = dead._replace(new="(")
        self.assertEqual(self.one.measure(broken, os.path.join(self.folder, "job"))["outcome"], "not compiled")

    def test_endless_loop_and_crash(self):
        body = "return v * 3 + 1;"
        at = TOY.index(body)
        self.one.campaign.limits.least_s = 1
        for new, how in (("for (volatile int i = 0;; i++) ; return 0;", "time"), ("__builtin_trap(); return 0;", "crash")):
            m = operators.Mutant("x", "src/cpu/ref/toy.c", 2, "statement", at, body, new, "")
            row = self.one.measure(m, os.path.join(self.folder, "job"))
            self.assertEqual(row["outcome"], "killed by smoke")
            self.assertIn(how, row["how"])


class Table(unittest.TestCase):
    def test_counts_and_interval(self):
        low, high = table.interval(50, 100)
        self.assertAlmostEqual(low, 0.4038, places=3)
        self.assertAlmostEqual(high, 0.5962, places=3)
        row = {"id": "1", "file": "src/core/a.c", "line": "1", "operator": "bound", "old": "<", "new": "<=", "text": "a", "how": "", "by": "", "tiers": "smoke"}
        rows = [{**row, "outcome": o, "how": h, "id": str(i)} for i, (o, h) in enumerate(
            [("identical", ""), ("killed by smoke", "differs"), ("killed by smoke", "crash: SIGSEGV"), ("survived", ""), ("survived", ""), ("not compiled", "")])]
        known = {"3": {"id": "3", "kind": "equivalent", "text": "a", "reason": "r"}, "4": {"id": "4", "kind": "equivalent", "text": "another line", "reason": "r"}}
        made = table.count_file("src/core/a.c", 9, rows, known)
        self.assertEqual([made[c] for c in ("drawn", "not compiled", "identical", "differing", "equivalent", "smoke", "by crash or time", "survived")],
                         [6, 1, 1, 4, 1, 2, 1, 1])

    def test_last_row_is_used(self):
        """If a survivor is run again by name, its row must have the seed of its sample and the new outcome."""
        path = os.path.join(tempfile.mkdtemp(prefix="osteon-mutants-"), "r.csv")
        self.addCleanup(shutil.rmtree, os.path.dirname(path))
        with open(path, "w", newline="", encoding="utf-8") as f:
            out = csv.DictWriter(f, ["id", "outcome", "tiers", "seed"])
            out.writeheader()
            out.writerows([{"id": "1", "outcome": "survived", "tiers": "smoke", "seed": "7"},
                           {"id": "1", "outcome": "killed by standard", "tiers": "standard", "seed": ""}])
        row = table.read([path])["1"]
        self.assertEqual((row["outcome"], row["tiers"], row["seed"]), ("killed by standard", "smoke+standard", "7"))

    def test_thresholds_and_missing_reasons(self):
        row = {"file": "src/core/a.c", "line": "1", "operator": "bound", "old": "<", "new": "<=", "text": "a", "how": "", "by": "", "tiers": "smoke"}
        rows = {str(i): {**row, "id": str(i), "outcome": o} for i, o in enumerate(["killed by smoke"] * 60 + ["survived"] * 40)}
        files = [table.count_file("src/core/a.c", 100, list(rows.values()), {})]
        self.assertEqual(table.judge(files, rows, {}, 69, False), [])  # the upper limit of the interval is 69.1 %
        self.assertEqual(len(table.judge(files, rows, {}, 70, False)), 1)
        self.assertEqual(len(table.judge(files, rows, {}, 0, True)), 40)
        known = {str(i): {"id": str(i), "kind": kind, "text": "a", "reason": "r"} for i, kind in
                 zip(range(60, 100), ["equivalent"] * 10 + ["no result"] * 10 + ["open"] * 20)}
        files = [table.count_file("src/core/a.c", 100, list(rows.values()), known)]
        self.assertEqual([files[0][c] for c in ("differing", "equivalent", "no result", "smoke", "survived")], [100, 10, 10, 60, 20])
        self.assertEqual(table.judge(files, rows, known, 80, True), [])  # 60 of 80: the upper limit is 83 %
        self.assertEqual(len(table.judge(files, {}, {}, 0, False)), 0)
        self.assertEqual(len(table.judge([], {}, {}, 0, False)), 1)

    def test_survivors_of_release_have_reasons(self):
        path = os.path.join(SOURCE, "docs/qualification/mutants.md")
        if not os.path.exists(path):
            self.skipTest("no table")
        self.assertNotIn("not examined", read("docs/qualification/mutants.md"))

    def test_rows_of_reasons(self):
        path = os.path.join(SOURCE, "docs/qualification/mutants-equivalent.csv")
        if not os.path.exists(path):
            self.skipTest("no reasons")
        with open(path, newline="", encoding="utf-8") as f:
            for row in csv.DictReader(f):
                self.assertIn(row["kind"], (*table.KINDS, "open"), row)
                self.assertTrue(row["reason"] and row["text"], row)


if __name__ == "__main__":
    unittest.main()
