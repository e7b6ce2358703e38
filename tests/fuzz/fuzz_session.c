/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as sessions. The result must be a session or a one-line error that names the file. The
 * complete part of a session must give the same result when it is read twice. It must be possible to convert the
 * session to a path, to repair it and to export it. Each input is also tested with corrected checksums, so that the
 * code after the check of the checksums is reached.
 */
#include "fuzz.h"

#include <osteon/session.h>

#include "io/session/layout.h"

/* Returns the number of records and stores the number of ticks in *ticks. */
static uint64_t count_records(ost_session *session, uint64_t *ticks)
{
    uint64_t records = 0;
    ost_record record;
    bool more = true;
    *ticks = 0;
    ost_session_rewind(session);
    for (;;) {
        ost_error err = {0};
        fuzz_require(ost_session_next(session, &record, &more, &err) == OST_OK);
        if (!more)
            return records;
        records++;
        *ticks += record.kind == OST_RECORD_TICK;
        fuzz_require(record.kind != OST_RECORD_NOTE || memchr(record.as.note.text, 0, OST_SESSION_TEXT));
    }
}

static void export_all(ost_session *session)
{
    char out[1200];
    ost_error err = {0};
    snprintf(out, sizeof out, "%s/out", fuzz_folder());
    fuzz_require(ost_session_write_csv(session, out, &err) == OST_OK);
}

static void repair(ost_session *session, uint64_t records)
{
    char out[1200];
    ost_session *again;
    ost_error err = {0};
    uint64_t ticks;
    snprintf(out, sizeof out, "%s/repaired.session", fuzz_folder());
    fuzz_require(ost_session_repair(session, out, &err) == OST_OK);
    fuzz_require(ost_session_open(out, &again, &err) == OST_OK);
    fuzz_require(count_records(again, &ticks) == records);
    fuzz_require(ost_session_summary_of(again)->damaged_bytes == 0 && ost_session_summary_of(again)->cut_bytes == 0);
    fuzz_require(ost_session_header_count(ost_session_header_of(again)) ==
                 ost_session_header_count(ost_session_header_of(session)));
    ost_session_close(again);
}

static void check_session(const uint8_t *data, size_t size)
{
    const char *file = fuzz_file("fuzz.session", data, size);
    ost_error err = {0};
    ost_session *session;
    const ost_status status = ost_session_open(file, &session, &err);
    fuzz_require_error(status, err, file);
    if (status != OST_OK) {
        fuzz_require(session == NULL);
        return;
    }
    char missing[OST_SESSION_MISSING];
    uint64_t ticks, again;
    const ost_session_summary *sum = ost_session_summary_of(session);
    const uint64_t records = count_records(session, &ticks);
    fuzz_require(count_records(session, &again) == records && again == ticks);
    /* The summary also counts records of unknown types, which the reader skips. */
    fuzz_require(ticks == sum->ticks && records <= sum->records && sum->complete_ticks <= ticks);
    fuzz_require(sum->damaged_bytes + sum->cut_bytes <= size && sum->file_bytes == size);
    fuzz_require(strlen(ost_session_missing(session, missing)) < OST_SESSION_MISSING);
    ost_path path;
    if (ost_session_path(session, &path, &err) == OST_OK) {
        fuzz_require(path.count == sum->complete_ticks);
        ost_path_free(&path);
    }
    export_all(session);
    repair(session, records);
    ost_session_close(session);
}

/* Corrects all sizes and checksums, so that the reader accepts the blocks. */
static void correct_checksums(uint8_t *p, size_t size)
{
    uint32_t identity = 0;
    for (size_t at = 0; at + SESSION_BLOCK < size; at += SESSION_ALIGN) {
        uint8_t *own = p + at;
        if (memcmp(own, session_magic, SESSION_MAGIC) != 0)
            continue;
        const size_t left = (size - at - SESSION_BLOCK) / SESSION_ALIGN * SESSION_ALIGN;
        size_t payload = get32(own + 12);
        payload = payload > left || payload % SESSION_ALIGN || payload > SESSION_PAYLOAD_MAX ? left : payload;
        if (payload == 0)
            continue;
        put32(own + 12, (uint32_t)payload);
        const bool header = get32(own + 8) == SESSION_KIND_HEADER;
        put32(own + 32, header ? 0 : (uint32_t)(payload / SESSION_RECORD));
        put32(own + 36, ost_session_crc(own + SESSION_BLOCK, payload));
        identity = header && identity == 0 ? get32(own + 36) : identity;
        put32(own + 40, identity);
        put32(own + 60, ost_session_crc(own, 60));
        at += payload;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_session(data, size);
    uint8_t *copy = malloc(size ? size : 1);
    fuzz_require(copy != NULL);
    if (size)
        memcpy(copy, data, size);
    correct_checksums(copy, size);
    check_session(copy, size);
    free(copy);
    return 0;
}

const char *const fuzz_words[] = {"\x89OSTSES\n",
                                  "format: osteon session 2\n",
                                  "bone: ",
                                  "\\x0a",
                                  "\\x",
                                  ": ",
                                  "\n",
                                  "plan.axis: 0,0,1\n",
                                  "bone_spacing_mm: 0.47,0.47,0.47\n",
                                  "\x01",
                                  "\x02",
                                  "\x03",
                                  "\xff\xff\xff\xff\xff\xff\xff\x7f",
                                  NULL};

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index >= 3)
        return 0;
    char path[1200];
    ost_error err = {0};
    ost_session_header *header;
    ost_recorder *recorder;
    snprintf(path, sizeof path, "%s/seed.session", fuzz_folder());
    fuzz_require(ost_session_header_create(&header, &err) == OST_OK);
    fuzz_require(ost_session_header_set(header, "format", "osteon session 2", &err) == OST_OK);
    fuzz_require(ost_session_header_set(header, "bone", index ? "a\\b\n\xc3\xa4.nrrd" : "builtin:scapula", &err) ==
                 OST_OK);
    fuzz_require(ost_session_header_set(header, "bone_spacing_mm", "0.47,0.47,1", &err) == OST_OK);
    fuzz_require(ost_recorder_open(path, header, &(ost_recorder_options){.no_sync = true, .capacity = 1024}, &recorder,
                                   &err) == OST_OK);
    const uint64_t ticks = index == 2 ? 0 : 30;
    for (uint64_t n = 0; n < ticks; n++) {
        const ost_record tick = {.kind = OST_RECORD_TICK,
                                 .as.tick = {.number = n + (index == 1 && n > 20),
                                             .tick = {.t_ns = (int64_t)n * 1000000 - (index == 1 ? 5000000 : 0),
                                                      .pose = ost_pose_identity()},
                                             .digest = n * UINT64_C(0x9e3779b97f4a7c15),
                                             .removed = (uint32_t)n,
                                             .force_un = {(int32_t)n, -1, 0}}};
        ost_recorder_put_waiting(recorder, &tick);
        const ost_record note = {.kind = OST_RECORD_NOTE, .as.note = {.t_ns = (int64_t)n, .text = "a \"note\"\n"}};
        if (n % 10 == 3)
            ost_recorder_put_waiting(recorder, &note);
    }
    fuzz_require(ost_recorder_close(recorder, index ? NULL : &(ost_session_end){.ticks = ticks}, &err) == OST_OK);
    ost_session_header_free(header);
    FILE *file = fopen(path, "rb");
    fuzz_require(file != NULL);
    const size_t size = fread(bytes, 1, capacity, file);
    fclose(file);
    return size;
}
