/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Encodes and decodes records of 128 bytes. The first two bytes contain the kind; they are followed by
 *
 *   tick   2 u16 fault       4 u32 flags      8 u64 number    16 i64 t_ns
 *         24 i64 x, y, z    48 i32 qw, qx, qy, qz             64 i32 tool
 *         68 u32 buttons    72 u64 digest    80 u32 removed   84 u32 touched
 *         88 u16 poses      90 u16 rpm + 1   92 i32 force x, y, z
 *        104 i32 torque    116 u32 wake_ns  120 u32 exec_ns  124 u32 missed
 *   note   8 i64 t_ns       24 text, 104 bytes, padded with zeros
 *   end    4 u32 has root    8 u64 ticks      16 u64 removals   24 u64 removed
 *         32 root, 32 bytes; valid if "has root" is 1
 */
#include "io/session/layout.h"

_Static_assert(24 + OST_SESSION_TEXT == SESSION_RECORD, "a note's text ends its record");

static void encode_tick(const ost_session_tick *tick, unsigned char *out)
{
    const ost_pose *pose = &tick->tick.pose;
    put16(out + 2, tick->fault);
    put32(out + 4, (tick->flags & ~(uint32_t)OST_TICK_LIFTED) | (tick->tick.lifted ? OST_TICK_LIFTED : 0));
    put64(out + 8, tick->number);
    put64(out + 16, (uint64_t)tick->tick.t_ns);
    put64(out + 24, (uint64_t)pose->t.x);
    put64(out + 32, (uint64_t)pose->t.y);
    put64(out + 40, (uint64_t)pose->t.z);
    put32(out + 48, (uint32_t)pose->qw);
    put32(out + 52, (uint32_t)pose->qx);
    put32(out + 56, (uint32_t)pose->qy);
    put32(out + 60, (uint32_t)pose->qz);
    put32(out + 64, (uint32_t)tick->tick.tool);
    put32(out + 68, tick->buttons);
    put64(out + 72, tick->digest);
    put32(out + 80, tick->removed);
    put32(out + 84, tick->touched);
    put16(out + 88, tick->poses);
    put16(out + 90, (uint16_t)(tick->tick.rpm + 1));
    for (int a = 0; a < 3; a++) {
        put32(out + 92 + 4 * a, (uint32_t)tick->force_un[a]);
        put32(out + 104 + 4 * a, (uint32_t)tick->torque_unm[a]);
    }
    put32(out + 116, tick->wake_ns);
    put32(out + 120, tick->exec_ns);
    put32(out + 124, tick->missed);
}

static void decode_tick(const unsigned char *in, ost_session_tick *out)
{
    *out = (ost_session_tick){
        .fault = get16(in + 2),
        .flags = get32(in + 4) & ~(uint32_t)OST_TICK_LIFTED,
        .number = get64(in + 8),
        .tick = {.t_ns = (int64_t)get64(in + 16),
                 .tool = (int32_t)get32(in + 64),
                 .rpm = get16(in + 90) - 1, /* version 1 stores 0 here, which decodes as OST_RPM_ON */
                 .pose = {.t = {(int64_t)get64(in + 24), (int64_t)get64(in + 32), (int64_t)get64(in + 40)},
                          .qw = (int32_t)get32(in + 48),
                          .qx = (int32_t)get32(in + 52),
                          .qy = (int32_t)get32(in + 56),
                          .qz = (int32_t)get32(in + 60)},
                 .lifted = (get32(in + 4) & OST_TICK_LIFTED) != 0},
        .buttons = get32(in + 68),
        .digest = get64(in + 72),
        .removed = get32(in + 80),
        .touched = get32(in + 84),
        .poses = get16(in + 88),
        .wake_ns = get32(in + 116),
        .exec_ns = get32(in + 120),
        .missed = get32(in + 124),
    };
    for (int a = 0; a < 3; a++) {
        out->force_un[a] = (int32_t)get32(in + 92 + 4 * a);
        out->torque_unm[a] = (int32_t)get32(in + 104 + 4 * a);
    }
}

void ost_session_record_encode(const ost_record *record, unsigned char out[SESSION_RECORD])
{
    memset(out, 0, SESSION_RECORD);
    put16(out, (uint16_t)record->kind);
    switch (record->kind) {
    case OST_RECORD_TICK:
        encode_tick(&record->as.tick, out);
        break;
    case OST_RECORD_NOTE:
        put64(out + 8, (uint64_t)record->as.note.t_ns);
        memcpy(out + 24, record->as.note.text, strnlen(record->as.note.text, OST_SESSION_TEXT - 1));
        break;
    case OST_RECORD_END:
        put32(out + 4, record->as.end.has_root);
        put64(out + 8, record->as.end.ticks);
        put64(out + 16, record->as.end.removals);
        put64(out + 24, record->as.end.removed_voxels);
        if (record->as.end.has_root)
            memcpy(out + 32, record->as.end.root.bytes, OST_DIGEST_BYTES);
        break;
    }
}

bool ost_session_record_decode(const unsigned char in[SESSION_RECORD], ost_record *out)
{
    *out = (ost_record){.kind = (ost_record_kind)get16(in)};
    switch (get16(in)) {
    case OST_RECORD_TICK:
        decode_tick(in, &out->as.tick);
        return true;
    case OST_RECORD_NOTE:
        out->as.note.t_ns = (int64_t)get64(in + 8);
        memcpy(out->as.note.text, in + 24, OST_SESSION_TEXT - 1);
        return true;
    case OST_RECORD_END:
        out->as.end = (ost_session_end){
            .has_root = get32(in + 4) & 1,
            .ticks = get64(in + 8),
            .removals = get64(in + 16),
            .removed_voxels = get64(in + 24),
        };
        memcpy(out->as.end.root.bytes, in + 32, OST_DIGEST_BYTES);
        return true;
    default:
        return false;
    }
}
