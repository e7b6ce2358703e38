/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/steps_record.h"

#include <stdio.h>
#include <string.h>

enum { SNAP_WORDS = 15, SNAP_VERTICES = 65536, TICK_WORDS = 11, POSE_WORDS = 61, REACHES = 54 };

static void put_int(trace_writer *w, int64_t value)
{
    trace_word(w, (uint64_t)value);
}

static void put_int128(trace_writer *w, ost_int128 value)
{
    trace_word(w, (uint64_t)value);
    put_int(w, (int64_t)(value >> 64));
}

static ost_status put_mesh(trace_writer *w, const ost_snapped_mesh *m, ost_error *err)
{
    const ost_tool_geometry *g = &m->grid;
    const int64_t words[] = {g->dims.x, g->dims.y, g->dims.z, g->voxel, g->corner.x, g->corner.y, g->corner.z, m->fraction_bits,
                             (int64_t)m->vertex_count, (int64_t)m->triangle_count, (int64_t)m->dropped_triangles};
    ost_digest digest;
    const ost_status status = ost_snapped_mesh_digest(m, &digest, err);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        put_int(w, words[i]);
    for (size_t i = 0; i < sizeof digest.bytes && status == OST_OK; i += 8) {
        uint64_t word;
        memcpy(&word, digest.bytes + i, 8);
        trace_word(w, word);
    }
    return status;
}

ost_status steps_put_snap(trace_writer *w, const ost_snapped_mesh *parts, ost_error *err)
{
    if (!parts)
        return OST_OK;
    ost_status status = put_mesh(w, &parts[0], err);
    if (status == OST_OK)
        status = put_mesh(w, &parts[1], err);
    for (size_t v = 0; v < parts[0].vertex_count && v < SNAP_VERTICES && status == OST_OK; v++) {
        const int32_t *p = parts[0].vertices[v]; /* each coordinate is at most 2^20 */
        put_int(w, p[0] | (int64_t)p[1] << 21 | (int64_t)p[2] << 42);
    }
    return status;
}

void steps_blocks(ost_dims bone, int32_t first[3][3])
{
    const int32_t n[3] = {bone.x, bone.y, bone.z};
    for (int a = 0; a < 3; a++) {
        first[0][a] = 0;
        first[1][a] = n[a] / 2 / OST_MAP_BLOCK * OST_MAP_BLOCK;
        first[2][a] = (n[a] - 1) / OST_MAP_BLOCK * OST_MAP_BLOCK;
    }
}

static void put_pose(trace_writer *w, const ost_pose *p)
{
    const int64_t words[] = {p->t.x, p->t.y, p->t.z, p->qw, p->qx, p->qy, p->qz};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        put_int(w, words[i]);
}

void steps_put_tick(trace_writer *w, bool refused, bool removal, int count, const ost_tick *tick)
{
    put_int(w, refused ? 2 : removal);
    put_int(w, count);
    put_int(w, tick->t_ns);
    put_int(w, tick->rpm);
    put_pose(w, &tick->pose);
}

void steps_put_pose(trace_writer *w, const steps_pose *p)
{
    put_pose(w, &p->pose);
    put_int128(w, p->map.divisor);
    for (int a = 0; a < 3; a++)
        put_int128(w, p->map.origin[a]);
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++)
            put_int128(w, p->map.column[b][a]);
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++)
            put_int(w, p->map.step[b][a]);
    for (int k = 0; k < 3; k++) {
        put_int(w, p->near[k]);
        for (int a = 0; a < 3; a++)
            put_int(w, p->near[k] ? p->base[k][a] : 0);
    }
    put_int(w, p->reaches);
    for (int a = 0; a < 3; a++)
        put_int(w, p->reaches ? p->box.lo[a] : 0);
    for (int a = 0; a < 3; a++)
        put_int(w, p->reaches ? p->box.hi[a] : 0);
}

/* ------------------------------------------------------------------- names */

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

/* An empty box covers the bounds of a pose that reaches no voxel; any other box must contain the bounds, whether or
   not the pose reaches a voxel. */
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
