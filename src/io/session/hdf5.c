/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a session as HDF5 in the layout of volumetric_drilling's recordings,
 * version 3, so that tools for these find poses and forces where they expect them
 * (docs/session.md describes the contents and the omissions).
 *
 * The few parts of the format that are needed are written here, by the HDF5 File
 * Format Specification 3.0, because libhdf5 would add thirty libraries to the start
 * of every verb.  All sizes are known before writing, so the file is written from
 * front to back. It contains no date. Its parts are:
 *
 *   superblock, version 0 | object headers, version 1 | arrays of 64-bit numbers, each in one piece
 *
 *   group: Link Info, Group Info, a Link for each member     array: Dataspace, Datatype, Fill Value, Layout, maybe an Attribute
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "io/outfile.h"
#include "io/session/reader.h"

enum { SUPERBLOCK = 96, HEADER = 16, MESSAGE = 8, CHUNK = 8192, CAMERA_NS = 20000000 };
#define UNDEFINED UINT64_MAX

typedef enum node_kind { GROUP, REALS, WHOLES, CHARACTERS } node_kind;

enum {
    ROOT,
    METADATA, METADATA_README, METADATA_VOLUME, METADATA_SESSION,
    VISION, VISION_EVENTS, VISION_SERIES, VISION_TIME, VISION_DRILL, VISION_ANATOMY,
    PHYSICS, EVENTS, VOXELS, VOXELS_README, VOXELS_TIME, VOXELS_COUNT, VOXELS_REMOVED, VOXELS_COLOR, BURR, BURR_TIME, BURR_TOOL, WRENCH, WRENCH_VALUE, WRENCH_TIME,
    SERIES, POSES, DRILL, DRILL_TIME, DRILL_POSE, ANATOMY, ANATOMY_TIME, ANATOMY_POSE,
    NODES
};

/* Parents come before their members. columns is 0 for a single number. */
static const struct {
    int parent;
    const char *name;
    node_kind kind;
    int columns;
} tree[NODES] = {
    [ROOT] = {-1, "", GROUP, 0},
    [METADATA] = {ROOT, "metadata_v3", GROUP, 0},
    [METADATA_README] = {METADATA, "README", CHARACTERS, 0},
    [METADATA_VOLUME] = {METADATA, "voxel_volume", REALS, 0},
    [METADATA_SESSION] = {METADATA, "osteon_session", CHARACTERS, 0},
    [VISION] = {ROOT, "vision_data", GROUP, 0},
    [VISION_EVENTS] = {VISION, "intermittent_data", GROUP, 0},
    [VISION_SERIES] = {VISION, "continuous_data", GROUP, 0},
    [VISION_TIME] = {VISION_SERIES, "time", REALS, 1},
    [VISION_DRILL] = {VISION_SERIES, "pose_mastoidectomy_drill", REALS, 7},
    [VISION_ANATOMY] = {VISION_SERIES, "pose_mastoidectomy_volume", REALS, 7},
    [PHYSICS] = {ROOT, "physics_data", GROUP, 0},
    [EVENTS] = {PHYSICS, "intermittent_data", GROUP, 0},
    [VOXELS] = {EVENTS, "voxels_removed", GROUP, 0},
    [VOXELS_README] = {VOXELS, "README", CHARACTERS, 0},
    [VOXELS_TIME] = {VOXELS, "voxel_time_stamp", REALS, 1},
    [VOXELS_COUNT] = {VOXELS, "voxel_count", WHOLES, 1},
    [VOXELS_REMOVED] = {VOXELS, "voxel_removed", REALS, 4},
    [VOXELS_COLOR] = {VOXELS, "voxel_color", REALS, 5},
    [BURR] = {EVENTS, "burr_change", GROUP, 0},
    [BURR_TIME] = {BURR, "time_stamp", REALS, 1},
    [BURR_TOOL] = {BURR, "tool", WHOLES, 1},
    [WRENCH] = {EVENTS, "drill_force_feedback", GROUP, 0},
    [WRENCH_VALUE] = {WRENCH, "wrench", REALS, 6},
    [WRENCH_TIME] = {WRENCH, "time_stamp", REALS, 1},
    [SERIES] = {PHYSICS, "continuous_data", GROUP, 0},
    [POSES] = {SERIES, "high_frequency_poses", GROUP, 0},
    [DRILL] = {POSES, "drill_pose", GROUP, 0},
    [DRILL_TIME] = {DRILL, "time_stamp", REALS, 1},
    [DRILL_POSE] = {DRILL, "pose", REALS, 7},
    [ANATOMY] = {POSES, "anatomy_pose", GROUP, 0},
    [ANATOMY_TIME] = {ANATOMY, "time_stamp", REALS, 1},
    [ANATOMY_POSE] = {ANATOMY, "pose", REALS, 7},
};

static const char readme[] =
    "Written by osteon from one of its sessions, in the layout of volumetric_drilling's recordings, version 3.\n"
    "Positions are in metres. A quaternion is qx, qy, qz, qw. A pose takes the object's frame into the world's, which is the bone's:\n"
    "the CT's, x to the patient's left, y to the back, z to the head. The bone does not move. Times are seconds of the session's own clock.\n"
    "A wrench is the force (N) and the torque (N m, about the tool's origin) on the hand, in the world's frame.\n"
    "There are no cameras: no pictures, no depth, no segmentation, no camera poses. osteon_session holds the session's header.\n";
static const char voxels_readme[] =
    "Groups of voxels that went together: voxel_time_stamp says when, voxel_count how many. A row of voxel_removed is a voxel: its group,\n"
    "and its x, y, z in the bone's grid; voxel_color has the same rows with its group and its density as a grey, red, green, blue, alpha from\n"
    "0 to 255: a 255th for each 8 HU. Both have no rows where nobody has asked which voxels went, and then a group is a tick; else 20 ms.\n";
static const char volume_units[] = "mm^3, millimeters cubed";

typedef struct h5 {
    ost_outfile *out;
    ost_error *err;
    ost_status status;
    ost_session *session;
    const ost_session_voxels *voxels; /* NULL if not known */
    char *session_text; /* owned; the header, one key per line */
    double volume_mm3;
    uint64_t rows[NODES], header_at[NODES], data_at[NODES];
    unsigned char buffer[CHUNK];
    size_t used;
} h5;

/* ----------------------------------------------------------------- writing */

static void drain(h5 *f)
{
    if (f->status == OST_OK && f->used > 0)
        f->status = ost_outfile_write(f->out, f->buffer, f->used, f->err);
    f->used = 0;
}

static void add(h5 *f, const void *what, size_t size)
{
    for (const unsigned char *p = what; size > 0;) {
        const size_t n = size < CHUNK - f->used ? size : CHUNK - f->used;
        memcpy(f->buffer + f->used, p, n);
        f->used += n;
        p += n;
        size -= n;
        if (f->used == CHUNK)
            drain(f);
    }
}

static void add_number(h5 *f, uint64_t value, size_t bytes)
{
    unsigned char p[8];
    put64(p, value);
    add(f, p, bytes);
}

static void add_zeros(h5 *f, uint64_t count)
{
    static const unsigned char zeros[8];
    for (; count > 0; count--)
        add(f, zeros, 1);
}

static void add_real(h5 *f, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    add_number(f, bits, 8);
}

/* ----------------------------------------------------------- sizes, offsets */

static uint64_t padded(uint64_t size)
{
    return (size + 7) / 8 * 8;
}

static uint64_t link_bytes(int node)
{
    return MESSAGE + padded(1 + 1 + 1 + strlen(tree[node].name) + 8);
}

static const char *text_of(const h5 *f, int node)
{
    return node == METADATA_README ? readme : node == VOXELS_README ? voxels_readme : f->session_text;
}

static int rank_of(int node)
{
    return tree[node].kind == CHARACTERS ? 0 : tree[node].columns == 0 ? 0 : tree[node].columns == 1 ? 1 : 2;
}

static uint64_t type_bytes(node_kind kind)
{
    return kind == REALS ? 20 : kind == WHOLES ? 12 : 8;
}

static const char *units_of(int node)
{
    return node == METADATA_VOLUME ? volume_units : NULL;
}

static uint64_t attribute_bytes(int node)
{
    return units_of(node) ? MESSAGE + 8 + 8 + 8 + 8 + padded(strlen(units_of(node))) : 0;
}

static uint64_t header_bytes(int node)
{
    if (tree[node].kind != GROUP)
        return HEADER + MESSAGE + padded(8 + 8 * (uint64_t)rank_of(node)) + MESSAGE + padded(type_bytes(tree[node].kind)) + MESSAGE + 8 + MESSAGE + 24 +
               attribute_bytes(node);
    uint64_t size = HEADER + MESSAGE + 24 + MESSAGE + 8;
    for (int m = 0; m < NODES; m++)
        size += tree[m].parent == node ? link_bytes(m) : 0;
    return size;
}

static uint64_t data_bytes(const h5 *f, int node)
{
    if (tree[node].kind == GROUP)
        return 0;
    if (tree[node].kind == CHARACTERS)
        return strlen(text_of(f, node));
    return 8 * f->rows[node] * (uint64_t)(tree[node].columns ? tree[node].columns : 1);
}

/* ----------------------------------------------------------------- headers */

static void begin_message(h5 *f, int type, uint64_t size)
{
    add_number(f, (uint64_t)type, 2);
    add_number(f, padded(size), 2);
    add_number(f, 0, 4);
}

static void add_dataspace(h5 *f, int node)
{
    const int rank = rank_of(node);
    add_number(f, 1, 1);
    add_number(f, (uint64_t)rank, 1);
    add_number(f, 0, 6);
    if (rank > 0)
        add_number(f, f->rows[node], 8);
    if (rank > 1)
        add_number(f, (uint64_t)tree[node].columns, 8);
}

static void add_datatype(h5 *f, node_kind kind, uint64_t characters)
{
    const bool real = kind == REALS, complete = kind == WHOLES;
    /*
     * Version 1 and the class, then the class's bits: for reals IEEE order and sign, for integers the sign, for text
     * null padding and UTF-8.
     */
    add_number(f, real ? 0x11 : complete ? 0x10 : 0x13, 1);
    add_number(f, real ? 0x3f20 : complete ? 0x08 : 0x11, 3);
    add_number(f, characters ? characters : 8, 4);
    if (kind == CHARACTERS)
        return;
    add_number(f, 0, 2);
    add_number(f, 64, 2);
    if (!real)
        return;
    add_number(f, 52, 1); /* exponent: location and size */
    add_number(f, 11, 1);
    add_number(f, 0, 1); /* mantissa: location and size */
    add_number(f, 52, 1);
    add_number(f, 1023, 4);
}

static void add_header_start(h5 *f, int node, int messages)
{
    add_number(f, 1, 2);
    add_number(f, (uint64_t)messages, 2);
    add_number(f, 1, 4);
    add_number(f, header_bytes(node) - HEADER, 8);
}

static void add_group(h5 *f, int node)
{
    int members = 0;
    for (int m = 0; m < NODES; m++)
        members += tree[m].parent == node;
    add_header_start(f, node, 2 + members);
    begin_message(f, 0x02, 18);
    add_number(f, 0, 2);
    add_number(f, UNDEFINED, 8);
    add_number(f, UNDEFINED, 8);
    add_zeros(f, 6);
    begin_message(f, 0x0a, 2);
    add_zeros(f, 8);
    for (int m = 0; m < NODES; m++) {
        if (tree[m].parent != node)
            continue;
        const size_t length = strlen(tree[m].name);
        begin_message(f, 0x06, 3 + length + 8);
        add_number(f, 1, 1);
        add_number(f, 0, 1);
        add_number(f, length, 1);
        add(f, tree[m].name, length);
        add_number(f, f->header_at[m], 8);
        add_zeros(f, padded(3 + length + 8) - (3 + length + 8));
    }
}

static void add_attribute(h5 *f, int node)
{
    const char *units = units_of(node);
    const size_t length = strlen(units);
    begin_message(f, 0x0c, 8 + 8 + 8 + 8 + length);
    add_number(f, 1, 2);
    add_number(f, 6, 2); /* size of the name with its zero; then the sizes of type and dataspace */
    add_number(f, 8, 2);
    add_number(f, 8, 2);
    add(f, "units\0\0", 8);
    add_datatype(f, CHARACTERS, length);
    add_number(f, 1, 8);
    add(f, units, length);
    add_zeros(f, padded(length) - length);
}

static void add_array(h5 *f, int node)
{
    const uint64_t bytes = data_bytes(f, node), type = type_bytes(tree[node].kind);
    add_header_start(f, node, units_of(node) ? 5 : 4);
    begin_message(f, 0x01, 8 + 8 * (uint64_t)rank_of(node));
    add_dataspace(f, node);
    begin_message(f, 0x03, type);
    add_datatype(f, tree[node].kind, tree[node].kind == CHARACTERS ? bytes : 0);
    add_zeros(f, padded(type) - type);
    /* Fill value: late allocation, written if set, the default value. */
    begin_message(f, 0x05, 8);
    add_number(f, 0x01020202, 8);
    begin_message(f, 0x08, 18);
    add_number(f, 3, 1);
    add_number(f, 1, 1);
    add_number(f, bytes ? f->data_at[node] : UNDEFINED, 8);
    add_number(f, bytes, 8);
    add_zeros(f, 6);
    if (units_of(node))
        add_attribute(f, node);
}

static void add_superblock(h5 *f, uint64_t end)
{
    add(f, "\x89HDF\r\n\x1a\n", 8);
    add_number(f, 0, 5);
    add_number(f, 8, 1);
    add_number(f, 8, 2);
    add_number(f, 4, 2);
    add_number(f, 16, 2);
    add_number(f, 0, 4);
    add_number(f, 0, 8);
    add_number(f, UNDEFINED, 8);
    add_number(f, end, 8);
    add_number(f, UNDEFINED, 8);
    add_number(f, 0, 8);
    add_number(f, f->header_at[ROOT], 8);
    add_zeros(f, 24);
}

/* -------------------------------------------------------------------- data */

static bool has_force(const ost_session_tick *t)
{
    return (t->flags & OST_TICK_FORCE) || t->force_un[0] || t->force_un[1] || t->force_un[2] || t->torque_unm[0] || t->torque_unm[1] || t->torque_unm[2];
}

/* The state of a pass over the ticks; it decides which ticks have a row. */
typedef struct walk {
    bool any;
    int32_t tool;
    int64_t picture_ns; /* time at which the next row of the slow series is due */
} walk;

static bool takes(walk *w, int node, const ost_session_tick *t)
{
    const bool first = !w->any;
    w->any = true;
    switch (tree[node].parent) {
    case VISION_SERIES:
        if (!first && t->tick.t_ns < w->picture_ns)
            return false;
        w->picture_ns = t->tick.t_ns < INT64_MAX - CAMERA_NS ? t->tick.t_ns + CAMERA_NS : INT64_MAX;
        return true;
    case VOXELS: return t->removed > 0;
    case WRENCH: return has_force(t);
    case BURR: {
        const bool changed = first || t->tick.tool != w->tool;
        w->tool = t->tick.tool;
        return changed;
    }
    case ANATOMY: return first; /* the bone does not move */
    default: return true;
    }
}

static void add_row(h5 *f, int node, const ost_session_tick *t)
{
    const ost_pose *p = &t->tick.pose;
    switch (node) {
    case VOXELS_COUNT: add_number(f, t->removed, 8); return;
    case BURR_TOOL: add_number(f, (uint64_t)(int64_t)t->tick.tool, 8); return;
    case WRENCH_VALUE:
        for (int a = 0; a < 3; a++)
            add_real(f, t->force_un[a] / 1e6);
        for (int a = 0; a < 3; a++)
            add_real(f, t->torque_unm[a] / 1e6);
        return;
    case VISION_ANATOMY:
    case ANATOMY_POSE:
        for (int a = 0; a < 7; a++)
            add_real(f, a == 6);
        return;
    case VISION_DRILL:
    case DRILL_POSE: {
        const int64_t at[3] = {p->t.x, p->t.y, p->t.z};
        const int32_t q[4] = {p->qx, p->qy, p->qz, p->qw};
        for (int a = 0; a < 3; a++)
            add_real(f, (double)at[a] / 1e12);
        for (int a = 0; a < 4; a++)
            add_real(f, (double)q[a] / OST_Q30_ONE);
        return;
    }
    default: add_real(f, (double)t->tick.t_ns / 1e9);
    }
}

/* Adds the rows of the voxels that a replay has found. Returns false if node is not such an array or none are known. */
static bool add_voxels(h5 *f, int node)
{
    const ost_session_voxels *v = f->voxels;
    if (tree[node].parent != VOXELS || !v)
        return false;
    size_t next = 0;
    for (size_t g = 0; g < v->groups && (node == VOXELS_TIME || node == VOXELS_COUNT); g++) {
        const size_t first = next;
        while (next < v->count && v->voxels[next].group == g)
            next++;
        if (node == VOXELS_TIME)
            add_real(f, v->t_s[g]);
        else
            add_number(f, next - first, 8);
    }
    for (size_t i = 0; i < v->count && (node == VOXELS_REMOVED || node == VOXELS_COLOR); i++) {
        const ost_session_voxel *x = &v->voxels[i];
        const double grey = fmin(fmax(floor(x->density / 8.0), 0), 255);
        add_real(f, x->group);
        for (int a = 0; a < 3; a++)
            add_real(f, node == VOXELS_REMOVED ? x->at[a] : grey);
        if (node == VOXELS_COLOR)
            add_real(f, 255);
    }
    return true;
}

static uint64_t walk_ticks(h5 *f, int node, bool write);

static uint64_t rows_of(h5 *f, int node)
{
    if (node == METADATA_VOLUME)
        return 1;
    if (node == VOXELS_REMOVED || node == VOXELS_COLOR)
        return f->voxels ? f->voxels->count : 0;
    if (f->voxels && tree[node].parent == VOXELS)
        return f->voxels->groups;
    return walk_ticks(f, node, false);
}

/* Passes over all ticks for one array and returns its number of rows. If write is true, the rows are written too. */
static uint64_t walk_ticks(h5 *f, int node, bool write)
{
    walk w = {0};
    uint64_t rows = 0;
    ost_session_rewind(f->session);
    for (bool more = true; f->status == OST_OK;) {
        ost_record record;
        f->status = ost_session_next(f->session, &record, &more, f->err);
        if (f->status != OST_OK || !more)
            break;
        if (record.kind != OST_RECORD_TICK || !takes(&w, node, &record.as.tick))
            continue;
        rows++;
        if (write)
            add_row(f, node, &record.as.tick);
    }
    return rows;
}

static void add_data(h5 *f, int node)
{
    const uint64_t bytes = data_bytes(f, node);
    if (tree[node].kind == CHARACTERS)
        add(f, text_of(f, node), bytes);
    else if (node == METADATA_VOLUME)
        add_real(f, f->volume_mm3);
    else if (f->rows[node] > 0 && !add_voxels(f, node) && walk_ticks(f, node, true) != f->rows[node] && f->status == OST_OK)
        f->status = ost_fail(f->err, OST_ERR_IO, "%s: changed while it was read", f->session->path);
    add_zeros(f, padded(bytes) - bytes);
}

/* ---------------------------------------------------------------- the file */

/* Returns the product of the three lengths in bone_spacing_mm; NAN if the header does not contain them. */
static double voxel_volume(const ost_session_header *header)
{
    const char *p = ost_session_header_get(header, "bone_spacing_mm");
    double volume = 1;
    for (int a = 0; p && a < 3; a++) {
        char word[OST_PM_TEXT];
        ost_pm mm;
        const size_t n = strcspn(p, ",");
        if (n >= sizeof word)
            return NAN;
        memcpy(word, p, n);
        word[n] = '\0';
        if (ost_pm_parse(word, &mm, NULL) != OST_OK)
            return NAN;
        volume *= ost_pm_to_mm(mm);
        p += n + (p[n] == ',');
    }
    return p ? volume : NAN;
}

static char *header_text(const ost_session_header *header)
{
    size_t size = 1;
    const char *key, *value;
    for (int i = 0; i < ost_session_header_count(header); i++) {
        ost_session_header_entry(header, i, &key, &value);
        size += strlen(key) + 2 + strlen(value) + 1;
    }
    char *text = malloc(size + 1), *p = text;
    if (!text)
        return NULL;
    for (int i = 0; i < ost_session_header_count(header); i++) {
        ost_session_header_entry(header, i, &key, &value);
        p += sprintf(p, "%s: %s\n", key, value);
    }
    /* This format does not allow an empty text. */
    if (p == text)
        *p++ = '\n';
    *p = '\0';
    return text;
}

static void lay_out(h5 *f, uint64_t *end)
{
    for (int n = 0; n < NODES; n++)
        if (tree[n].kind == REALS || tree[n].kind == WHOLES)
            f->rows[n] = rows_of(f, n);
    uint64_t at = SUPERBLOCK;
    for (int n = 0; n < NODES; n++) {
        f->header_at[n] = at;
        at += header_bytes(n);
    }
    for (int n = 0; n < NODES; n++) {
        f->data_at[n] = at;
        at += padded(data_bytes(f, n));
    }
    *end = at;
}

ost_status ost_session_write_hdf5(ost_session *session, const char *path, const ost_session_voxels *voxels, ost_error *err)
{
    uint64_t end = 0;
    h5 *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "%s: no memory for writing HDF5", path);
    *f = (h5){.err = err, .session = session, .voxels = voxels, .volume_mm3 = voxel_volume(session->header), .session_text = header_text(session->header)};
    f->status = f->session_text ? ost_outfile_open(path, &f->out, err) : ost_fail(err, OST_ERR_MEMORY, "%s: no memory for writing HDF5", path);
    if (f->status == OST_OK)
        lay_out(f, &end);
    if (f->status == OST_OK) {
        add_superblock(f, end);
        for (int n = 0; n < NODES; n++)
            (tree[n].kind == GROUP ? add_group : add_array)(f, n);
        for (int n = 0; n < NODES; n++)
            if (tree[n].kind != GROUP)
                add_data(f, n);
        drain(f);
    }
    ost_session_rewind(session);
    ost_status status = f->status;
    if (status == OST_OK)
        status = ost_outfile_commit(f->out, err);
    else
        ost_outfile_discard(f->out);
    free(f->session_text);
    free(f);
    return status;
}
