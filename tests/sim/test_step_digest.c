/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the digest of a step. The expected values were computed by a program in another language,
 * written from docs/spec/session.md. 0xe220a8397b1dcdaf is the published first output of SplitMix64
 * for seed 0.
 * Covers: REQ-STEP-DIGEST
 */
#include "harness.h"

#include <osteon/sim.h>

static ost_chunk_report chunks[2];
static ost_removal_report report;
static ost_step_result result;

static void make(void)
{
    chunks[0] = (ost_chunk_report){.chunk = 7, .voxels = {5, 0}, .density = {600, 0}};
    chunks[1] = (ost_chunk_report){.chunk = 19, .voxels = {3, 4}, .density = {-400, 9000}};
    report = (ost_removal_report){.count = 2, .chunks = chunks, .total_voxels = 12, .touched_voxels = 5};
    result = (ost_step_result){.removal = true, .boxes_meet = true, .pose_count = 2, .report = &report};
}

static void digests_equal_documented_values(void **state)
{
    (void)state;
    const ost_step_result nothing = {0};
    assert_true(ost_step_digest(&nothing, 3) == UINT64_C(0xe220a8397b1dcdaf));
    static ost_removal_report empty;
    const ost_step_result touched_nothing = {.removal = true, .boxes_meet = true, .pose_count = 20, .report = &empty};
    assert_true(ost_step_digest(&touched_nothing, 3) == UINT64_C(0x88c5fe802c1e7b5));
    make();
    assert_true(ost_step_digest(&result, 2) == UINT64_C(0x3e7023035406c72e));
}

static void every_difference_changes_digest(void **state)
{
    (void)state;
    make();
    const uint64_t before = ost_step_digest(&result, 2);
#define CHANGES_DIGEST(change)                                 \
    do {                                                       \
        make();                                                \
        change;                                                \
        assert_true(ost_step_digest(&result, 2) != before);    \
    } while (0)
    CHANGES_DIGEST(result.removal = false);
    CHANGES_DIGEST(result.boxes_meet = false);
    CHANGES_DIGEST(result.pose_count = 3);
    CHANGES_DIGEST(report.total_voxels++);
    CHANGES_DIGEST(report.touched_voxels--);
    CHANGES_DIGEST(report.count = 1);
    CHANGES_DIGEST(chunks[0].chunk = 8);
    CHANGES_DIGEST(chunks[1].voxels[1]--);
    CHANGES_DIGEST(chunks[1].density[0] = 400);
    /* If one chunk has one voxel more and another chunk one voxel less, the digest must change. */
    CHANGES_DIGEST((chunks[0].voxels[0]++, chunks[1].voxels[0]--));
    /* The digest is computed for two classes, so the third array element must not affect it. */
    make();
    chunks[0].voxels[2] = 77;
    assert_true(ost_step_digest(&result, 2) == before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(digests_equal_documented_values),
                                       cmocka_unit_test(every_difference_changes_digest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
