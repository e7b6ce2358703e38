/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kinds of mistakes that a port of the arithmetic to a GPU can contain, and the record of the positions
 * where a mistake was made.
 *
 * A backend opened with a deviation (dense.h) is correct except for one kind of mistake. The mistake is made
 * in some units (calls, samples, voxels, chunks, triangles ...), which are drawn from `seed`. On average, one
 * unit in `one_in` is drawn. If `one_in` is 0 or 1, the mistake is made in every unit.
 *
 * The record counts two kinds of effects and stores the first position of each:
 *   acted     a value inside the algorithm differed from the correct value;
 *             recorded by the code of the mistake itself
 *   changed   a voxel of the call's result, or a line of its report, differed from the correct result;
 *             recorded by the backend, which runs the stage a second time on the same input without the
 *             mistake
 * If acted is 0, the mistake was not triggered: no unit was drawn, or no drawn unit had a value that could
 * change. If acted is not 0 but changed is 0, the mistake survived; the table below lists when this can
 * happen. A comparison with any correct backend must find first_changed as its first difference.
 *
 * Each cause is marked with a letter:
 *   F   the cause is documented in the literature or was measured on a device
 *   T   the cause is the text of the thesis (docs/design/thesis-notes.md)
 *   P   the cause is known only from experience
 */
#ifndef OST_VALIDATION_DENSE_DEVIATION_H
#define OST_VALIDATION_DENSE_DEVIATION_H

#include <stdbool.h>
#include <stdint.h>

/* The stages, in the order of the pipeline. A kind of mistake that replaces the code of every stage has the stage
   DEVIATION_EVERY. */
typedef enum deviation_stage {
    DEVIATION_RECT,   /* ct_to_rect; one call is a grid with all its batches of samples */
    DEVIATION_CUBIC,  /* rect_to_cubic */
    DEVIATION_CHUNKS, /* cubic_to_chunks, bone_upload */
    DEVIATION_TOOL,   /* voxelize */
    DEVIATION_REMOVE, /* remove and collide; one call is an event */
    DEVIATION_EVERY,
    DEVIATION_STAGES
} deviation_stage;

/*
 * The list of mistakes. Each entry has the form X(kind, name, stage, unit, effect, cause, survival). `unit` is the
 * object for which one random decision is made. `survival` describes when the mistake acts but changes no result.
 */
#define DEVIATION_LIST(X)                                                                                              \
    /* samples to rect grid */                                                                                         \
    X(TRUNCATED_INDEX, "truncated-index", RECT, "sample",                                                              \
      "the index is a float quotient, truncated instead of rounded",                                                   \
      "T: Alg. 2.4, convert_int3_rtz; 2.9999998 is truncated to 2, so layers are lost and others are doubled",         \
      "the voxel that loses its sample and the one that receives it have equal densities")                             \
    X(LOST_DUPLICATE_RULE, "lost-duplicate-rule", RECT, "sample",                                                      \
      "of two samples in a voxel the wrong one is kept, and no conflict is reported",                                  \
      "P: a scatter without atomics; the order of work items is undefined",                                            \
      "a third sample of the voxel decides again")                                                                     \
    X(DROPPED_LAST_ITEMS, "dropped-last-items", RECT, "batch",                                                         \
      "the last count mod 64 samples of a batch are not scattered",                                                    \
      "P: a global size rounded down to whole work-groups", "never: the number of samples is in the report")           \
    X(OFF_BY_ONE_DIMS, "off-by-one-dims", RECT, "batch", "rows are dims.x - 1 long",                                   \
      "T: Alg. 2.3, n layers have n - 1 sizes between first and last",                                                 \
      "all samples lie in the first row, or the densities that change places are equal")                               \
    X(LAST_LAYER_LOST, "last-layer-lost", RECT, "batch", "samples of the last layer are not stored",                   \
      "T: Alg. 2.3, the last layer is written outside the array", "the last layer's densities are 0")                  \
    X(SATURATED_SHORT, "saturated-short", RECT, "sample", "densities are clamped to -1024 .. 3071",                    \
      "P: the 12 bits of a scanner, a saturating conversion too early", "another sample of the voxel decides")         \
    X(GARBAGE_IN_VOID, "garbage-in-void", RECT, "voxel", "the grid is not cleared before the first batch",             \
      "P: a device's memory is not zero when it is allocated", "a sample falls on the voxel")                          \
    X(RELATIVE_LINE, "relative-line", RECT, "batch", "lines are counted from the batch's start",                       \
      "P: the offset of a batch is not added in the kernel", "no line of the batch is named in the report")            \
    X(REPORT_OVERWRITTEN, "report-overwritten", RECT, "batch",                                                         \
      "a batch's counts replace the previous ones instead of being added to them",                                     \
      "P: an assignment in place of an addition", "never: the number of samples is in the report")                     \
    /* rect grid to cubic grid */                                                                                      \
    X(OTHER_RULE, "other-rule", CUBIC, "call",                                                                         \
      "the voxel that contains the centre instead of the mean of eight or of the floor; the floor instead of that "    \
      "voxel",                                                                                                         \
      "T: Alg. 2.5 can be read as either", "the voxels that change are equal")                                         \
    X(FLOAT_LAYER, "float-layer", CUBIC, "layer", "the position is a float quotient, truncated",                       \
      "T: Alg. 2.5, convert_int_rtz; the quotient is slightly less than the exact one",                                \
      "the two neighbouring layers are equal, or the mean rounds to the same value")                                   \
    X(TEXTURE_WEIGHTS, "texture-weights", CUBIC, "layer", "linear weights have 8 bits",                                \
      "F: CUDA C Programming Guide, Texture Fetching: linear filtering uses 9-bit fixed point with 8 bits of "         \
      "fractional value",                                                                                              \
      "the weight has 8 bits already, or the mean rounds to the same value")                                           \
    X(ROUNDED_EACH, "rounded-each", CUBIC, "call", "linear rounds after each axis instead of once",                    \
      "P: three passes over int16", "only one axis has weights, or the means round to the same value")                 \
    X(LAYER_OFF_BY_ONE, "layer-off-by-one", CUBIC, "layer", "a z layer takes the source layer before its own",         \
      "T: Alg. 2.5, PrevRectGridIndex", "the two source layers are equal")                                             \
    X(MULTIPLE_OFF_BY_ONE, "multiple-off-by-one", CUBIC, "layer",                                                      \
      "where the position is exactly on a layer, the layer before it is used",                                         \
      "P: ceil(q) - 1 for floor(q); a reciprocal slightly less than the exact one",                                    \
      "the two neighbouring layers are equal")                                                                         \
    X(SWAPPED_AXIS, "swapped-axis", CUBIC, "call", "the source is read with x and y exchanged",                        \
      "T: Alg. 1.1 is named ZYX and takes (x, y, z)", "the grid is its own mirror image about x = y")                  \
    X(PADDED_PITCH, "padded-pitch", CUBIC, "call", "rows of the source are assumed to have a multiple of 32 voxels",   \
      "P: a row pitch of an image or an aligned allocation", "all voxels that are read are equal")                     \
    /* cubic grid to chunks */                                                                                         \
    X(WRONG_THRESHOLD, "wrong-threshold", CHUNKS, "chunk", "voxels at the threshold are not active",                   \
      "T: section 2.4 deletes densities of at most 120, Alg. 2.6 makes those of at least 120 active",                  \
      "never: every density at the threshold becomes 0")                                                               \
    X(BYTE_ORDER, "byte-order", CHUNKS, "chunk", "the two bytes of a density are exchanged",                           \
      "P: a file or a device of the other byte order", "before and after, the density is below the threshold")         \
    X(UNSIGNED_COMPARE, "unsigned-compare", CHUNKS, "chunk",                                                           \
      "densities are compared as unsigned numbers, so air is active", "P: ushort for short",                           \
      "never: every negative density is kept")                                                                         \
    X(INACTIVE_KEPT, "inactive-kept", CHUNKS, "chunk", "voxels below the threshold keep their densities",              \
      "T: Alg. 2.6 copies every density and only counts the active ones", "never: every such density but 0 stays")     \
    X(CHUNK_BORDER_LOST, "chunk-border-lost", CHUNKS, "chunk", "the last x layer of a chunk stays empty",              \
      "P: x < n - 1, copied from a loop over differences", "that layer has no active voxel")                           \
    X(PARTIAL_CHUNKS_LOST, "partial-chunks-lost", CHUNKS, "call", "chunks that extend beyond the grid are not filled", \
      "P: dims / n rounded down instead of up", "those chunks have no active voxel")                                   \
    X(CHUNK_SHIFTED, "chunk-shifted", CHUNKS, "chunk", "a chunk reads one voxel too far along x",                      \
      "T: Alg. 2.6, ChunkMinPosInUnitVoxels off by one",                                                               \
      "every row of the chunk is uniform and the next voxel as well")                                                  \
    /* mesh to tool grid */                                                                                            \
    X(FLIPPED_TIE, "flipped-tie", TOOL, "triangle", "rows on an edge belong to its other side",                        \
      "F: D3D11.3 3.4.2.1 decides ties by the top-left rule, with y down; the mirrored rule is a common mistake",      \
      "all triangles at the edge flip alike and the surface crosses the row at the same voxel on both sides")          \
    X(OWNED_EDGE_TWICE, "owned-edge-twice", TOOL, "triangle", "rows on an edge belong to both its sides",              \
      "F: Embree #188 'hit exactly an edge, I sometimes get two intersections'; cuda_voxelizer #61",                   \
      "the edge is a silhouette and the doubled steps fall on the same voxel, outside the solid")                      \
    X(MISSING_EDGE, "missing-edge", TOOL, "triangle", "rows on an edge belong to neither side",                        \
      "F: Embree #181 and #174, missed at vertices; verify.cpp tolerates a rate of 2e-5",                              \
      "the two triangles that lose the row cancel, as at a silhouette")                                                \
    X(CONTRACTED_MULTIPLY_ADD, "contracted-multiply-add", TOOL, "triangle",                                            \
      "edge functions in float32 with a fused multiply-add",                                                           \
      "F: FP_CONTRACT is ON by default in OpenCL; PoCL 3.1 fuses on avx2 and not on avx (measured); HIP #1717",        \
      "the sign, which alone decides, stays the same for every row")                                                   \
    X(EXCLUDED_CROSSING, "excluded-crossing", TOOL, "triangle", "a centre on the surface does not count (D > 0)",      \
      "P: > for >=", "another surface enters at the same voxel")                                                       \
    X(NARROW_AREA, "narrow-area", TOOL, "triangle", "the area is computed in 32 bits and wraps",                       \
      "F: edge functions of k bits need 2 k + 2 (R4); signed overflow differs between compilers (measured on PoCL "    \
      "3.1)",                                                                                                          \
      "the sign is correct, or no row is in the triangle")                                                             \
    X(CULLED_BACK_FACES, "culled-back-faces", TOOL, "triangle", "triangles that face lower x are left out",            \
      "P: back-face culling left on in a rasterizing voxelizer", "the triangle owns no row")                           \
    X(TRIANGLES_LOST, "triangles-lost", TOOL, "call", "the last count mod 64 triangles are not drawn",                 \
      "P: a global size rounded down to whole work-groups", "those triangles own no row")                              \
    X(CORNER_FOR_CENTRE, "corner-for-centre", TOOL, "call",                                                            \
      "voxels are sampled at their corner instead of their centre", "P: i for i + 1/2",                                \
      "no part of the surface lies between the corner and the centre of a voxel")                                      \
    X(PARITY_FOR_WINDING, "parity-for-winding", TOOL, "call", "the other rule of filling",                             \
      "F: most voxelizers use the even-odd rule", "all winding numbers are 0, 1 or -1, as for every clean mesh")       \
    X(FILLED_LEAK, "filled-leak", TOOL, "row", "a row whose count does not return to 0 is filled nevertheless",        \
      "T: the pass that adjusts densities along x (Table 2.1) has no rule for leaks",                                  \
      "never: the row is not counted as a leaking one")                                                                \
    X(UNCLEARED_COUNTS, "uncleared-counts", TOOL, "row", "a row starts with the counts of the row before",             \
      "P: local memory is not cleared between two uses",                                                               \
      "the sum of both is not 0 exactly where the row's own count is not")                                             \
    X(NONCUTTING_ON_TOP, "noncutting-on-top", TOOL, "call", "a voxel that is solid in both meshes does not cut",       \
      "P: the second mesh is drawn over the first", "the meshes have no voxel in common")                              \
    /* removal */                                                                                                      \
    X(WRONG_MAP_ROUNDING, "wrong-map-rounding", REMOVE, "block", "a block's base is truncated instead of rounded",     \
      "F: RTZ devices, convert_int_rtz by default; only RTE is required of floats, integers divide towards zero",      \
      "no coordinate lies that close to a border of tool voxels (1 in about 10^6 does), or the classes there are "     \
      "equal")                                                                                                         \
    X(FLOAT_BASE, "float-base", REMOVE, "block", "a block's base is computed in float32",                              \
      "P: the matrix is uploaded as float4x4",                                                                         \
      "no coordinate lies within its error of a border, or the classes there are equal")                               \
    X(DRIFTING_MAP, "drifting-map", REMOVE, "call",                                                                    \
      "steps are added from voxel (0, 0, 0) on instead of from the block's first voxel",                               \
      "P: one base for the complete grid; the rounding of a step grows with the distance",                             \
      "the steps are exact, or no coordinate lies within the drift of a border")                                       \
    X(TRUNCATED_STEP, "truncated-step", REMOVE, "pose", "steps are truncated instead of rounded",                      \
      "F: integers divide towards zero",                                                                               \
      "no coordinate lies within 45 units of a border, or the classes there are equal")                                \
    X(TRANSPOSED_MATRIX, "transposed-matrix", REMOVE, "pose", "rows and columns of the rotation are exchanged",        \
      "P: a row-major matrix read as column-major",                                                                    \
      "the rotation is so small, or the tool so round, that the same voxels are hit")                                  \
    X(MUL24, "mul24", REMOVE, "pose", "steps are multiplied by mul24",                                                 \
      "F: mul24 is implementation-defined for operands beyond 24 bits; a step is one when a bone voxel has 8 tool "    \
      "voxels or more",                                                                                                \
      "no part of the tool is at the wrapped position or at the correct one")                                          \
    X(WRAPPED_FAR_BLOCK, "wrapped-far-block", REMOVE, "block",                                                         \
      "far blocks are not skipped and their base wraps in 32 bits",                                                    \
      "F: no signed overflow may be relied upon (R3); AR-MAP-5 is the rule that forbids it",                           \
      "the wrapped coordinates miss the tool, which has 1024 of 4096 tool voxels an axis at the most")                 \
    X(TRUNCATED_NEGATIVE, "truncated-negative", REMOVE, "pose",                                                        \
      "u / 2^20 is rounded towards zero, so a point up to one voxel before the tool counts as inside",                 \
      "F: convert_int_rtz, C's division; OpenCL's >> of a negative number is defined and right",                       \
      "the outer layer of the tool is void, as it is for every voxelized mesh (AR-TOOL-2)")                            \
    X(BORDER_INCLUDED, "border-included", REMOVE, "pose",                                                              \
      "<= dims counts as inside, so the voxel after a row's end is the first of the next row", "P: <= for <",          \
      "the outer layer of the tool is void, as it is for every voxelized mesh (AR-TOOL-2)")                            \
    X(MISSED_BARRIER, "missed-barrier", REMOVE, "block",                                                               \
      "the second half of a block's voxels uses the base of the previous block",                                       \
      "F: Oclgrind and GPUVerify find races only in the code that they run; a work-group's later waves read local "    \
      "memory too early",                                                                                              \
      "no active voxel of that half changes its class")                                                                \
    X(STALE_POSE, "stale-pose", REMOVE, "call", "the first pose is the last one of the previous event",                \
      "P: a kernel's argument is not set again",                                                                       \
      "both poses hit the same voxels, or the other poses of the sweep cover the difference")                          \
    X(OMITTED_SWEEP_STEP, "omitted-sweep-step", REMOVE, "pose", "one pose of a sweep, not the last, is left out",      \
      "P: k < n - 1; or a queue that drops elements when it is full",                                                  \
      "the neighbouring poses hit the same voxels, as they nearly always do for thick tools")                          \
    X(TIGHT_BOX, "tight-box", REMOVE, "pose", "the last layer of a pose's box is left out on each axis",               \
      "T: Alg. 2.9, floor and ceiling exchanged",                                                                      \
      "the box is larger than necessary, as osteon's own boxes are, and does not end at the grid's border")            \
    X(NON_CUTTING_CUTS, "non-cutting-cuts", REMOVE, "call", "every solid tool voxel cuts",                             \
      "P: != 0 for == 1; the thesis' tools have only 0 and 1",                                                         \
      "every voxel that such a part touches is hit at another pose")                                                   \
    X(TOUCHED_THOUGH_HIT, "touched-though-hit", REMOVE, "call",                                                        \
      "a voxel that is hit at one pose and touched at another counts as both", "P: poses counted one by one",          \
      "never: the number of touched voxels is in the report")                                                          \
    X(LAST_CHUNK_LOST, "last-chunk-lost", REMOVE, "call", "the last chunk with a hit is not processed",                \
      "P: a list of chunks that is one short", "never: its hits are not in the report")                                \
    X(STALE_CHUNK, "stale-chunk", REMOVE, "chunk", "a chunk's hits are reported, but its memory is not changed",       \
      "P: a cached copy that is not written back, a transfer that is not waited for",                                  \
      "never, unless the event only collides")                                                                         \
    X(OCCUPANCY_NOT_CLEARED, "occupancy-not-cleared", REMOVE, "chunk", "densities become 0, occupancy bits stay set",  \
      "P: two arrays for one fact, only one of which is updated",                                                      \
      "the tool does not reach the voxels again; otherwise the number of active voxels differs")                       \
    X(FREED_TOO_EARLY, "freed-too-early", REMOVE, "chunk",                                                             \
      "a chunk's counter is decremented once per hit and pose, so the chunk is freed while it has active voxels",      \
      "P: atomic_dec without a test of whether the bit was still set", "the counter stays above 0")                    \
    X(LOST_CHUNK_REPORT, "lost-chunk-report", REMOVE, "chunk", "the report lacks one chunk",                           \
      "P: two work-groups write to the same element of a list", "never: the report is one chunk shorter")              \
    X(COUNTED_PER_POSE, "counted-per-pose", REMOVE, "chunk", "a voxel hit at several poses counts several times",      \
      "P: atomic_inc without a test of whether the bit was still set", "never: the counts are in the report")          \
    X(CLASS_BORDER, "class-border", REMOVE, "chunk", "a density on the border of two classes counts in the lower one", \
      "P: > for >=", "never: the counts are in the report")                                                            \
    X(FLOAT_SUM, "float-sum", REMOVE, "chunk", "densities are summed in float32",                                      \
      "F: exact to 2^24 only, and dependent on the order; OpenMP 5.2 5.5.6 leaves the order open",                     \
      "the roundings cancel out")                                                                                      \
    X(FLIP_BIT, "flip-bit", REMOVE, "call", "one bit of one density flips", "P: memory without error correction",      \
      "never")                                                                                                         \
    /* other programs */                                                                                               \
    X(THESIS_F32, "thesis-f32", EVERY, "everything",                                                                   \
      "the thesis' float arithmetic, written out: Algs. 2.1, 2.3 to 2.6, 2.8 to 2.10", "T: as printed",                \
      "sizes and positions are such that every float is exact")                                                        \
    X(THESIS_F32_FMA, "thesis-f32-fma", EVERY, "everything",                                                           \
      "the thesis' float arithmetic with every multiply-add fused",                                                    \
      "T and F: as printed, translated by a compiler that contracts",                                                  \
      "sizes and positions are such that every float is exact")

typedef enum deviation_kind {
    DEVIATION_NONE,
#define DEVIATION_ENUM(kind, name, stage, unit, what, cause, survives) DEVIATION_##kind,
    DEVIATION_LIST(DEVIATION_ENUM)
#undef DEVIATION_ENUM
    DEVIATION_KINDS
} deviation_kind;

typedef struct deviation {
    deviation_kind kind;
    uint64_t seed;
    uint32_t one_in;
} deviation;

typedef struct deviation_about {
    const char *name, *unit, *what, *cause, *survives;
    deviation_stage stage;
} deviation_about;

/* Returns the description of a kind of mistake. DEVIATION_NONE is not allowed. */
const deviation_about *deviation_describe(deviation_kind kind);
/* Returns the name of a stage, such as "rect". */
const char *deviation_stage_name(deviation_stage stage);

/*
 * The position of an effect. `leaf` is the number of a cube of 32^3 voxels, as in a digest. `leaf` and the three
 * elements of `voxel` are -1 if the effect is in a line of the report or concerns the call as a whole. `chunk` is the
 * number of a chunk of the bone, or -1 if there is none. If a call has several effects, the lowest voxel (in the order
 * of AR-GRID-2), the lowest leaf and the lowest chunk are stored. They may come from different effects.
 */
typedef struct deviation_position {
    deviation_stage stage;
    uint64_t call; /* number of earlier calls of the stage since the backend was opened */
    int64_t item;  /* index of the sample, chunk, triangle or other unit; -1 for first_changed */
    int32_t voxel[3];
    int64_t leaf;
    int64_t chunk;
} deviation_position;

typedef struct deviation_record {
    /* number of times the mistake acted, and number of results it changed; first_acted is valid if acted > 0, and
       first_changed is valid if changed > 0 */
    uint64_t acted, changed;
    deviation_position first_acted, first_changed;
    bool report; /* true if the first changed result is in the report */
    bool voxels; /* true if the first changed result is in the grid */
} deviation_record;

#endif
