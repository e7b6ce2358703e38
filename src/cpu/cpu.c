/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the CPU backend with its options, and defines its function table. */
#include "cpu/cpu.h"
#include "cpu/face_mesh.h"
#include "cpu/voxelize/embree.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"
#include "cpu/voxelize/voxelize.h"

#include <stdlib.h>
#include <string.h>
#if defined _OPENMP
#include <omp.h>
#endif

#include "cpu/tool.h"

enum { THREADS_MAX = 1024 };

static bool available(char *reason, size_t size)
{
    if (size)
        reason[0] = 0;
    return true;
}

static int default_threads(void)
{
#if defined _OPENMP
    const int most = omp_get_max_threads(); /* OMP_NUM_THREADS if it is set, otherwise the number of cores */
    return most < THREADS_MAX ? most : THREADS_MAX;
#else
    return 1;
#endif
}

static ost_status set_threads(const char *value, int *threads, ost_error *err)
{
    /* The digits are counted first, because strtol would also accept leading spaces and a sign. */
    const size_t digits = strspn(value, "0123456789");
    const long n = digits > 0 && digits < 6 && !value[digits] ? strtol(value, NULL, 10) : 0;
    if (n < 1 || n > THREADS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "backend cpu: threads=%.20s; expected a number from 1 to %d", value,
                        THREADS_MAX);
    *threads = (int)n;
    return OST_OK;
}

static ost_status set_number(const char *key, const char *value, int64_t *number, ost_error *err)
{
    const size_t digits = strspn(value, "0123456789");
    const long long n = digits > 0 && digits < 11 && !value[digits] ? strtoll(value, NULL, 10) : 0;
    if (n < 1)
        return ost_fail(err, OST_ERR_USAGE, "backend cpu: %s%.20s; expected a number from 1 to 9999999999", key, value);
    *number = n;
    return OST_OK;
}

static ost_status set_voxelizer(const char *value, ost_voxelizer *voxelizer, ost_error *err)
{
    static const char *const names[] = {"auto", "triangles", "embree"};
    for (int i = 0; i < 3; i++) {
        if (strcmp(value, names[i]) != 0)
            continue;
        *voxelizer = (ost_voxelizer)i;
        return *voxelizer == OST_VOXELIZER_EMBREE ? ost_embree_available(err) : OST_OK;
    }
    return ost_fail(err, OST_ERR_USAGE, "backend cpu: voxelizer=%.20s; expected auto, triangles or embree", value);
}

typedef struct cpu_options {
    const char *isa;
    int threads;
    int64_t grain; /* one threshold for all paths (share.h); 0 selects the measured thresholds */
    int64_t order; /* seed of the random order in which blocks are processed (share.h); 0 selects the usual order */
    ost_voxelizer voxelizer;
    unsigned given; /* bit k is set if the option named keys[k] was given */
} cpu_options;

/* Parses one "key=value". */
static ost_status set_option(const char *option, cpu_options *options, ost_error *err)
{
    static const char *const keys[] = {"isa=", "threads=", "grain=", "order=", "voxelizer="};
    for (int key = 0; key < 5; key++) {
        const size_t length = strlen(keys[key]);
        if (strncmp(option, keys[key], length) != 0)
            continue;
        if (options->given & 1u << key)
            return ost_fail(err, OST_ERR_USAGE, "backend cpu: %s is given twice", keys[key]);
        options->given |= 1u << key;
        const char *value = option + length;
        switch (key) {
        case 0:
            options->isa = value;
            return *value ? OST_OK : ost_fail(err, OST_ERR_USAGE, "backend cpu: isa= needs the name of an "
                                              "instruction set; see osteon devices");
        case 1:
            return set_threads(value, &options->threads, err);
        case 2:
            return set_number("grain=", value, &options->grain, err);
        case 3:
            return set_number("order=", value, &options->order, err);
        default:
            return set_voxelizer(value, &options->voxelizer, err);
        }
    }
    return ost_fail(err, OST_ERR_USAGE, "backend cpu: unknown option '%.40s'; expected isa=NAME, threads=N, grain=N, "
                    "order=N or voxelizer=NAME", option);
}

/* Parses a comma-separated list of options. Replaces the commas in `text` with zero bytes. Strings in *options
   point into `text`. */
static ost_status read_options(char *text, cpu_options *options, ost_error *err)
{
    ost_status status = OST_OK;
    for (char *option = text; option && *option && status == OST_OK;) {
        char *comma = strchr(option, ',');
        if (comma)
            *comma++ = 0;
        status = set_option(option, options, err);
        option = comma;
    }
    return status;
}

static ost_status open_cpu(const char *options, ost_backend **out, ost_error *err)
{
    cpu_options chosen = {.threads = default_threads()};
    cpu_backend *backend = NULL;
    ost_backend *ref = NULL;
    char *text = strdup(options);
    ost_status status = OST_OK;
    if (!text)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for backend cpu");
    if (status == OST_OK)
        status = read_options(text, &chosen, err);
    ost_isa level = OST_ISA_SCALAR;
    if (status == OST_OK)
        status = ost_isa_choose(chosen.isa, &level, err);
    if (status == OST_OK)
        status = ost_backend_ref.open("", &ref, err);
    ost_cpu_sharing *sharing = NULL;
    if (status == OST_OK && !(sharing = malloc(sizeof *sharing)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for backend cpu");
    /*
     * The backend contains tables that are aligned to cache lines, so its memory must have this alignment.
     * The size of the backend is a multiple of the alignment, as aligned_alloc requires.
     */
    if (status == OST_OK && !(backend = aligned_alloc(_Alignof(cpu_backend), sizeof *backend)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for backend cpu");
    if (status == OST_OK) {
        memset(backend, 0, sizeof *backend);
        backend->ref = *(const ref_backend *)ref;
        backend->isa = level;
        backend->threads = chosen.threads;
        backend->voxelizer = chosen.voxelizer;
        backend->sharing = sharing;
        ost_cpu_sharing_init(sharing, chosen.grain, (uint64_t)chosen.order);
        sharing = NULL;
        ost_cpu_kernels_fill(&backend->kernels, level);
        *out = &backend->ref.base;
    }
    if (ref)
        ost_backend_ref.close(ref);
    free(sharing);
    free(text);
    return status;
}

static void close_cpu(ost_backend *base)
{
    cpu_backend *backend = (cpu_backend *)base;
    ost_event_scratch_free(&backend->event);
    for (int i = 0; i < 3; i++)
        ost_chunk_pool_close(backend->pools[i]);
    free(backend->sharing);
    free(backend);
}

static ost_backend_settings settings(const ost_backend *base)
{
    const cpu_backend *backend = (const cpu_backend *)base;
    return (ost_backend_settings){
        .isa = ost_isa_name(backend->isa), .threads = backend->threads, .platform = -1, .device = -1};
}

static void visit_paths(const ost_backend *base, ost_path_visit *visit, void *user)
{
    const cpu_backend *backend = (const cpu_backend *)base;
    ost_cpu_sharing_visit(backend->sharing, backend->threads, visit, user);
}

/* Does nothing: every function of this backend has finished its work when it returns. */
static ost_status finish(ost_backend *backend, ost_error *err)
{
    (void)backend;
    (void)err;
    return OST_OK;
}

const ost_backend_ops ost_backend_cpu = {
    .name = "cpu",
    .description = "vectorised by hand, on all cores; options isa=scalar|avx2|avx512|avx512vbmi|neon, threads=N, "
                   "grain=N, order=N, voxelizer=auto|triangles|embree",
    .available = available,
    .devices = ost_no_devices,
    .open = open_cpu,
    .close = close_cpu,
    .settings = settings,
    .paths = visit_paths,
    .finish = finish,
    .grid_create = ost_cpu_grid_create,
    .grid_free = ost_cpu_grid_free,
    .grid_upload = ost_cpu_grid_upload,
    .grid_download = ost_cpu_grid_download,
    .ct_to_rect = ost_cpu_ct_to_rect,
    .rect_to_cubic = ost_cpu_rect_to_cubic,
    .cubic_to_chunks = ost_cpu_cubic_to_chunks,
    .bone_create = ost_cpu_bone_create,
    .bone_free = ost_cpu_bone_free,
    .bone_stats = ost_cpu_bone_stats,
    .bone_upload = ost_cpu_bone_upload,
    .bone_download = ost_cpu_bone_download,
    .bone_sample = ost_cpu_bone_sample,
    .bone_occupancy = ost_cpu_bone_occupancy,
    .bone_leaves = ost_cpu_bone_leaves,
    .voxelize = ost_cpu_voxelize_tool,
    .tool_upload = ost_cpu_tool_upload,
    .tool_download = ost_cpu_tool_download,
    .tool_free = ost_cpu_tool_free,
    .remove = ost_cpu_remove,
    .collide = ost_cpu_collide,
    .face_mesh = ost_cpu_face_mesh,
};
