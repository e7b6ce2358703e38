# SPDX-License-Identifier: Apache-2.0
"""Operators that make mutants. An operator simulates a mistake of programmers in kernels by replacing tokens.

Each operator is a function that takes a source (Source) and yields
(offset, length, replacement). The function's name is the operator's name.
"""
import hashlib
import os
import random
import re
from typing import NamedTuple

from lex import match, tokens


class Mutant(NamedTuple):
    id: str           # stable, because it does not depend on other lines
    file: str
    line: int
    operator: str
    at: int           # offset in the file, in bytes
    old: str
    new: str
    text: str         # the changed line, without blanks at its ends


class Source:
    """A source with its tokens, and the relations between them that operators need."""

    def __init__(self, text, opencl=False):
        self.text, self.opencl = text, opencl
        self.t = tokens(text)
        self.names = {t.text for t in self.t if t.kind == "name"}
        self.inside = self._calls()

    def word(self, i):
        return self.t[i].text if 0 <= i < len(self.t) else ""

    def kind(self, i):
        return self.t[i].kind if 0 <= i < len(self.t) else ""

    def binary(self, i):
        """Returns true if the operator at index i has an operand before it."""
        before = self.t[i - 1] if i else None
        if before is None or before.text in ("return", "case", "else", "do", "sizeof"):
            return False
        if before.text == ")":
            return not self.cast_before(i)
        return before.kind in ("name", "number") or before.text == "]"

    def pointer(self, i):
        """Returns true if the * at index i declares a pointer, which means that no blank follows it."""
        return self.word(i) == "*" and not self.text[self.t[i].at + 1:self.t[i].at + 2].isspace()

    def cast_before(self, i):
        """Returns true if the tokens before index i are a cast: a type in parentheses."""
        return self.word(i - 3) == "(" and bool(re.fullmatch(r"\w+_t|u?(int|long|short|char)\d*|unsigned|float|double|__m\d+i?|ost_i128", self.word(i - 2)))

    def _calls(self):
        """Computes for each token the call of which it is a direct argument: the index of the call's name, or None."""
        inside, stack = [], []
        for i, t in enumerate(self.t):
            inside.append(stack[-1] if stack else None)
            if t.text == "(":
                stack.append(i - 1 if i and self.t[i - 1].kind == "name" else None)
            elif t.text in ("[", "{"):
                stack.append(None)
            elif t.text in (")", "]", "}") and stack:
                stack.pop()
        return inside

    def arguments(self, i):
        """Returns the arguments of the call whose name is at index i, as (first, last) indices; None if it is not a call."""
        if self.word(i + 1) != "(":
            return None
        end = match(self.t, i + 1)
        if end is None or any(t.at < 0 for t in self.t[i:end]):
            return None
        out, depth, first = [], 0, i + 2
        for k in range(i + 2, end):
            depth += self.word(k) in "([{"
            depth -= self.word(k) in ")]}"
            if depth == 0 and self.word(k) == ",":
                out.append((first, k - 1))
                first = k + 1
        if first <= end - 1:
            out.append((first, end - 1))
        return out

    def span(self, first, last):
        """Returns offset and length of tokens first to last."""
        begin = self.t[first].at
        return begin, self.t[last].at + len(self.t[last].text) - begin

    def part(self, first, last):
        at, length = self.span(first, last)
        return self.text[at:at + length]

    def swap(self, a, b):
        """Returns the replacement that exchanges two ranges of tokens; a is before b."""
        at, length = self.span(a[0], b[1])
        between = self.text[self.t[a[1]].at + len(self.t[a[1]].text):self.t[b[0]].at]
        return at, length, self.part(*b) + between + self.part(*a)

    def statements(self):
        """Yields the ranges (first, last) of expression statements, including the semicolon."""
        first = 0
        for i, t in enumerate(self.t):
            if t.text == ";" and first <= i and all(x.at >= 0 for x in self.t[first:i + 1]):
                yield first, i
            if t.text in (";", "{", "}", ":") or (t.text == ")" and self._of_control(i)) or t.text in ("else", "do"):
                first = i + 1

    def _of_control(self, i):
        depth = 0
        for k in range(i, -1, -1):
            depth += self.word(k) == ")"
            depth -= self.word(k) == "("
            if depth == 0:
                return self.word(k - 1) in ("if", "while", "for")
        return False


def whole(s, i, new):
    return s.t[i].at, len(s.t[i].text), new


def replaced(name, table):
    """Returns an operator that replaces one operator token by another."""
    def run(s):
        for i, t in enumerate(s.t):
            if t.kind == "op" and t.text in table and (t.text not in "+-*&" or s.binary(i)) and not s.pointer(i):
                for new in table[t.text]:
                    yield whole(s, i, new)
    run.__name__ = name
    return run


bound = replaced("bound", {"<": ["<="], "<=": ["<"], ">": [">="], ">=": [">"]})
compare = replaced("compare", {"==": ["!="], "!=": ["=="]})
sign = replaced("sign", {"+": ["-"], "-": ["+"], "+=": ["-="], "-=": ["+="], "++": ["--"], "--": ["++"]})
bits = replaced("bits", {"&": ["|"], "|": ["&"], "^": ["|"], "&=": ["|="], "|=": ["&=", "="], "^=": ["|="], "<<": [">>"], ">>": ["<<"]})
logic = replaced("logic", {"&&": ["||"], "||": ["&&"]})
divide = replaced("divide", {"/": ["%"], "%": ["/"], "*": ["+"]})


def negation(s):
    for i, t in enumerate(s.t):
        if t.text in ("if", "while") and s.word(i + 1) == "(":
            end = match(s.t, i + 1)
            if end is not None and end > i + 2 and all(x.at >= 0 for x in s.t[i:end]):
                at, length = s.span(i + 1, end)
                yield at, length, "(!" + s.text[at:at + length] + ")"
        elif t.text in ("!", "~"):
            yield whole(s, i, "")


def branches(s):
    """Exchanges the two results of ?:, so that a minimum becomes a maximum."""
    for i, t in enumerate(s.t):
        if t.text != "?" or t.at < 0:
            continue
        depth, inner, middle, end = 0, 0, None, None
        for k in range(i + 1, len(s.t)):
            word = s.word(k)
            if depth == 0 and word == "?":
                inner += 1
            elif depth == 0 and word == ":" and middle is None:
                if inner:
                    inner -= 1
                else:
                    middle = k
            elif depth == 0 and word in (",", ";", ")", "]", "}", ":", "?"):
                end = k
                break
            depth += word in "([{"
            depth -= word in ")]}"
        if middle is not None and end is not None and inner == 0 and i + 1 < middle < end - 1:
            yield s.swap((i + 1, middle - 1), (middle + 1, end - 1))


def _value(word):
    found = re.fullmatch(r"(0[xX][0-9a-fA-F]+|[0-9]+)([uUlL]*)", word)
    if not found:
        return None
    digits = found.group(1)
    return int(digits, 16 if digits[:2] in ("0x", "0X") else 10), digits[:2].lower() == "0x", found.group(2)


def _written(value, in_hex, suffix):
    return (f"0x{value:x}" if in_hex else str(value)) + suffix


def _is_intrinsic(word):
    return bool(re.match(r"_mm\d*_|v[a-z]+[a-z0-9]*_\w*[suf](8|16|32|64)$", word))


def _is_mask(s, i, value):
    return value[1] or s.word(i - 1) in ("&", "|", "^", "&=", "|=", "^=") or s.word(i + 1) in ("&", "|", "^")


def constant(s):
    for i, t in enumerate(s.t):
        value = _value(t.text) if t.kind == "number" else None
        if value is None or s.word(i - 1) in ("<<", ">>", "[") or _is_mask(s, i, value):
            continue
        for number in (value[0] + 1, value[0] - 1):
            if number >= 0:
                yield whole(s, i, _written(number, *value[1:]))


def mask(s):
    for i, t in enumerate(s.t):
        value = _value(t.text) if t.kind == "number" else None
        if value is None or s.word(i - 1) in ("<<", ">>", "[") or not _is_mask(s, i, value):
            continue
        n, high = value[0], 1 << max(value[0].bit_length() - 1, 0)
        for number in sorted({n ^ 1, n ^ high, n | high << 1} - {n}):
            yield whole(s, i, _written(number, *value[1:]))


def shift(s):
    for i, t in enumerate(s.t):
        if s.word(i - 1) not in ("<<", ">>", "<<=", ">>="):
            continue
        value = _value(t.text) if t.kind == "number" else None
        if value:
            for number in (value[0] + 1, value[0] - 1):
                if number >= 0:
                    yield whole(s, i, _written(number, *value[1:]))
        elif t.kind == "name" and s.word(i + 1) not in ("(", "[", ".", "->"):
            yield whole(s, i, f"({t.text} + 1)")
            yield whole(s, i, f"({t.text} - 1)")


NARROWER = {
    "int64_t": ["int32_t"], "uint64_t": ["uint32_t"], "ost_i128": ["int64_t"], "size_t": ["uint32_t", "uint16_t"],
    "int32_t": ["int16_t"], "uint32_t": ["uint16_t"], "int16_t": ["int8_t"], "uint16_t": ["uint8_t"],
    "ulong": ["uint"], "long": ["int"], "uint": ["ushort"], "ushort": ["uchar"], "short": ["char"],
}
OTHER_SIGN = {
    "int64_t": "uint64_t", "uint64_t": "int64_t", "int32_t": "uint32_t", "uint32_t": "int32_t", "int16_t": "uint16_t",
    "uint16_t": "int16_t", "int8_t": "uint8_t", "uint8_t": "int8_t", "ulong": "long", "long": "ulong", "uint": "int",
    "ushort": "short", "short": "ushort", "uchar": "char", "char": "uchar",
}


def _is_type(s, i):
    """Returns true if the type at index i is that of a value (in a cast, a local or a member) and not of a pointer."""
    return s.word(i + 1) == ")" or s.kind(i + 1) == "name"


def width(s):
    """Makes a value or a cast too narrow. A 64-bit cast is cut to 41 bits, as if half of a multiplication were lost."""
    for i, t in enumerate(s.t):
        if t.kind == "name" and t.text in NARROWER and _is_type(s, i):
            for new in ["uint", "ushort"] if s.opencl and t.text == "size_t" else NARROWER[t.text]:
                yield whole(s, i, new)
        if t.kind == "name" and t.text in ("int64_t", "uint64_t", "ulong", "long") and s.word(i - 1) == "(" and s.word(i + 1) == ")":
            yield s.t[i - 1].at, 0, "0x1ffffffffff & "


def signedness(s):
    for i, t in enumerate(s.t):
        if t.kind == "name" and t.text in OTHER_SIGN and _is_type(s, i):
            yield whole(s, i, OTHER_SIGN[t.text])


def axis(s):
    following = {"x": "y", "y": "z", "z": "x"}
    for i, t in enumerate(s.t):
        if t.kind == "name" and t.text[-1] in following:
            new = t.text[:-1] + following[t.text[-1]]
            if s.word(i - 1) in (".", "->") and len(t.text) == 1 or (new in s.names and s.word(i + 1) != "(" and t.at >= 0):
                yield whole(s, i, new)
        elif t.kind == "number" and t.text in ("0", "1", "2") and s.word(i - 1) == "[" and s.word(i + 1) == "]" and s.kind(i - 2) != "":
            yield whole(s, i, {"0": "1", "1": "2", "2": "0"}[t.text])


def order(s):
    """Exchanges two adjacent arguments of a call, or the operands of a difference."""
    simple = re.compile(r"[\w.>\[\]&*-]+")
    for i, t in enumerate(s.t):
        if t.kind == "name" and t.text not in ("if", "while", "for", "switch", "return", "sizeof", "defined"):
            arguments = s.arguments(i)
            for a, b in zip(arguments or [], (arguments or [])[1:]):
                one, two = s.part(*a), s.part(*b)
                if one != two and simple.fullmatch(one) and simple.fullmatch(two) and s.kind(i - 1) != "name" and s.word(i - 1) != "*":
                    yield s.swap(a, b)
        elif t.text == "-" and s.binary(i) and s.kind(i - 1) == "name" and s.kind(i + 1) == "name" \
                and s.word(i - 2) in ("(", ",", "=", "return", "[") and s.word(i + 2) in (")", ",", ";", "]"):
            yield s.swap((i - 1, i - 1), (i + 1, i + 1))


def barrier(s):
    """Removes a synchronisation: barriers, fences, atomic updates, OpenMP's critical sections."""
    for i, t in enumerate(s.t):
        if t.kind == "pragma" and re.search(r"\b(barrier|critical|atomic|ordered|reduction|firstprivate)\b", t.text):
            without = re.sub(r"\s*\b(reduction|firstprivate)\s*\([^)]*\)", "", t.text)
            yield t.at, len(t.text), without if without != t.text else ""
        elif t.kind == "name" and re.fullmatch(r"barrier|mem_fence|atomic_thread_fence|clFinish|clWaitForEvents", t.text) and s.word(i + 1) == "(":
            end = match(s.t, i + 1)
            if end is not None and s.word(end + 1) == ";":
                yield (*s.span(i, end), "(void)0")
        elif t.kind == "name" and re.fullmatch(r"atom(ic)?_(add|or|and|max|min|inc)", t.text):
            arguments = s.arguments(i)
            end = match(s.t, i + 1) if arguments and len(arguments) == 2 else None
            if end is not None:
                sign_of = {"add": "+=", "or": "|=", "and": "&="}.get(t.text.split("_")[1], "=")
                yield (*s.span(i, end), f"(*({s.part(*arguments[0])}) {sign_of} ({s.part(*arguments[1])}))")


def clear(s):
    """Removes an initialisation."""
    for first, last in s.statements():
        words = [x.text for x in s.t[first:last + 1]]
        if words[0] in ("memset", "ost_clear") or words[-3:-1] == ["=", "0"] and "=" not in words[:-3] and len(words) < 16 and words[0] != "for":
            at, length = s.span(first, last)
            declares = len(words) > 3 and s.kind(first) == "name" and s.kind(first + 1) == "name"
            yield (*s.span(last - 2, last), ";") if declares else (at, length, ";")


def lane(s):
    """Changes the immediate of a permutation, shift or insertion, or exchanges two neighbours in a table of lanes."""
    for i, t in enumerate(s.t):
        if t.kind != "name" or not _is_intrinsic(t.text):
            continue
        arguments = s.arguments(i)
        if not arguments:
            continue
        if re.search(r"_setr?_ep", t.text):
            for a, b in zip(arguments, arguments[1:]):
                if s.part(*a) != s.part(*b):
                    yield s.swap(a, b)
            continue
        first, last = arguments[-1]
        value = _value(s.word(last)) if first == last else None
        if value and "set" not in t.text:
            for number in sorted({value[0] ^ 1, value[0] ^ 2, value[0] + 1}):
                yield whole(s, last, _written(number, *value[1:]))
        elif first == last and s.kind(last) == "name" and re.search(r"s[lr][lra]i?_|shl|shr", t.text):
            yield whole(s, last, f"({s.word(last)} + 1)")


PAIRS = [
    (r"_epi(8|16|32|64)\b", r"_epu\1"), (r"_epu(8|16|32|64)\b", r"_epi\1"), (r"_cmpgt_", "_cmpeq_"), (r"_cmpeq_", "_cmpgt_"),
    (r"_cmpge_", "_cmpgt_"), (r"_cmple_", "_cmplt_"), (r"_cmplt_", "_cmple_"), (r"_cmpgt_(ep\w+_mask)", r"_cmpge_\1"),
    (r"_cmpneq_", "_cmpeq_"), (r"_adds_", "_add_"), (r"_subs_", "_sub_"), (r"_add_", "_sub_"), (r"_sub_", "_add_"),
    (r"_srli_", "_srai_"), (r"_srai_", "_srli_"), (r"_unpacklo_", "_unpackhi_"), (r"_unpackhi_", "_unpacklo_"),
    (r"_mullo_", "_mulhi_"), (r"_mulhi_", "_mullo_"), (r"_mulhi_epi16", "_mulhi_epu16"), (r"_mul_epi32", "_mul_epu32"), (r"_mul_epu32", "_mul_epi32"),
    (r"_packs_", "_packus_"), (r"_packus_", "_packs_"), (r"_and_si", "_or_si"), (r"_or_si", "_and_si"), (r"_xor_si", "_or_si"),
    (r"_andnot_", "_and_"), (r"_and_si", "_andnot_si"), (r"_min_", "_max_"), (r"_max_", "_min_"), (r"_cvtepi(\d+)_", r"_cvtepu\1_"),
    (r"_cvtepu(\d+)_", r"_cvtepi\1_"), (r"_castsi", "_castsi"), (r"_maskz_", "_maskz_"),
    (r"^vcgt", "vcge"), (r"^vcge", "vcgt"), (r"^vclt", "vcle"), (r"^vcle", "vclt"), (r"^vmax", "vmin"), (r"^vmin", "vmax"),
    (r"^vget_low", "vget_high"), (r"^vget_high", "vget_low"), (r"^vadd(q?)_", r"vqadd\1_"), (r"^vadd(q?)_", r"vsub\1_"), (r"^vsub(q?)_", r"vadd\1_"),
    (r"^vand", "vorr"), (r"^vorr", "vand"), (r"^veor", "vorr"), (r"^vbic", "vand"), (r"^vzip1", "vzip2"), (r"^vuzp1", "vuzp2"), (r"^vtrn1", "vtrn2"),
    (r"_s(8|16|32|64)$", r"_u\1"), (r"_u(8|16|32|64)$", r"_s\1"),
]
TWO_OPERANDS = re.compile(r"cmpgt|cmpge|cmplt|cmple|_sub_|_subs_|andnot|unpack|packs|packus|sllv|srlv|srav|permutexvar|shuffle_epi8|blendv"
                          r"|^v(sub|cgt|cge|clt|cle|bic|shl|zip|uzp|trn|ext|tbl)")


def intrinsic(s):
    """Replaces an intrinsic by that of the other signedness, comparison or half, or exchanges its operands."""
    for i, t in enumerate(s.t):
        if t.kind != "name" or not _is_intrinsic(t.text):
            continue
        for new in dict.fromkeys(re.sub(a, b, t.text) for a, b in PAIRS):
            if new != t.text:
                yield whole(s, i, new)
        arguments = s.arguments(i)
        if arguments and len(arguments) >= 2 and TWO_OPERANDS.search(t.text) and s.part(*arguments[0]) != s.part(*arguments[1]):
            yield s.swap(arguments[0], arguments[1])


def minmax(s):
    other = {"min": "max", "max": "min", "lo": "hi", "hi": "lo", "low": "high", "high": "low", "first": "last", "floor": "ceil", "ceil": "floor"}
    for i, t in enumerate(s.t):
        if t.kind != "name" or _is_intrinsic(t.text):
            continue
        for old, new in other.items():
            changed = re.sub(rf"(^|_){old}($|_)", rf"\g<1>{new}\g<2>", t.text)
            if changed != t.text and (changed in s.names or changed in ("max", "min")):
                yield whole(s, i, changed)


def last(s):
    """Makes a loop omit its last or its first iteration."""
    for i, t in enumerate(s.t):
        if t.text != "for" or s.word(i + 1) != "(":
            continue
        end = match(s.t, i + 1)
        stops = [k for k in range(i, end or i) if s.word(k) == ";"]
        if len(stops) != 2:
            continue
        for k in range(stops[0] + 1, stops[1]):
            if s.word(k) in ("<", "<=", "!=") and s.inside[k] == s.inside[stops[0]] and s.kind(k - 1) == "name" and s.word(k + 1) not in ("-",):
                yield whole(s, k, "+ 1 " + s.word(k))
                break
        for k in range(i + 2, stops[0]):
            if s.word(k) == "=" and s.word(k + 1) != "0":
                yield s.t[k + 1].at, 0, "1 + "
                break


def statement(s):
    keywords = {"return", "break", "continue", "goto", "case", "default", "if", "else", "for", "while", "do", "switch", "typedef", "struct", "union",
                "enum", "extern", "static", "const", "free"}
    for first, end in s.statements():
        words = [x.text for x in s.t[first:end + 1]]
        if words in (["break", ";"], ["continue", ";"]):
            yield (*s.span(first, end), ";")
            continue
        if words[0] in keywords or s.inside[first] is not None or len(words) < 2 or s.kind(first) == "fixed":
            continue
        if s.kind(first) == "name" and s.kind(first + 1) == "name" or words[1] == "*" and s.kind(first + 2) == "name" and words[3:4] in (["="], [";"], [","]):
            continue  # a declaration
        if any(w in words for w in ("=", "+=", "-=", "|=", "&=", "^=", "<<=", ">>=", "++", "--")) or words[1] == "(":
            yield (*s.span(first, end), ";")


OPERATORS = [bound, compare, sign, bits, logic, divide, negation, branches, lane, intrinsic, shift, mask, constant, width, signedness, axis, minmax, order,
             barrier, clear, last, statement]


def identify(file, operator, text, old, new, column, seen):
    """Returns an identifier that does not change when the line moves; `seen` counts equal lines of a file."""
    key = "\0".join((file, operator, text, old, new, str(column)))
    count = seen[key] = seen.get(key, -1) + 1
    return hashlib.sha256(f"{key}\0{count}".encode()).hexdigest()[:12]


def mutant(file, text, operator, at, length, new, seen):
    """Returns the mutant of a replacement in the text of a file, which must be ASCII except in its comments."""
    begin = text.rfind("\n", 0, at) + 1
    end = text.find("\n", at)
    line = text[begin:end if end >= 0 else len(text)]
    stripped = line.strip()
    column = at - begin - (len(line) - len(line.lstrip()))
    old = text[at:at + length]
    name = identify(file, operator, stripped, old, new, column, seen)
    return Mutant(name, file, text.count("\n", 0, at) + 1, operator, len(text[:at].encode()), old, new, stripped)


def mutants_of(file, text):
    """Returns all mutants of a source by position; a replacement that two operators make is attributed to the first."""
    s, seen, taken, out = Source(text, "/kernels/" in file), {}, set(), []
    for operator in OPERATORS:
        for at, length, new in operator(s):
            if at < 0 or (at, length, new) in taken:
                continue
            taken.add((at, length, new))
            out.append(mutant(file, text, operator.__name__, at, length, new, seen))
    return sorted(out, key=lambda m: (m.at, m.operator, m.new))


def applied(text, m):
    """Returns the source with the mutant in it. Raises ValueError if the mutant is of another source."""
    data = text.encode()
    old = m.old.encode()
    if data[m.at:m.at + len(old)] != old:
        raise ValueError(f"{m.file}: offset {m.at}: there is no {m.old!r}; the mutant {m.id} is of another source")
    return (data[:m.at] + m.new.encode() + data[m.at + len(old):]).decode()


def from_file(file, text, other, seen):
    """Returns the mutant that changes a source into another source, made by an external generator; None if both are equal."""
    if text == other:
        return None
    begin = len(os.path.commonprefix([text, other]))
    tail = len(os.path.commonprefix([text[begin:][::-1], other[begin:][::-1]]))
    return mutant(file, text, "universal", begin, len(text) - tail - begin, other[begin:len(other) - tail], seen)


def sample(mutants, count, seed):
    """Returns a sample of `count` mutants. Each stratum (file and operator) contributes in proportion to its size. The
    first n mutants of the sample are a sample of n."""
    strata = {}
    for m in mutants:
        strata.setdefault((m.file, m.operator), []).append(m)
    ranked = []
    for key in sorted(strata):
        draw = random.Random(f"{seed} {key[0]} {key[1]}")
        group = strata[key]
        draw.shuffle(group)
        first = draw.random()
        ranked += [((rank + first) / len(group), m.id, m) for rank, m in enumerate(group)]
    ranked.sort(key=lambda r: r[:2])
    return [m for _, _, m in ranked[:count]]
