/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a session as MCAP (https://mcap.dev/spec), for Foxglove, PlotJuggler and
 * the mcap libraries: JSON messages with JSON schemas, in chunks without compression.
 *
 *   magic | Header | Schemas, Channels, Metadata |
 *     { Chunk: messages of a mebibyte | a Message Index for each channel in it } ... | Data End |
 *   summary: Schemas, Channels, Statistics, Chunk Indexes, Metadata Index | Summary Offsets | Footer | magic
 *
 * A record: u8 opcode, u64 length, content.  Text and maps: u32 length, bytes.
 * All integers are little-endian.  There is a CRC-32 for each chunk, for the data
 * section from the file's first byte on, and for the summary.  The file contains
 * no date and no machine.  docs/session.md describes the topics.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include <zlib.h>

#include "core/integer.h"
#include "io/outfile.h"
#include "io/session/reader.h"

enum {
    OP_HEADER = 1,
    OP_FOOTER = 2,
    OP_SCHEMA = 3,
    OP_CHANNEL = 4,
    OP_MESSAGE = 5,
    OP_CHUNK = 6,
    OP_MESSAGE_INDEX = 7,
    OP_CHUNK_INDEX = 8,
    OP_STATISTICS = 11,
    OP_METADATA = 12,
    OP_METADATA_INDEX = 13,
    OP_SUMMARY_OFFSET = 14,
    OP_DATA_END = 15
};
enum { CHUNK_BYTES = 1 << 20, JSON_TEXT = 1024 };

enum { TOPIC_POSE, TOPIC_TICK, TOPIC_FORCE, TOPIC_NOTE, TOPICS };

#define OBJECT(properties) "{\"type\":\"object\",\"properties\":{" properties "}}"
#define TIME "\"timestamp\":" OBJECT("\"sec\":{\"type\":\"integer\"},\"nsec\":{\"type\":\"integer\"}")
#define XYZ "\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}"
#define WHOLE(name) "\"" name "\":{\"type\":\"integer\"}"
#define TEXT(name) "\"" name "\":{\"type\":\"string\"}"
#define TRUTH(name) "\"" name "\":{\"type\":\"boolean\"}"

static const struct {
    const char *topic, *schema, *data;
} topics[TOPICS] = {
    [TOPIC_POSE] = {"/tool/pose", "foxglove.PoseInFrame",
                    OBJECT(TIME "," TEXT("frame_id") ",\"pose\":" OBJECT("\"position\":" OBJECT(XYZ) ",\"orientation\":" OBJECT(
                        XYZ ",\"w\":{\"type\":\"number\"}")))},
    [TOPIC_TICK] = {"/tick", "osteon.Tick",
                    OBJECT(WHOLE("tick") "," WHOLE("tool") "," TRUTH("removal") "," TRUTH("met") "," WHOLE("poses") "," WHOLE("removed_voxels")
                               "," WHOLE("touched_voxels") "," TEXT("digest") "," TRUTH("force_given") "," TRUTH("declared") "," WHOLE("buttons")
                               "," WHOLE("fault") "," WHOLE("wake_ns") "," WHOLE("exec_ns") "," WHOLE("missed"))},
    [TOPIC_FORCE] = {"/hand/wrench", "osteon.Wrench",
                     OBJECT(TIME "," TEXT("frame_id") ",\"force\":" OBJECT(XYZ) ",\"torque\":" OBJECT(XYZ))},
    [TOPIC_NOTE] = {"/note", "foxglove.Log",
                    OBJECT(TIME "," WHOLE("level") "," TEXT("message") "," TEXT("name") "," TEXT("file") "," WHOLE("line"))},
};

/* ------------------------------------------------------------------- bytes */

typedef struct bytes {
    unsigned char *p; /* owned */
    size_t size, capacity;
    bool *failed;     /* set if an allocation fails; shared by all buffers of a file, so no failure is missed */
} bytes;

/* Appends bytes; does nothing after a failure. */
static void add(bytes *b, const void *what, size_t size)
{
    if (*b->failed || size == 0)
        return;
    if (b->size + size > b->capacity) {
        const size_t capacity = 2 * (b->size + size);
        unsigned char *p = realloc(b->p, capacity);
        if (!p) {
            *b->failed = true;
            return;
        }
        b->p = p;
        b->capacity = capacity;
    }
    memcpy(b->p + b->size, what, size);
    b->size += size;
}

static void add8(bytes *b, uint8_t v)
{
    add(b, &v, 1);
}

static void add16(bytes *b, uint16_t v)
{
    unsigned char p[2];
    put16(p, v);
    add(b, p, sizeof p);
}

static void add32(bytes *b, uint32_t v)
{
    unsigned char p[4];
    put32(p, v);
    add(b, p, sizeof p);
}

static void add64(bytes *b, uint64_t v)
{
    unsigned char p[8];
    put64(p, v);
    add(b, p, sizeof p);
}

static void add_text(bytes *b, const char *text)
{
    add32(b, (uint32_t)strlen(text));
    add(b, text, strlen(text));
}

/* Begins a record and returns the offset of its content; end_record sets its length. */
static size_t begin_record(bytes *b, int op)
{
    add8(b, (uint8_t)op);
    add64(b, 0);
    return b->size;
}

static void end_record(bytes *b, size_t from)
{
    if (!*b->failed)
        put64(b->p + from - 8, b->size - from);
}

/* Begins a map or an array in the same way. */
static size_t begin_array(bytes *b)
{
    add32(b, 0);
    return b->size;
}

static void end_array(bytes *b, size_t from)
{
    if (!*b->failed)
        put32(b->p + from - 4, (uint32_t)(b->size - from));
}

/* ------------------------------------------------------------------ writer */

typedef struct mcap {
    ost_outfile *out;
    ost_error *err;
    ost_status status;
    bool failed; /* an allocation for a part of the file has failed */
    const ost_session_header *header;
    uint64_t shift;           /* ns added to every time, because times in MCAP are unsigned */
    uint32_t crc;             /* of all bytes written so far */
    bytes chunk, index[TOPICS], chunk_indexes;
    uint64_t chunk_from, chunk_to, from, to, messages[TOPICS], metadata_at, metadata_bytes;
    uint32_t sequence[TOPICS], chunks;
    bool any; /* from and to are valid: there has been a message */
} mcap;

/* Writes b to the file and empties it. */
static void flush(mcap *m, bytes *b)
{
    if (m->status == OST_OK && m->failed)
        m->status = ost_fail(m->err, OST_ERR_MEMORY, "%s: no memory for a chunk of messages", ost_outfile_path(m->out));
    if (m->status == OST_OK) {
        m->crc = (uint32_t)crc32_z(m->crc, b->p, b->size);
        m->status = ost_outfile_write(m->out, b->p, b->size, m->err);
    }
    b->size = 0;
}

static void end_chunk(mcap *m)
{
    bytes b = {.failed = &m->failed};
    if (m->chunk.size == 0)
        return;
    const uint64_t at = ost_outfile_size(m->out), content = 8 + 8 + 8 + 4 + 4 + 8 + m->chunk.size;
    add8(&b, OP_CHUNK);
    add64(&b, content);
    add64(&b, m->chunk_from);
    add64(&b, m->chunk_to);
    add64(&b, m->chunk.size);
    add32(&b, (uint32_t)crc32_z(0, m->chunk.p, m->chunk.size));
    add_text(&b, "");
    add64(&b, m->chunk.size);
    flush(m, &b);
    const uint64_t size = m->chunk.size, index_at = at + 9 + content;
    flush(m, &m->chunk);
    bytes *x = &m->chunk_indexes;
    const size_t record = begin_record(x, OP_CHUNK_INDEX);
    add64(x, m->chunk_from);
    add64(x, m->chunk_to);
    add64(x, at);
    add64(x, 9 + content);
    const size_t map = begin_array(x);
    for (int t = 0; t < TOPICS; t++) {
        if (m->index[t].size == 0)
            continue;
        add16(x, (uint16_t)(t + 1));
        add64(x, index_at + b.size);
        const size_t from = begin_record(&b, OP_MESSAGE_INDEX);
        add16(&b, (uint16_t)(t + 1));
        add32(&b, (uint32_t)m->index[t].size);
        add(&b, m->index[t].p, m->index[t].size);
        end_record(&b, from);
        m->index[t].size = 0;
    }
    end_array(x, map);
    add64(x, b.size);
    add_text(x, "");
    add64(x, size);
    add64(x, size);
    end_record(x, record);
    flush(m, &b);
    free(b.p);
    m->chunks++;
}

static void message(mcap *m, int topic, int64_t t_ns, const char *json)
{
    const uint64_t t = (uint64_t)t_ns + m->shift;
    if (m->chunk.size == 0)
        m->chunk_from = m->chunk_to = t;
    m->chunk_from = t < m->chunk_from ? t : m->chunk_from;
    m->chunk_to = t > m->chunk_to ? t : m->chunk_to;
    m->from = !m->any || t < m->from ? t : m->from;
    m->to = !m->any || t > m->to ? t : m->to;
    m->any = true;
    add64(&m->index[topic], t);
    add64(&m->index[topic], m->chunk.size);
    const size_t from = begin_record(&m->chunk, OP_MESSAGE);
    add16(&m->chunk, (uint16_t)(topic + 1));
    add32(&m->chunk, m->sequence[topic]++);
    add64(&m->chunk, t);
    add64(&m->chunk, t);
    add(&m->chunk, json, strlen(json));
    end_record(&m->chunk, from);
    m->messages[topic]++;
    if (m->chunk.size >= CHUNK_BYTES)
        end_chunk(m);
}

/* ---------------------------------------------------------------- messages */

enum { NUMBER = 48 };

/* Formats value / 10^places exactly. */
static const char *scaled(int64_t value, int places, char text[NUMBER])
{
    const uint64_t size = value < 0 ? -(uint64_t)value : (uint64_t)value;
    uint64_t unit = 1;
    for (int i = 0; i < places; i++)
        unit *= 10;
    snprintf(text, NUMBER, "%s%" PRIu64 ".%0*" PRIu64, value < 0 ? "-" : "", size / unit, places, size % unit);
    return text;
}

/* Formats a quaternion component with ten decimals, as the CSV does. */
static const char *component(int32_t q, char text[NUMBER])
{
    return scaled((int64_t)ost_rhe_div128((ost_i128)q * INT64_C(10000000000), OST_Q30_ONE), 10, text);
}

static const char *stamp(const mcap *m, int64_t t_ns, char text[2 * NUMBER])
{
    const uint64_t t = (uint64_t)t_ns + m->shift;
    snprintf(text, 2 * NUMBER, "{\"sec\":%" PRIu64 ",\"nsec\":%" PRIu64 "}", t / 1000000000, t % 1000000000);
    return text;
}

static const char *truth(bool value)
{
    return value ? "true" : "false";
}

static void tick_messages(mcap *m, const ost_session_tick *t)
{
    char json[JSON_TEXT], time[2 * NUMBER], n[7][NUMBER];
    const ost_pose *p = &t->tick.pose;
    stamp(m, t->tick.t_ns, time);
    snprintf(json, sizeof json,
             "{\"timestamp\":%s,\"frame_id\":\"bone\",\"pose\":{\"position\":{\"x\":%s,\"y\":%s,\"z\":%s},"
             "\"orientation\":{\"x\":%s,\"y\":%s,\"z\":%s,\"w\":%s}}}",
             time, scaled(p->t.x, 12, n[0]), scaled(p->t.y, 12, n[1]), scaled(p->t.z, 12, n[2]), component(p->qx, n[3]), component(p->qy, n[4]),
             component(p->qz, n[5]), component(p->qw, n[6]));
    message(m, TOPIC_POSE, t->tick.t_ns, json);
    snprintf(json, sizeof json,
             "{\"tick\":%" PRIu64 ",\"tool\":%" PRId32 ",\"removal\":%s,\"met\":%s,\"poses\":%u,\"removed_voxels\":%" PRIu32
             ",\"touched_voxels\":%" PRIu32 ",\"digest\":\"%016" PRIx64 "\",\"force_given\":%s,\"declared\":%s,\"buttons\":%" PRIu32
             ",\"fault\":%u,\"wake_ns\":%" PRIu32 ",\"exec_ns\":%" PRIu32 ",\"missed\":%" PRIu32 "}",
             t->number, t->tick.tool, truth(t->flags & OST_TICK_REMOVAL), truth(t->flags & OST_TICK_MET), (unsigned)t->poses, t->removed, t->touched,
             t->digest, truth(t->flags & OST_TICK_FORCE), truth(t->flags & OST_TICK_DECLARED), t->buttons, (unsigned)t->fault, t->wake_ns, t->exec_ns,
             t->missed);
    message(m, TOPIC_TICK, t->tick.t_ns, json);
    const int32_t *f = t->force_un, *q = t->torque_unm;
    if (!(t->flags & OST_TICK_FORCE) && !f[0] && !f[1] && !f[2] && !q[0] && !q[1] && !q[2])
        return;
    snprintf(json, sizeof json,
             "{\"timestamp\":%s,\"frame_id\":\"bone\",\"force\":{\"x\":%s,\"y\":%s,\"z\":%s},\"torque\":{\"x\":%s,\"y\":%s,\"z\":%s}}", time,
             scaled(f[0], 6, n[0]), scaled(f[1], 6, n[1]), scaled(f[2], 6, n[2]), scaled(q[0], 6, n[3]), scaled(q[1], 6, n[4]), scaled(q[2], 6, n[5]));
    message(m, TOPIC_FORCE, t->tick.t_ns, json);
}

/*
 * Notes are written by osteon itself. Characters that JSON would require to be
 * escaped, and all that are not printable ASCII, become question marks.
 */
static void note_message(mcap *m, const ost_session_note *note)
{
    char json[JSON_TEXT], time[2 * NUMBER], text[OST_SESSION_TEXT];
    memcpy(text, note->text, sizeof text);
    text[sizeof text - 1] = '\0';
    for (char *p = text; *p; p++)
        if (*p < 32 || *p > 126 || *p == '"' || *p == '\\')
            *p = '?';
    snprintf(json, sizeof json, "{\"timestamp\":%s,\"level\":2,\"message\":\"%s\",\"name\":\"osteon\",\"file\":\"\",\"line\":0}", stamp(m, note->t_ns, time),
             text);
    message(m, TOPIC_NOTE, note->t_ns, json);
}

/* ---------------------------------------------------------------- the file */

static const unsigned char magic[8] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

static void add_schemas(bytes *b)
{
    for (int t = 0; t < TOPICS; t++) {
        const size_t from = begin_record(b, OP_SCHEMA);
        add16(b, (uint16_t)(t + 1));
        add_text(b, topics[t].schema);
        add_text(b, "jsonschema");
        add_text(b, topics[t].data);
        end_record(b, from);
    }
}

static void add_channels(bytes *b)
{
    for (int t = 0; t < TOPICS; t++) {
        const size_t from = begin_record(b, OP_CHANNEL);
        add16(b, (uint16_t)(t + 1));
        add16(b, (uint16_t)(t + 1));
        add_text(b, topics[t].topic);
        add_text(b, "json");
        add32(b, 0);
        end_record(b, from);
    }
}

/*
 * Adds a value. Bytes that are not valid UTF-8, as they may occur in a file name,
 * become question marks, because a string of MCAP is UTF-8.
 */
static void add_value(bytes *b, const char *value)
{
    const size_t from = begin_array(b);
    for (const unsigned char *p = (const unsigned char *)value; *p;) {
        const int more = *p < 0x80 ? 0 : *p >= 0xc2 && *p < 0xe0 ? 1 : *p >= 0xe0 && *p < 0xf0 ? 2 : *p >= 0xf0 && *p < 0xf5 ? 3 : -1;
        int k = 1;
        while (k <= more && (p[k] & 0xc0) == 0x80)
            k++;
        const uint32_t two = (uint32_t)p[0] << 8 | (more > 0 ? p[1] : 0u);
        const bool complete = more >= 0 && k > more && !(two >= 0xe000 && two < 0xe0a0) && !(two >= 0xeda0 && two < 0xee00) &&
                           !(two >= 0xf000 && two < 0xf090) && !(two >= 0xf490 && two < 0xf500);
        if (complete)
            add(b, p, (size_t)more + 1);
        else
            add(b, "?", 1);
        p += complete ? more + 1 : 1;
    }
    end_array(b, from);
}

static void write_head(mcap *m)
{
    bytes b = {.failed = &m->failed};
    char shift[24];
    add(&b, magic, sizeof magic);
    size_t from = begin_record(&b, OP_HEADER);
    add_text(&b, "");
    add_text(&b, "osteon");
    end_record(&b, from);
    add_schemas(&b);
    add_channels(&b);
    m->metadata_at = b.size;
    from = begin_record(&b, OP_METADATA);
    add_text(&b, "osteon session");
    const size_t map = begin_array(&b);
    for (int i = 0; i < ost_session_header_count(m->header); i++) {
        const char *key, *value;
        ost_session_header_entry(m->header, i, &key, &value);
        add_text(&b, key);
        add_value(&b, value);
    }
    snprintf(shift, sizeof shift, "%" PRIu64, m->shift);
    add_text(&b, "mcap.time_shift_ns");
    add_text(&b, shift);
    end_array(&b, map);
    end_record(&b, from);
    m->metadata_bytes = b.size - m->metadata_at;
    flush(m, &b);
    free(b.p);
}

static void add_statistics(const mcap *m, bytes *b)
{
    uint64_t count = 0;
    for (int t = 0; t < TOPICS; t++)
        count += m->messages[t];
    const size_t from = begin_record(b, OP_STATISTICS);
    add64(b, count);
    add16(b, TOPICS);
    add32(b, TOPICS);
    add32(b, 0);
    add32(b, 1);
    add32(b, m->chunks);
    add64(b, m->any ? m->from : 0);
    add64(b, m->any ? m->to : 0);
    const size_t map = begin_array(b);
    for (int t = 0; t < TOPICS; t++) {
        add16(b, (uint16_t)(t + 1));
        add64(b, m->messages[t]);
    }
    end_array(b, map);
    end_record(b, from);
}

static void write_tail(mcap *m)
{
    enum { GROUPS = 5 };
    bytes b = {.failed = &m->failed};
    size_t from = begin_record(&b, OP_DATA_END);
    add32(&b, m->crc);
    end_record(&b, from);
    flush(m, &b);

    const uint64_t summary = ost_outfile_size(m->out);
    const int ops[GROUPS] = {OP_SCHEMA, OP_CHANNEL, OP_STATISTICS, OP_CHUNK_INDEX, OP_METADATA_INDEX};
    uint64_t end[GROUPS];
    add_schemas(&b);
    end[0] = b.size;
    add_channels(&b);
    end[1] = b.size;
    add_statistics(m, &b);
    end[2] = b.size;
    add(&b, m->chunk_indexes.p, m->chunk_indexes.size);
    end[3] = b.size;
    from = begin_record(&b, OP_METADATA_INDEX);
    add64(&b, m->metadata_at);
    add64(&b, m->metadata_bytes);
    add_text(&b, "osteon session");
    end_record(&b, from);
    end[4] = b.size;
    const uint64_t offsets = summary + b.size;
    for (int g = 0; g < GROUPS; g++) {
        const uint64_t begin = g ? end[g - 1] : 0;
        if (end[g] == begin)
            continue;
        from = begin_record(&b, OP_SUMMARY_OFFSET);
        add8(&b, (uint8_t)ops[g]);
        add64(&b, summary + begin);
        add64(&b, end[g] - begin);
        end_record(&b, from);
    }
    from = begin_record(&b, OP_FOOTER);
    add64(&b, summary);
    add64(&b, offsets);
    add32(&b, 0);
    end_record(&b, from);
    add(&b, magic, sizeof magic);
    if (!m->failed) {
        const size_t crc_at = b.size - sizeof magic - 4;
        put32(b.p + crc_at, (uint32_t)crc32_z(0, b.p, crc_at));
    }
    flush(m, &b);
    free(b.p);
}

ost_status ost_session_write_mcap(ost_session *session, const char *path, ost_error *err)
{
    mcap m = {.err = err, .header = session->header};
    m.chunk.failed = m.chunk_indexes.failed = &m.failed;
    for (int t = 0; t < TOPICS; t++)
        m.index[t].failed = &m.failed;
    m.status = ost_outfile_open(path, &m.out, err);
    if (m.status != OST_OK)
        return m.status;
    const ost_session_summary *sum = &session->summary;
    m.shift = sum->ticks && sum->first_t_ns < 0 ? -(uint64_t)sum->first_t_ns : 0;
    write_head(&m);
    ost_session_rewind(session);
    for (bool more = true; m.status == OST_OK && !m.failed;) {
        ost_record record;
        m.status = ost_session_next(session, &record, &more, err);
        if (m.status != OST_OK || !more)
            break;
        if (record.kind == OST_RECORD_TICK)
            tick_messages(&m, &record.as.tick);
        else if (record.kind == OST_RECORD_NOTE)
            note_message(&m, &record.as.note);
    }
    ost_session_rewind(session);
    end_chunk(&m);
    write_tail(&m);
    free(m.chunk.p);
    free(m.chunk_indexes.p);
    for (int t = 0; t < TOPICS; t++)
        free(m.index[t].p);
    if (m.status == OST_OK)
        return ost_outfile_commit(m.out, err);
    ost_outfile_discard(m.out);
    return m.status;
}
