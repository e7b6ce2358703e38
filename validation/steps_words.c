/* SPDX-License-Identifier: Apache-2.0 */
/* Returns the names of the words of step records, and determines which of these words are bounds. */
#include "validation/steps_record.h"

#include <stdio.h>

enum { SNAP_WORDS = 15, TICK_WORDS = 11, POSE_WORDS = 61, REACHES = 54 };

static void name_pose_word(size_t at, char *text, size_t size)
{
    static const char *const pose[] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
    static const char *const half[] = {"low", "high"};
    if (at < 7)
        snprintf(text, size, "pose %s", pose[at]);
    else if (at < 9)
        snprintf(text, size, "divisor, %s", half[at - 7]);
    else if (at < 15)
        snprintf(text, size, "origin %c, %s", "xyz"[(at - 9) / 2], half[(at - 9) % 2]);
    else if (at < 33)
        snprintf(text, size, "column %c%c, %s", "xyz"[(at - 15) / 6], "xyz"[(at - 15) / 2 % 3], half[(at - 15) % 2]);
    else if (at < 42)
        snprintf(text, size, "step %c%c", "xyz"[(at - 33) / 3], "xyz"[(at - 33) % 3]);
    else if (at < REACHES && (at - 42) % 4 == 0)
        snprintf(text, size, "near block %c", "012"[(at - 42) / 4]);
    else if (at < REACHES)
        snprintf(text, size, "base %c of block %c", "xyz"[(at - 42) % 4 - 1], "012"[(at - 42) / 4]);
    else
        snprintf(text, size, "%s", at == REACHES ? "whether it reaches" : at < REACHES + 4 ? "box from" : "box to");
}

void steps_word_name(trace_stage stage, size_t word, char text[TRACE_WORD])
{
    static const char *const mesh[SNAP_WORDS] =
        {"width",       "height",        "depth",      "voxel",     "corner x",          "corner y",
         "corner z",    "fraction bits", "vertices",   "triangles", "dropped triangles", "mesh digest",
         "mesh digest", "mesh digest",   "mesh digest"};
    static const char *const tick[TICK_WORDS] = {"event",  "poses",   "time",    "motor speed", "pose x", "pose y",
                                                 "pose z", "pose qw", "pose qx", "pose qy",     "pose qz"};
    if (stage == TRACE_SNAP && word < SNAP_WORDS * 2)
        snprintf(text, TRACE_WORD, "%s%s", mesh[word % SNAP_WORDS], word < SNAP_WORDS ? "" : " of the second mesh");
    else if (stage == TRACE_SNAP)
        snprintf(text, TRACE_WORD, "snapped vertex %zu", word - SNAP_WORDS * 2);
    else if (word < TICK_WORDS)
        snprintf(text, TRACE_WORD, "%s", tick[word]);
    else {
        char what[28];
        name_pose_word((word - TICK_WORDS) % POSE_WORDS, what, sizeof what);
        snprintf(text, TRACE_WORD, "%s (pose %u)", what, (unsigned)((word - TICK_WORDS) / POSE_WORDS + 1) % 10000);
    }
}

bool steps_word_is_bound(size_t word)
{
    return word >= TICK_WORDS && (word - TICK_WORDS) % POSE_WORDS >= REACHES;
}

/* Returns true if word number `word` of `is` covers the bound in the same word of `least`. The word `reaches` of `is`
   must be set if it is set in `least`. If it is set in both, the box in `is` must contain the box in `least`. If not,
   the boxes are not compared. */
bool steps_word_holds(size_t word, const uint8_t *is, const uint8_t *least)
{
    const size_t at = (word - TICK_WORDS) % POSE_WORDS, flag = word - at + REACHES;
    const int64_t a = (int64_t)trace_word_at(is, word), b = (int64_t)trace_word_at(least, word);
    if (at == REACHES)
        return a >= b;
    if (!trace_word_at(is, flag) || !trace_word_at(least, flag))
        return true;
    return at < REACHES + 4 ? a <= b : a >= b;
}
