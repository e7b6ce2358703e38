#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes the table of a motor's rotation, RHE(2^30 sin(pi k / 4096)) for 0 <= k <= 2048, with decimals of 60 digits.

    motor_table.py --print           writes src/core/motor_table.h
    motor_table.py [MOTOR_TABLE.H]   compares the numbers of that file, one by one

pi is computed by Machin's formula with two arctangents, and a sine by its Taylor series. The program checks that no
number is near a half, so that the rounding does not depend on the method.

Covers: AR-MOTOR-3
"""

import os
import re
import sys
from decimal import Decimal, getcontext

getcontext().prec = 60
STEPS = 4096
ONE = 1 << 30


def arctan_of_inverse(n):
    total, power, k = Decimal(0), Decimal(1) / n, 0
    while power > Decimal(10) ** -58:
        total += power / (2 * k + 1) if k % 2 == 0 else -power / (2 * k + 1)
        power /= n * n
        k += 1
    return total


PI = 16 * arctan_of_inverse(5) - 4 * arctan_of_inverse(239)


def sine(x):
    total, term, k = Decimal(0), x, 1
    while abs(term) > Decimal(10) ** -55:
        total += term
        term *= -x * x / ((k + 1) * (k + 2))
        k += 2
    return total


def rhe(value):
    floor = int(value)  # value >= 0
    rest = value - floor
    assert abs(rest - Decimal("0.5")) > Decimal(10) ** -6, "too near a half to trust"
    return floor + (rest > Decimal("0.5"))


def table():
    """Returns the sines of the first quarter of a revolution."""
    return [rhe(ONE * sine(PI * k / STEPS)) for k in range(STEPS // 2 + 1)]


def rotations(quarter):
    """Computes (C_k, S_k) for every k of a revolution from the sines of the first quarter."""
    half = STEPS // 2
    return [(quarter[half - k], quarter[k]) if k <= half else (-quarter[k - half], quarter[STEPS - k]) for k in range(STEPS)]


def main():
    if sys.argv[1:] == ["--print"]:
        numbers = table()
        print("/* SPDX-License-Identifier: Apache-2.0 */")
        print("/* RHE(2^30 sin(pi k / 4096)) for 0 <= k <= 2048 (AR-MOTOR-3). Made by\n   tests/oracle/motor_table.py --print, which also checks it. */")
        print("#ifndef OST_CORE_MOTOR_TABLE_H\n#define OST_CORE_MOTOR_TABLE_H\n\n#include <stdint.h>\n")
        print("static const int32_t motor_sine[] = {")
        for at in range(0, len(numbers), 8):
            print("    " + " ".join(f"{n}," for n in numbers[at:at + 8]))
        print("};\n\n#endif")
        return
    name = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.environ.get("top_srcdir", "."), "src/core/motor_table.h")
    with open(name) as file:
        text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
    written = [int(n) for n in re.findall(r"-?\b\d+\b", text[text.index("{"):])]
    expected = table()
    if written != expected:
        wrong = [k for k, (a, b) in enumerate(zip(written, expected)) if a != b]
        sys.exit(f"{name}: {len(written)} numbers for {len(expected)}, {len(wrong)} of them wrong, the first at {wrong[:1]}")
    print(f"{name}: {len(written)} sines are correct")


if __name__ == "__main__":
    main()
