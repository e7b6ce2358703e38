/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The interface between host and device.  This file describes the layout of every
 * buffer and, for every kernel, its arguments, its range, and why its results do not
 * depend on the order of work items.  The file is valid C11 and valid OpenCL C 1.2.
 *
 * A program consists of this file, common.h, and the .cl files of this folder in alphabetical order, one after the
 * other; none of them includes another. fingerprint_float.cl is a separate program, because this program contains no
 * float.
 *
 *   samples --ost_ct_*--> rect --ost_cubic_*--> cubic --ost_chunk_*--> pool of chunks
 *   triangles --ost_vox_*--> classes --ost_tool_reach--> cells         |
 *                                              '-------ost_remove------+--> a report per block
 *
 * For all kernels
 *   - Structs have fixed-width members, each at a multiple of its size, and
 *     no padding; they are passed in buffers, never by value.
 *   - A range may be rounded up along each of its dimensions (to a multiple of
 *     the work-group size).  Items beyond the range that the parameters define
 *     return at once.  The work-group size never affects results.  No kernel has
 *     a barrier or local memory.
 *   - If an item writes an element without an atomic, no other item of the launch
 *     reads or writes this element.  All other writes are 32-bit atomics of commuting
 *     operations (add, min, max, or, and, xchg with one value), whose old values
 *     do not affect any result.
 *   - Indices into buffers are 64 bits wide.  int is at least as wide as the
 *     ranges of docs/spec/arithmetic.md, section 18, require.
 *   - The build option -DOST_FOR=d selects the kernel sets: for devices that run
 *     many small work items (d & 1, GPUs) or few large ones (d & 2, CPUs).  If
 *     both sets have a kernel for the same work, the results are the same.  The
 *     default is 3, both sets.
 *   - The build option -DOST_ROWS=r with r = 1, 2, 4, 8 or 16 is the number of rows
 *     that a work item of ost_remove processes (1 suits GPUs; default 4).
 *   - The build option -DOST_RUN=v is the number of adjacent voxels along x that a
 *     work item of ost_cubic_gather and ost_cubic_linear computes (many suit CPUs,
 *     1 suits GPUs; default 3).
 */
#ifndef OST_CL_SHARED_H
#define OST_CL_SHARED_H

#ifdef __OPENCL_VERSION__
typedef char ost_cl_i8;
typedef uchar ost_cl_u8;
typedef short ost_cl_i16;
typedef ushort ost_cl_u16;
typedef int ost_cl_i32;
typedef uint ost_cl_u32;
typedef long ost_cl_i64;
typedef ulong ost_cl_u64;
#else
#include <stdint.h>
typedef int8_t ost_cl_i8;
typedef uint8_t ost_cl_u8;
typedef int16_t ost_cl_i16;
typedef uint16_t ost_cl_u16;
typedef int32_t ost_cl_i32;
typedef uint32_t ost_cl_u32;
typedef int64_t ost_cl_i64;
typedef uint64_t ost_cl_u64;
#endif

#define OST_CL_NONE 0xffffffffu /* a value that means no line, no sample or no slot */

/* ------------------------------------------------- samples to rect grid */
/*
 * Samples to the rect grid (AR-CT-4..6).  A batch of samples needs three launches, in
 * this order (one dimension, count items), and two more only after a conflict:
 *
 *   ost_ct_claim(scatter, samples, seen, owner, report)
 *   ost_ct_place(scatter, samples, seen, owner, voxels, report)
 *   ost_ct_check(scatter, samples, seen, owner, voxels, report)
 *   ost_ct_report_first_bad(scatter, samples, voxels, report)                only after a conflict
 *   ost_ct_had(scatter, samples, voxels, report)                  only after a conflict; one item
 *
 *   scatter  const ost_cl_scatter[1]
 *   samples  const ost_cl_sample[count]   the same bytes as ost_sample
 *   seen     uint[ceil(voxels / 32)]      bit v: voxel v was set by an earlier batch; zeros at first
 *   owner    uint[voxels]                 zeros before and after each batch
 *   voxels   short[voxels]                the rect grid
 *   report   ost_cl_scatter_report[1]     of the batch; at first, lines and index are OST_CL_NONE, all else is 0
 *
 * ost_ct_claim: For every readable sample inside the grid, atomic_max raises the owner of the sample's voxel to the
 * sample's key. The sample that determines the voxel's density has the greatest key: the earliest sample (rules
 * `error` and `first`), the latest (`last`) or the densest (`max`). Exactly one sample of each voxel finds the previous
 * owner 0; which one may vary. This sample is a duplicate only if the voxel's bit of `seen` is 1. All other samples of
 * the voxel are duplicates. The number of duplicates therefore does not vary.
 * ost_ct_place: The sample with the greatest key writes its voxel. Keys are unique, except with the rule `max`: several
 * samples of the same density may then have the greatest key, and the first of them that sets a flag writes the voxel.
 * The kernel also finds the first line with the worst offset.
 * ost_ct_check: Updates `seen` and clears `owner`. With the rule `error`, a voxel that is set does not change again.
 * The kernel then also finds the lowest line whose sample differs in density from its voxel.
 * ost_ct_report_first_bad: Finds the first sample whose density differs, on the line that ost_ct_check has found.
 * ost_ct_had: Reads the density of this sample's voxel.
 *
 * The host combines the report of the batch with the reports of earlier batches. Counts are added. Of the two worst
 * offsets, the greater one is used; if they are equal and above 0, the lower line is used. Of the other line numbers,
 * the lower one is used. Before lines are compared, the batch's first_line is added to them. The host sets conflict_has
 * to the density of sample conflict_index. count <= 2^31 - 2, and no line equals OST_CL_NONE.
 */
enum { OST_CL_DUPLICATES_ERROR, OST_CL_DUPLICATES_FIRST, OST_CL_DUPLICATES_LAST, OST_CL_DUPLICATES_MAX };

typedef struct ost_cl_sample {
    ost_cl_i64 at[3]; /* pm */
    ost_cl_i32 density;
    ost_cl_u32 line;
} ost_cl_sample;

typedef struct ost_cl_scatter {
    ost_cl_i64 origin[3], spacing[3]; /* pm */
    ost_cl_i32 dims[3];
    ost_cl_i32 duplicates; /* OST_CL_DUPLICATES_*, equal to ost_duplicates */
    ost_cl_u32 count;
    ost_cl_u32 unused;
} ost_cl_scatter;

typedef struct ost_cl_scatter_report {
    ost_cl_u32 duplicates, off_lattice;
    ost_cl_u32 worst_ppm, worst_line;
    ost_cl_u32 rejected_line;
    ost_cl_u32 conflict_line, conflict_index;
    ost_cl_i32 conflict_had;
} ost_cl_scatter_report;

/* ---------------------------------------------------- rect grid to cubic */
/*
 * The rect grid to the cubic grid (AR-CUB).
 *
 *   ost_cubic_sources(cubic, sources)            one dimension: sum of cubic dims
 *   ost_cubic_gather(cubic, sources, rect, out)  nearest, thesis: cubic dims.x / OST_RUN or more, dims.y, z1 - z0
 *   ost_cubic_linear(cubic, sources, rect, out)  linear: the range of ost_cubic_gather
 *
 *   cubic    const ost_cl_cubic[1]
 *   sources  int[2 * (dims.x + dims.y + dims.z)]   source index of each voxel along x, then y, then z; then, in this
 *                                            order, the weight of the upper neighbour of each source, 0 to 2^15 (0:
 *                                            the neighbour is not read)
 *   rect     const short[rect voxels]
 *   out      short[...]                      the entire cubic grid, or slices z0 <= k < z1 of it if `slab` is 1
 *
 * Each item writes OST_RUN elements along x, which no other item writes.
 */
enum { OST_CL_RESAMPLE_LINEAR, OST_CL_RESAMPLE_NEAREST, OST_CL_RESAMPLE_THESIS };

typedef struct ost_cl_cubic {
    ost_cl_i64 rect_spacing[3], cubic_spacing[3];
    ost_cl_i32 rect_dims[3], dims[3];
    ost_cl_i32 rule; /* OST_CL_RESAMPLE_*, equal to ost_resample */
    ost_cl_i32 z0, z1;
    ost_cl_i32 slab; /* 1 if `out` starts with slice z0; 0 if it starts with slice 0 */
} ost_cl_cubic;

/* ---------------------------------------------------------------- chunks */
/*
 * Chunks (AR-CHK). A bone on the device is a pool of slots, each with the memory of one
 * chunk of n^3 voxels, and a table that maps chunk numbers to slots:
 *
 *   bone     const ost_cl_bone[1]
 *   slots    uint[chunks]           slot of a chunk, OST_CL_NONE if the chunk has no memory
 *   density  short[slots * n^3]     voxel v = x + n (y + n z) of the chunk in slot s: s n^3 + v
 *   words    uint[slots * n^3 / 32] the chunk's occupancy: voxel v has bit v % 32 of word v / 32 (AR-CHK-4)
 *   slab     short[(z1 - z0) dims.y dims.x]  slices z0 <= k < z1 of the grid without padding;
 *                                            z0 and z1 are int arguments
 *
 *   Slice k of the grid has the index layers[first + k - z0] in the slab or, if first < 0, the index k - z0.  Therefore
 *   a grid that was resampled only along z is read from the original grid, and equal slices are read only once.  If
 *   weights >= 0 (and first >= 0), slice k is the weighted mean of the slice with this index and the next slice of the
 *   slab.  The weight of the next slice is layers[weights + k - z0] / 2^15.  If it is 0, the next slice may not exist.
 *   The buffer `layers` has no further elements, and its slice numbers ascend.  The buffer is not used if first < 0.
 *
 *   The description of each kernel begins with its range.
 *
 *   ost_chunk_scan(bone, z0, z1, first, weights, layers, slab, active)
 *       z1 - z0, chunk_dims.x * chunk_dims.y.  Counts the chunk's voxels in the slab that are at least the threshold,
 *       and adds the count to active[chunk] (uint[chunks], zeros at first).
 *   ost_chunk_scan_layers(...)
 *       chunk_dims.y, chunk_dims.z.  ost_chunk_scan for CPUs: an item processes a row of chunks along x.
 *   ost_chunk_store(bone, z0, z1, first, weights, layers, slab, slots, density, words)
 *       n * n / 32, chunk_dims.x * chunk_dims.y, z1 - z0.  An item writes one word and its 32 densities, if the chunk
 *       has a slot.  Voxels below the threshold become 0, and so do those in the padding beyond dims.x or dims.y.
 *       Planes of padding beyond dims.z are never written: a slot is filled with zeros before it is used.
 *   ost_chunk_store_layers(...)
 *       chunk_dims.x * chunk_dims.y, chunk_dims.z.  ost_chunk_store for CPUs: an item processes a chunk.  With the last
 *       slice (dims.z - 1) it also writes the planes of padding.
 *   ost_chunk_load(bone, z0, z1, slots, density, slab)
 *       dims.x, dims.y, z1 - z0.  The inverse of storing; chunks without a slot are read as 0.
 *   ost_chunk_load_rows(...)
 *       chunk_dims.y, z1 - z0.  ost_chunk_load for CPUs: an item processes a slice of a row of chunks along x.
 *   ost_chunk_count(bone, first, count, words, active)
 *       n, count.  For i < count, adds the number of bits that are set in slot first + i to active[i] (uint[count],
 *       zeros at first).
 */
typedef struct ost_cl_bone {
    ost_cl_i32 dims[3];
    ost_cl_i32 size; /* edge length n of a chunk in voxels: 16, 32 or 64 */
    ost_cl_i32 chunk_dims[3];
    ost_cl_i32 threshold;
} ost_cl_bone;

/* ------------------------------------------------------------- voxelizer */
/*
 * Voxelization (AR-VOX) by triangle, for the slices k0 <= k < k1 of the grid, so that the buffer of steps can be
 * smaller than the grid.
 *
 *   ost_vox_steps(vox, vertices, triangles, steps)   triangles, bands
 *   ost_vox_fill(vox, steps, classes, leaks)         dims.y, k1 - k0
 *   ost_vox_count(vox, classes, counts)              dims.y, k1 - k0
 *
 *   vox        const ost_cl_vox[1]
 *   vertices   const int[3 * vertices], triangles const uint[3 * triangles]: as in ost_snapped_mesh
 *   steps      int[(k1 - k0) * dims.y * (dims.x + 1)]   zeros before ost_vox_steps and after ost_vox_fill
 *   classes    uchar[dims.x * dims.y * dims.z]          the entire tool, zeros at first
 *   leaks      uint[1]                                  incremented by the number of rows that leak
 *   counts     uint[2 * dims.z]                         the numbers of solid and of cutting voxels of slice k are
 *                                                       added to elements 2 k and 2 k + 1
 *
 * ost_vox_steps: item (t, b) processes slices b, b + bands, ... of the slices that triangle t overlaps.  It adds the
 * triangle's +1 or -1 in every row that the triangle owns, by atomic_add.  If there are few triangles, bands > 1
 * results in more items.
 * ost_vox_fill: an item sums one row.  It sets the class of solid voxels to tool_class and leaves other voxels
 * unchanged.  The kernel is launched for the noncutting mesh first, then for the cutting mesh.
 */
enum { OST_CL_FILL_WINDING, OST_CL_FILL_PARITY };

typedef struct ost_cl_vox {
    ost_cl_i32 dims[3];
    ost_cl_i32 fraction; /* f */
    ost_cl_i32 k0, k1;
    ost_cl_u32 triangles, bands;
    ost_cl_i32 rule;       /* OST_CL_FILL_*, equal to ost_fill_rule */
    ost_cl_i32 tool_class; /* 1 or 2 */
} ost_cl_vox;

/*
 * Voxelization (AR-VOX) by tiles, for CPUs, with one launch per mesh:
 *
 *   ost_vox_tiles(tiles, vertices, triangles, start, list, steps, marks, classes, counts)   count[0], count[1]
 *
 *   tiles    const ost_cl_tiles[1]
 *   start    const uint[lists + 1], list const uint[start[lists]]: list number l consists of the elements
 *            start[l] <= e < start[l + 1] of list.  For tile (y, z) and slice k, list l = y + count[0] (k / layer)
 *            includes all triangles whose bounds contain the centre of a row of the tile in this slice; further
 *            triangles do not change the result
 *   steps    int[tiles * pass * height * (dims.x + 1)], marks ulong[tiles * pass * height * (dims.x / 64 + 1)]:
 *            scratch, any content
 *   classes  uchar[dims.x * dims.y * dims.z]   all classes are written; if `over` is 1, only those of the mesh's voxels
 *   counts   ulong[3 * tiles]                  for each tile, the numbers of solid voxels, of cutting voxels and of
 *                                              rows that leak, for all meshes so far
 */
typedef struct ost_cl_tiles {
    ost_cl_i32 dims[3];
    ost_cl_i32 fraction;
    ost_cl_i32 height, depth; /* rows (along y) and slices per tile */
    ost_cl_i32 count[2];      /* number of tiles along y, and along z */
    ost_cl_i32 rule;
    ost_cl_i32 tool_class;
    ost_cl_i32 over; /* 1 for the second mesh, whose classes are added to those of the first */
    ost_cl_i32 layer; /* number of slices per list of triangles */
    ost_cl_i32 pass;  /* maximum number of slices of a tile that are processed together */
} ost_cl_tiles;

/* ----------------------------------------------------------- tool cells */
/*
 * A cell contains the class of a tool voxel in bits 0 and 1 and the reach of the voxel in bits 2 to 7.  The
 * reach is the greatest r <= 63 such that all voxels nearer than r on every axis have the same class as the
 * voxel; all space outside the grid is empty.  Only the voxel itself is nearer than 1, so reach >= 1.
 *
 *   ost_tool_reach(tool, from, to)   dims.x, dims.y, dims.z; three launches, axis 0, 1, 2
 *
 *   tool   const ost_cl_tool[1]
 *   from   const uchar[voxels]: for axis 0 the classes, then the result of the previous launch
 *   to     uchar[voxels], a buffer other than from
 *
 * Each item writes its own cell.
 *
 * For ost_remove_blocks, each class c (1, 2) is also stored separately as windows.  A byte contains 8 voxels
 * along x.  There is a byte for every second voxel along x, and the bytes of neighbours along y are adjacent.
 * Therefore any cube of 8^3 voxels whose first x is even can be read by 8 loads of 8 bytes.  Voxels outside
 * the grid are empty.
 *
 *   ost_tool_windows(tool, classes, windows)   OST_CL_WINDOWS_Y(dims.y), _Z(dims.z), tool.axis * _X(dims.x);
 *                                            tool.axis is the number of classes, 1 or 2
 *
 *   windows  uchar[...]   of class 1, then of class 2: byte (i, y, z), y fastest, then z: bit b is 1 if voxel
 *                         (2 i - 8 + b, y - 8, z - 8) has the class
 */
#define OST_CL_WINDOWS_X(n) (((n) + 10) / 2)
#define OST_CL_WINDOWS_Y(n) ((n) + 16)
#define OST_CL_WINDOWS_Z(n) ((n) + 16)

typedef struct ost_cl_tool {
    ost_cl_i32 dims[3];
    ost_cl_i32 axis; /* ost_tool_reach: the axis, 0 to 2; ost_tool_windows: the number of classes */
} ost_cl_tool;

#define OST_CL_REACH_MAX 63

/* --------------------------------------------------------------- removal */
/*
 * Removal and collision (AR-MAP, AR-REM): one launch for all poses and blocks of an event.
 *
 *   ost_remove(event, cells, density, words, reports)                   event.blocks * 256 / OST_ROWS; one dimension
 *   ost_remove_blocks(event, cells, windows, density, words, reports)   event.blocks, rounded up to a multiple of
 *                                                                       OST_CL_BATCHES; one dimension
 *
 *   event    const ost_cl_event[1] and its arrays in one buffer; each array begins at the given offset in bytes, a
 *            multiple of 8:
 *     poses_at     const ost_cl_pose[...]
 *     blocks_at    const ost_cl_block[event.blocks]   16^3 voxels each, aligned to voxel (0, 0, 0), of chunks with a
 *                                                     slot; no block twice
 *     entries_at   const ost_cl_entry[...]            the poses that may reach a block, each with the block's base
 *   cells    const uchar[tool voxels]           dims <= 1024 per axis
 *   windows  const uchar[...]                   of class 1, then, if event.touches, of class 2
 *   density  short[...], words  ushort[...]     the pool; words are the same bytes as in ost_chunk_*, two per uint,
 *                                              little-endian
 *   reports  ost_cl_block_report[event.blocks]  zeros at first (ost_remove_blocks writes all of them)
 *
 * Both kernels compute the same results.  ost_remove is for devices that run many small work items: an item
 * processes OST_ROWS rows of 16 voxels of a block.  Each row has 16 bits of occupancy and 16 densities that no other
 * item accesses.  The item adds its counts to the report of the block by atomic_add.  ost_remove_blocks is for
 * devices with few strong cores and vector instructions: an item processes an entire block and divides it until, for
 * each part, the reach of a tool voxel determines the class of the entire part.  For each entry of the block, the
 * voxels that the tool hits or touches at the entry's pose are marked.  A voxel is hit if it is hit at one or more
 * poses, so the order of entries does not matter.  The counts of a block are at most 4096 voxels and its sums of
 * densities at most 2^12 * 2^15, so they fit in 32 bits.
 *
 * The host omits an entry if the pose's box does not overlap the block, or if the base is far (AR-MAP-5).  It also
 * omits blocks without entries.  Within a block, the kernels apply the box to each voxel, so that boxes have the
 * same meaning in every backend.
 * Entries with far bases are not allowed, because the sums of the kernels would
 * overflow.
 */
#define OST_CL_CLASSES 8
/* number of parts (batches) of an event in ost_remove_blocks; adjacent blocks are in different batches */
#define OST_CL_BATCHES 8

typedef struct ost_cl_event {
    ost_cl_i32 tool_dims[3];
    ost_cl_i32 size; /* n */
    ost_cl_u32 blocks;
    ost_cl_i32 apply; /* 1 to remove voxels; 0 to only report hits */
    ost_cl_i32 classes;
    ost_cl_i32 touches; /* 0 if the tool has no non-cutting voxel (class 2) */
    ost_cl_u32 poses_at, blocks_at, entries_at, unused;
    ost_cl_i32 border[OST_CL_CLASSES];
} ost_cl_event;

typedef struct ost_cl_block {
    ost_cl_i32 first[3]; /* grid coordinates of the block's first voxel, multiples of 16 */
    ost_cl_u32 slot;     /* slot in the pool of the chunk that contains the block */
    /* `entry` is the index of the block's first entry, and `entries` is the number of the block's entries */
    ost_cl_u32 entry, entries;
} ost_cl_block;

typedef struct ost_cl_entry {
    ost_cl_i32 base[3]; /* base of the block (AR-MAP-4), in the range of AR-MAP-5 */
    ost_cl_u32 pose;
} ost_cl_entry;

typedef struct ost_cl_pose {
    ost_cl_i32 step[3][3]; /* steps of the map, indexed [bone axis][tool axis] (ost_map) */
    ost_cl_i32 lo[3], hi[3]; /* the pose's box, lo <= voxel < hi (ost_removal_event) */
    /* The comment of ost_cl_pose_reach explains the fields complete, planes and skip. complete[] is for cubes of 4, 8
       and 16 voxels per edge; a value above OST_CL_REACH_MAX means that no reach is sufficient for such a cube. */
    ost_cl_u8 complete[3];
    /* number of planes of a window that a brick may overlap, 6 or 8; 0 if a brick may be larger than a window */
    ost_cl_u8 planes;
    ost_cl_u8 skip[OST_CL_REACH_MAX + 1];
} ost_cl_pose;

/*
 * For each density class, the number of voxels that are hit and the sum of the densities that these voxels had before
 * the event.
 */
typedef struct ost_cl_block_report {
    ost_cl_u32 voxels[OST_CL_CLASSES];
    ost_cl_u32 density[OST_CL_CLASSES];
    ost_cl_u32 touched;
    ost_cl_u32 unused[3];
} ost_cl_block_report;

/* ----------------------------------------------------------- fingerprint */
/*
 * The fingerprint of a device: integer operations that some drivers compute wrongly. They are tested before a device
 * may compute any voxel. The header cl/fingerprint_expect.h computes the expected results.
 *
 *   ost_fingerprint(count, in, out)               count items; out[OST_CL_FINGERPRINT i + k] from in[2 i], in[2 i + 1]
 *   ost_fingerprint_atomics(count, in, counters)  count items; counters uint[OST_CL_FINGERPRINT_COUNTERS], see
 *                                                 fingerprint.cl
 *
 *   ost_fingerprint_turns(end, turns)             one item; turns uint[2]: the number of iterations of a loop that
 *                                                 ends at the value `end`, and the last value. The number is
 *                                                 OST_CL_TURNS unless the device ends the loop early.
 *
 *   in  const ulong[2 * count], out  ulong[OST_CL_FINGERPRINT * count]
 *
 * and, in a separate program (fingerprint_float.cl), for information only:
 *
 *   ost_fingerprint_float(count, in, out)         count items; out[OST_CL_FLOATS i + k] bits from
 *                                                 float bits in[3 i ...]
 */
#define OST_CL_FINGERPRINT 32
#define OST_CL_FINGERPRINT_COUNTERS 16

/*
 * Limits on the number of iterations (turns) of a work item, summed over its loops.  In kernels for CPUs, the number
 * of turns depends on the size of the tile or block.  Kernels for GPUs have at most
 *
 *   ost_vox_steps   15 turns per row, with one slice per item: 2^12 rows of one turn, at most 13 turns of bisection,
 *                   and one turn that ends the bisection
 *   ost_remove      18 turns per pose (16 look-ups, the turn of the pose, and the turn that ends the loop of
 *                   look-ups), and 400 turns for the rest of a row
 *   others          fewer than 2^14 turns
 *
 * If a device allows fewer than OST_CL_TURNS turns, it must therefore allow at least OST_CL_TURNS_LEAST turns, and its
 * events are limited to OST_CL_TURNS_POSES poses.
 */
#define OST_CL_TURNS 0x40000u
#define OST_CL_TURNS_LEAST (15u * 4096u + 64u)
#define OST_CL_TURNS_POSES(turns) (((turns) - 400u) / 18u)

/* Returns the value after x in a sequence that repeats only after all 2^32 values of uint. */
#define OST_CL_NEXT_TURN(x) ((x) * 1664525u + 1013904223u)
#define OST_CL_FLOATS 16

/* ------------------------------------------------------------------ host */
#ifndef __OPENCL_VERSION__
_Static_assert(sizeof(ost_cl_sample) == 32, "layout");
_Static_assert(sizeof(ost_cl_scatter) == 72, "layout");
_Static_assert(sizeof(ost_cl_scatter_report) == 32, "layout");
_Static_assert(sizeof(ost_cl_cubic) == 88, "layout");
_Static_assert(sizeof(ost_cl_bone) == 32, "layout");
_Static_assert(sizeof(ost_cl_vox) == 40, "layout");
_Static_assert(sizeof(ost_cl_tiles) == 52, "layout");
_Static_assert(sizeof(ost_cl_tool) == 16, "layout");
_Static_assert(sizeof(ost_cl_event) == 80, "layout");
_Static_assert(sizeof(ost_cl_block) == 24, "layout");
_Static_assert(sizeof(ost_cl_entry) == 16, "layout");
_Static_assert(sizeof(ost_cl_pose) == 128, "layout");
_Static_assert(sizeof(ost_cl_block_report) == 80, "layout");

/*
 * skip[r]: if the cell of a voxel has the reach r, the next skip[r] voxels of the row, at most 15,
 * certainly have the class of this cell.  Let m be the greatest |step[0][a]|. At a distance of j voxels, a coordinate
 * differs by at most j m, so its tool voxel differs by at most floor(j m / 2^20) + 1. This number is < r if
 * j m < (r - 1) 2^20. m <= 2^24 + 1, so all these values are below 2^29.
 *
 * complete[c]: the least reach r with which the cell at the middle of a cube of e = 4 << c voxels
 * per edge determines the class of the entire cube.  The middle is the first voxel's coordinate
 * plus (e - 1) / 2 of the three steps, rounded to integer units.  Let t be the sum of the three |step[b][a]|. A
 * coordinate of the cube differs from that of the middle by at most d = ((e - 1) t + 1) / 2, so its tool voxel differs
 * by at most floor(d / 2^20) + 1. This number must be < r. 15 t < 2^29 (AR-MAP-5).
 *
 * planes: along an axis, the coordinates of a brick are at most 3 t above the least coordinate. The brick's tool voxels
 * are therefore the voxel of the least coordinate and at most floor(3 t / 2^20) + 1 further voxels. A window begins
 * with the voxel of the least coordinate or, along x, at most one voxel before. Therefore 8 voxels contain a brick
 * if 3 t < 7 * 2^20 (along x, if 3 t < 6 * 2^20), and 6 planes along z contain a brick if 3 t < 5 * 2^20. With 0.94
 * tool voxels per bone voxel, 3 t < 4.9 * 2^20 in any rotation.
 */
static inline void ost_cl_pose_reach(ost_cl_pose *pose)
{
    const ost_cl_i32 fits[3] = {6, 7, 7};
    ost_cl_i32 m = 0, t = 0;
    pose->planes = 6;
    for (int a = 0; a < 3; a++) {
        ost_cl_i32 sum = 0;
        for (int b = 0; b < 3; b++) {
            const ost_cl_i32 s = pose->step[b][a] < 0 ? -pose->step[b][a] : pose->step[b][a];
            m = b == 0 && s > m ? s : m;
            sum += s;
        }
        t = sum > t ? sum : t;
        if (3 * sum >= fits[a] * (1 << 20))
            pose->planes = 0;
        else if (a == 2 && pose->planes && 3 * sum >= 5 * (1 << 20))
            pose->planes = 8;
    }
    for (int c = 0; c < 3; c++) {
        const ost_cl_i32 r = ((((4 << c) - 1) * t + 1) / 2 + 1) / (1 << 20) + 2;
        pose->complete[c] = (ost_cl_u8)(r > OST_CL_REACH_MAX ? OST_CL_REACH_MAX + 1 : r);
    }
    ost_cl_i32 j = 0;
    for (ost_cl_i32 r = 0; r <= OST_CL_REACH_MAX; r++) {
        while (j < 15 && r >= 2 && (j + 1) * m < (r - 1) * (1 << 20))
            j++;
        pose->skip[r] = (ost_cl_u8)j;
    }
}
#endif
#endif
