/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/perform_parts.h"

#include <stdlib.h>
#include <string.h>

static ost_status run_stages(performer *p, ost_error *err)
{
    const scene *s = p->s;
    ost_status status = OST_OK;
    if (s->sample_count && !p->watch)
        status = perform_other_lattice(p, err);
    if (s->sample_count && !p->watch && status == OST_OK)
        status = perform_other_chunks(p, err);
    if (s->sample_count && status == OST_OK)
        status = perform_import(p, err);
    for (int i = 0; i < s->tool_count && status == OST_OK; i++)
        status = perform_tool(p, i, err);
    if (!s->path.count || p->refused || status != OST_OK)
        return status;
    status = steps_path_of(p->second, s, &p->path, &p->own_path, err);
    for (int i = 0; i < s->tool_count && !perform_is_of_steps(s) && !p->watch && status == OST_OK; i++)
        status = perform_other_bone(p, i, err);
    if (status == OST_OK)
        status = perform_begin_ticks(p, err);
    for (size_t i = 0; i < p->path.count && status == OST_OK; i++) {
        if (perform_is_of_steps(s)) {
            status = perform_steps(p, i, err);
            continue;
        }
        if (s->collide_every && i % (size_t)s->collide_every == 0)
            status = perform_collide(p, i, err);
        if (status == OST_OK)
            status = perform_tick(p, i, err);
    }
    if (status != OST_OK || perform_is_of_steps(s))
        return status;
    if (p->light) {
        for (uint32_t item = 2; item < 4 && status == OST_OK; item++)
            status = perform_record_nothing(p, TRACE_SAMPLE, item, err);
        return status == OST_OK ? perform_record_nothing(p, TRACE_FINAL, 0, err) : status;
    }
    status = perform_sample(p, 1, err);
    return status == OST_OK ? perform_record_bone(p, TRACE_FINAL, err) : status;
}

static ost_status perform_case(performer p, ost_error *why, ost_error *err)
{
    const scene *s = p.s;
    trace_writer *w = p.w;
    const uint32_t case_index = p.case_index;
    trace_begin(w, TRACE_CASE, case_index, 0);
    for (size_t i = 0; i < sizeof s->digest.bytes; i += 8) {
        uint64_t word;
        memcpy(&word, s->digest.bytes + i, 8);
        trace_word(w, word);
    }
    ost_status written = trace_end(w, err);
    *why = (ost_error){0};
    if (written == OST_OK && run_stages(&p, why) != OST_OK) {
        trace_begin(w, TRACE_FAILED, case_index, 0);
        trace_word(w, (uint64_t)why->status);
        const int32_t lo[3] = {0, 0, 0};
        /* Only the status of a failure is compared; this text is for the reader. */
        const ost_dims line = {(int32_t)strlen(why->text) + 1, 1, 1};
        char *text = trace_block(w, lo, line, 1);
        if (text)
            memcpy(text, why->text, (size_t)line.x);
        written = trace_end(w, err);
    }
    ost_removal_report_free(&p.collided);
    ost_removal_report_free(&p.removed);
    steps_history_free(&p.history);
    if (p.own_path)
        ost_path_free(&p.path);
    free(p.made_poses);
    free(p.made_maps);
    free(p.maps);
    free(p.boxes);
    ost_world_free(p.world);
    for (int i = 0; i < s->tool_count; i++)
        ost_tool_free(p.tools[i]);
    ost_bone_free(p.bone);
    free(p.was);
    free(p.is);
    free(p.right);
    return written;
}

ost_status perform(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, perform_watch *watch,
                   void *user, ost_error *why, ost_error *err)
{
    return perform_case(
        (performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .watch = watch, .user = user}, why,
        err);
}

ost_status perform_second(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, ost_error *why,
                          ost_error *err)
{
    return perform_case((performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .second = true}, why,
                        err);
}

ost_status perform_apart(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, const trace *given,
                         ost_error *why, ost_error *err)
{
    const compare_range range = compare_find(given, case_index);
    return perform_case(
        (performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .given = given, .in_given = range},
        why, err);
}
