# SPDX-License-Identifier: Apache-2.0
"""Splits C and OpenCL C into tokens with their byte offsets.

Comments, strings and preprocessor lines other than #define yield no token that
may be changed. Assertions, attributes and the arguments of ost_fail yield none
either, because a change there has no effect on results.
"""
import re
from typing import NamedTuple

PATTERN = re.compile(r"""
    (?P<comment> /\*.*?\*/ | //[^\n]* )
  | (?P<directive> ^[ \t]*\#(?:\\\n|[^\n])* )
  | (?P<string> "(?:\\.|[^"\\])*" | '(?:\\.|[^'\\])*' )
  | (?P<number> \.?[0-9](?:[eEpP][+-]|[0-9A-Za-z_.])* )
  | (?P<name> [A-Za-z_]\w* )
  | (?P<op> <<=|>>=|\.\.\.|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|[^\s\w] )
""", re.X | re.S | re.M)

FIXED = {"assert", "static_assert", "_Static_assert", "__attribute__", "__extension__", "ost_fail", "_Alignas", "assume_aligned"}


class Token(NamedTuple):
    kind: str   # name, number, op, pragma
    text: str
    at: int     # offset in the text


def _tokens(text, begin, end):
    for found in PATTERN.finditer(text, begin, end):
        yield found.lastgroup, found.group(), found.start()


def _of_define(text, at):
    """Returns the offset of the body of a #define at `at`, which is after its name and parameters."""
    head = re.compile(r"[ \t]*#[ \t]*define[ \t]+\w+(\([^)]*\))?").match(text, at)
    return head.end() if head else None


def tokens(text):
    """Returns the tokens of a source that operators examine, in order."""
    out = []
    for kind, word, at in _tokens(text, 0, len(text)):
        if kind in ("comment", "string"):
            continue
        if kind == "directive":
            at += len(word) - len(word.lstrip())
            word = word.lstrip()
            if re.match(r"#\s*pragma\s+omp\b", word):
                out.append(Token("pragma", word, at))
            body = _of_define(text, at)
            if body is not None:
                inner = re.sub(r"\\\n", "  ", text[body:at + len(word)])
                # Comments in a body are skipped. Offsets remain valid, because a continuation is replaced by two blanks.
                out.append(Token("op", ";", -1))
                out += [Token(k, w, body + a) for k, w, a in _tokens(inner, 0, len(inner)) if k in ("name", "number", "op")]
                out.append(Token("op", ";", -1))
            continue
        out.append(Token(kind, word, at))
    return _without_fixed(out)


def match(found, at):
    """Returns the index of the bracket that closes the one at index `at`, or None."""
    close = {"(": ")", "[": "]", "{": "}"}
    stack = []
    for i in range(at, len(found)):
        word = found[i].text
        if word in close:
            stack.append(close[word])
        elif stack and word == stack[-1]:
            stack.pop()
            if not stack:
                return i
        elif word in (")", "]", "}"):
            return None
    return None


def _without_fixed(found):
    """Removes calls in which a change has no effect on results."""
    out, i = [], 0
    while i < len(found):
        if found[i].text in FIXED and i + 1 < len(found) and found[i + 1].text == "(":
            end = match(found, i + 1)
            if end is not None:
                # A token replaces the call, so that the tokens before and after the call do not become adjacent.
                out.append(Token("fixed", found[i].text, found[i].at))
                i = end + 1
                continue
        out.append(found[i])
        i += 1
    return out
