/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/scan.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "core/printable.h"
#include "io/dicom/request.h"

/* Minimum number of files per process. A process takes about 20 ms to start and scans about 3,000 files per second. */
enum { FILES_PER_PROCESS = 64 };

void ost_dicom_scan_free(ost_dicom_scan *scan)
{
    ost_dicom_files_free(&scan->files);
    free(scan->frames);
    free(scan->series);
    *scan = (ost_dicom_scan){0};
}

ost_status ost_dicom_refuse(const char *file, ost_dicom_result result, ost_error *err)
{
    switch (result) {
    case OST_DICOM_RESULT_NOT_DICOM:
        return ost_fail(err, OST_ERR_INPUT, "%s: is not a DICOM file", file);
    case OST_DICOM_RESULT_NO_IMAGE:
        return ost_fail(err, OST_ERR_INPUT, "%s: is a DICOM file without an image", file);
    case OST_DICOM_RESULT_UNREADABLE:
        return ost_fail(err, OST_ERR_IO, "%s: cannot be read", file);
    case OST_DICOM_RESULT_DAMAGED:
        return ost_fail(err, OST_ERR_INPUT, "%s: is a truncated or damaged DICOM file", file);
    case OST_DICOM_RESULT_UNSUPPORTED:
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: its pixels are compressed in a way that osteon does not read; 'gdcmconv --raw' "
                        "decompresses them", file);
    case OST_DICOM_RESULT_NO_JPEG2000:
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "%s: its pixels are compressed by JPEG 2000; osteon was built without OpenJPEG (Debian: "
                        "libopenjp2-7-dev)", file);
    case OST_DICOM_RESULT_UNDECODABLE:
        return ost_fail(err, OST_ERR_INPUT, "%s: its compressed pixels are damaged, or do not have the stated size",
                        file);
    case OST_DICOM_RESULT_MEMORY:
        return ost_fail(err, OST_ERR_MEMORY, "%s: needs more than %d MB of memory to parse", file,
                        (int)(OST_DICOM_MEMORY_MAX >> 20));
    case OST_DICOM_RESULT_TOO_LARGE:
        return ost_fail(err, OST_ERR_RANGE, "%s: has more than 4 GiB, or more than %d images", file,
                        OST_DICOM_IMAGES_MAX);
    case OST_DICOM_RESULT_OK:
    case OST_DICOM_RESULT_COUNT: break;
    }
    return ost_dicom_process_nonsense(file, "unknown result", err);
}

/* ---------------------------------------------------------------- records */

static bool is_terminated(const char *text, size_t size)
{
    return memchr(text, '\0', size) != NULL;
}

/* Returns true if every text of a record ends within its field and every enumeration has a defined value. */
static bool is_valid(const ost_dicom_record *r)
{
    bool valid = r->result < OST_DICOM_RESULT_COUNT && (r->flags & ~(uint32_t)OST_DICOM_IMAGE_ALL) == 0 &&
                 r->padding_first <= r->padding_last;
    for (int i = 0; i < 6; i++)
        valid = valid && is_terminated(r->orientation[i], sizeof r->orientation[i]);
    for (int i = 0; i < 3; i++)
        valid = valid && is_terminated(r->position[i], sizeof r->position[i]);
    for (int i = 0; i < 2; i++)
        valid = valid && is_terminated(r->spacing[i], sizeof r->spacing[i]);
    return valid && is_terminated(r->thickness, sizeof r->thickness) && is_terminated(r->slope, sizeof r->slope) &&
           is_terminated(r->intercept, sizeof r->intercept) && is_terminated(r->syntax, sizeof r->syntax) &&
           is_terminated(r->series_uid, sizeof r->series_uid) &&
           is_terminated(r->description, sizeof r->description) && is_terminated(r->kernel, sizeof r->kernel) &&
           is_terminated(r->modality, sizeof r->modality);
}

static bool is_of(const ost_dicom_group *group, const ost_dicom_record *record)
{
    if (group->uid[0] || record->series_uid[0])
        return strcmp(group->uid, record->series_uid) == 0;
    const bool numbered = record->flags & OST_DICOM_IMAGE_NUMBERED;
    return group->numbered == numbered && (!numbered || group->number == record->series_number) &&
           memcmp(group->study, record->study, sizeof group->study) == 0;
}

/* Doubles the capacity of an array of items of `size` bytes. */
static ost_status grow(const char *path, void **items, size_t *capacity, size_t size, ost_error *err)
{
    const size_t more = *capacity ? 2 * *capacity : 16;
    void *grown = realloc(*items, more * size);
    if (!grown)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the attributes of %zu images", path, more);
    *items = grown;
    *capacity = more;
    return OST_OK;
}

/* Finds the series of a record, starting with the series of the previous image. Adds a new series if there is none. */
static ost_status find_series(ost_dicom_scan *scan, const char *file, const ost_dicom_record *record, uint32_t *out,
                              ost_error *err)
{
    const size_t last = scan->frame_count ? scan->frames[scan->frame_count - 1].series : 0;
    size_t at = scan->series_count && is_of(&scan->series[last], record) ? last : 0;
    while (at < scan->series_count && !is_of(&scan->series[at], record))
        at++;
    *out = (uint32_t)at;
    if (at < scan->series_count)
        return OST_OK;
    if (at == OST_DICOM_SERIES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: begins series %d of the folder; at most %d are supported, so pass the "
                        "folder of the series", file, OST_DICOM_SERIES_MAX + 1, OST_DICOM_SERIES_MAX);
    if (at == scan->series_capacity) {
        void *items = scan->series;
        ost_status status = grow(scan->path, &items, &scan->series_capacity, sizeof *scan->series, err);
        if (status != OST_OK)
            return status;
        scan->series = items;
    }
    ost_dicom_group *group = &scan->series[scan->series_count++];
    *group = (ost_dicom_group){.numbered = record->flags & OST_DICOM_IMAGE_NUMBERED, .number = record->series_number};
    memcpy(group->study, record->study, sizeof group->study);
    snprintf(group->uid, sizeof group->uid, "%s", record->series_uid);
    snprintf(group->description, sizeof group->description, "%s", record->description);
    snprintf(group->kernel, sizeof group->kernel, "%s", record->kernel);
    snprintf(group->modality, sizeof group->modality, "%s", record->modality);
    ost_make_printable(group->description);
    ost_make_printable(group->kernel);
    ost_make_printable(group->modality);
    return OST_OK;
}

ost_status ost_dicom_scan_add(ost_dicom_scan *scan, size_t file, const ost_dicom_record *record, ost_error *err)
{
    const char *path = scan->files.path[file];
    uint32_t series;
    if (!is_valid(record))
        return ost_dicom_process_nonsense(path, "attributes", err);
    if (scan->frame_count == OST_DICOM_IMAGES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: has image %d of the folder; at most %d are supported, so pass the "
                        "folder of the series", path, OST_DICOM_IMAGES_MAX + 1, OST_DICOM_IMAGES_MAX);
    ost_status status = find_series(scan, path, record, &series, err);
    if (status == OST_OK && scan->frame_count == scan->frame_capacity) {
        void *items = scan->frames;
        status = grow(scan->path, &items, &scan->frame_capacity, sizeof *scan->frames, err);
        scan->frames = items;
    }
    if (status != OST_OK)
        return status;
    ost_dicom_frame *frame = &scan->frames[scan->frame_count++];
    ost_dicom_frame_of(record, frame);
    frame->file = (uint32_t)file;
    frame->series = series;
    if (frame->flags & OST_DICOM_IMAGE_LOCALIZER)
        scan->series[series].localizers++;
    else if (!(frame->flags & OST_DICOM_IMAGE_COLOUR))
        scan->series[series].images++;
    return OST_OK;
}

/* ------------------------------------------------------------------- scan */

/* Receives the messages about the files `first` to `end` - 1. */
static ost_status receive(ost_dicom_scan *scan, ost_dicom_process *process, size_t first, size_t end, ost_error *err)
{
    size_t at = first;
    while (at < end) {
        const char *path = scan->files.path[at];
        ost_dicom_message message;
        ost_dicom_record record;
        uint32_t result;
        ost_status status = ost_dicom_process_next(process, path, 0, &message, err);
        if (status != OST_OK)
            return status;
        if (message.index != at - first || (message.type != OST_DICOM_FRAME && message.type != OST_DICOM_FILE))
            return ost_dicom_process_nonsense(path, "out of order", err);
        if (message.type == OST_DICOM_FRAME) {
            status = ost_dicom_process_read(process, path, &record, sizeof record, err);
            if (status == OST_OK)
                status = ost_dicom_scan_add(scan, at, &record, err);
        } else {
            status = ost_dicom_process_read(process, path, &result, sizeof result, err);
            if (status == OST_OK && result == OST_DICOM_RESULT_NOT_DICOM)
                scan->not_dicom++;
            else if (status == OST_OK && result == OST_DICOM_RESULT_NO_IMAGE)
                scan->no_image++;
            else if (status == OST_OK && result != OST_DICOM_RESULT_OK)
                status = ost_dicom_refuse(path, (ost_dicom_result)result, err);
            at++;
        }
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

static ost_status start(const ost_dicom_scan *scan, const ost_dicom_launch *launch, size_t first, size_t end,
                        const uint8_t salt[OST_DICOM_SALT], ost_dicom_process *process, ost_error *err)
{
    int request;
    ost_status status = ost_dicom_request_open(OST_DICOM_SCAN, salt, (const char *const *)scan->files.path + first,
                                               end - first, NULL, 0, &request, err);
    if (status != OST_OK)
        return status;
    status = ost_dicom_process_start(launch, request, end - first, process, err);
    close(request);
    return status;
}

ost_status ost_dicom_scan_path(const char *path, const ost_dicom_launch *launch, ost_dicom_scan *out, ost_error *err)
{
    uint8_t salt[OST_DICOM_SALT];
    ost_dicom_process processes[OST_DICOM_PROCESSES_MAX];
    size_t count = 0;
    *out = (ost_dicom_scan){.path = path};
    ost_status status = ost_dicom_files_find(path, &out->files, err);
    if (status == OST_OK && getrandom(salt, sizeof salt, 0) != sizeof salt)
        status = ost_fail(err, OST_ERR_IO, "%s: the system has no random numbers: %s", path, strerror(errno));
    const size_t files = out->files.count, wanted = ost_dicom_process_count(files / FILES_PER_PROCESS);
    for (; status == OST_OK && count < wanted; count++) {
        processes[count] = (ost_dicom_process){.pipe = -1};
        status = start(out, launch, files * count / wanted, files * (count + 1) / wanted, salt, &processes[count], err);
    }
    for (size_t p = 0; p < count && status == OST_OK; p++)
        status = receive(out, &processes[p], files * p / wanted, files * (p + 1) / wanted, err);
    for (size_t p = 0; p < count; p++)
        ost_dicom_process_end(&processes[p]);
    if (status != OST_OK)
        ost_dicom_scan_free(out);
    return status;
}
