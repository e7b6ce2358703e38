/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the digest of a step from 64-bit words. Each word is added to the digest h by
 *
 *   h <- mix(h ^ word)
 *
 * where mix is the bijection at the end of SplitMix64 (Steele, Lea, Flood 2014). A bijection maps different values
 * to different values, so two sequences that differ in a single word always have different digests. Other different
 * sequences have the same digest only by chance, with a probability of about 2^-64. The digest needs only integer
 * arithmetic and no library, so that a session can be checked on any machine.
 * The computation is fast enough for every tick; SHA-256 would take too long.
 */
#include <osteon/sim.h>

static uint64_t mix(uint64_t x)
{
    x += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

uint64_t ost_step_digest(const ost_step_result *result, int classes)
{
    uint64_t h = mix((uint64_t)result->removal | (uint64_t)result->boxes_meet << 1 |
                     (uint64_t)(uint32_t)result->pose_count << 32);
    const ost_removal_report *report = result->report;
    if (!report)
        return h;
    h = mix(h ^ report->total_voxels);
    h = mix(h ^ report->touched_voxels);
    for (size_t i = 0; i < report->count; i++) {
        const ost_chunk_report *chunk = &report->chunks[i];
        h = mix(h ^ (uint64_t)(uint32_t)chunk->chunk);
        for (int c = 0; c < classes; c++) {
            h = mix(h ^ chunk->voxels[c]);
            h = mix(h ^ (uint64_t)chunk->density[c]);
        }
    }
    return h;
}
