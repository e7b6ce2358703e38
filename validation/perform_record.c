/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the records that more than one stage needs. */
#include "validation/perform_parts.h"

#include <string.h>

ost_status perform_end_record(performer *p, trace_stage stage, uint32_t item, ost_error *err)
{
    ost_status status = trace_end(p->w, err);
    if (status == OST_OK && p->watch)
        p->watch(p->user, stage, item);
    return status;
}

ost_status perform_record_nothing(performer *p, trace_stage stage, uint32_t item, ost_error *err)
{
    trace_begin(p->w, stage, p->case_index, item);
    trace_flags(p->w, TRACE_STAND_IN);
    return perform_end_record(p, stage, item, err);
}

void perform_record_counts(performer *p, const ost_bone_info *info)
{
    trace_word(p->w, (uint64_t)info->chunks);
    trace_word(p->w, (uint64_t)info->active_chunks);
    trace_word(p->w, (uint64_t)info->active_voxels);
}

void perform_record_digest(performer *p, const ost_digest *root)
{
    for (int i = 0; i < 4; i++) {
        uint64_t word;
        memcpy(&word, root->bytes + 8 * i, 8);
        trace_word(p->w, word);
    }
}

ost_status perform_record_bone(performer *p, trace_stage stage, ost_error *err)
{
    ost_bone_info info;
    const int32_t lo[3] = {0, 0, 0};
    ost_digest root;
    ost_status status = ost_bone_info_get(p->bone, &info, err);
    if (status == OST_OK && !p->second)
        status = ost_bone_digest(p->bone, NULL, &root, err);
    if (status == OST_OK)
        status = ost_bone_download(p->bone, 0, p->dims.z, p->was, err);
    if (status == OST_OK && p->second)
        status = steps_bone_digest(&p->geometry, p->s->threshold, p->was, &root, err);
    if (status != OST_OK)
        return status;
    trace_begin(p->w, stage, p->case_index, 0);
    perform_record_counts(p, &info);
    perform_record_digest(p, &root);
    int16_t *voxels = trace_block(p->w, lo, p->dims, 2);
    if (voxels)
        memcpy(voxels, p->was, (size_t)ost_dims_count(p->dims) * 2);
    return perform_end_record(p, stage, 0, err);
}
