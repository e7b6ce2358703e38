/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads meshes with assimp: STL (ASCII and binary), OBJ, PLY and 3DS.
 *
 *   load and check (mesh/input.h) -> assimp, from memory -> float32 vertices
 *   -> times the unit -> RHE to picometres -> equal vertices joined
 *
 * assimp does no post-processing, so triangles are in the file's order. The transforms of assimp's nodes are ignored,
 * for example the rotation of a 3DS file by 90 degrees at its root. The check has disabled everything in the file that
 * could move a part, so every vertex is in the file's own frame.
 *
 * A coordinate is the exact value of assimp's float32 times the unit, rounded half to even (RHE) to picometres
 * (AR-MESH-2).
 */
#include "io/mesh/input.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "core/conditions.h"
#include "core/integer.h"

#ifdef HAVE_ASSIMP
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/scene.h>

_Static_assert(sizeof(ai_real) == sizeof(float), "an assimp of single precision");

static const struct {
    const char *name;
    int64_t pm;
} units[] = {
    [OST_UNIT_AUTO] = {"mm", OST_PM_PER_MM},     [OST_UNIT_MM] = {"mm", OST_PM_PER_MM},
    [OST_UNIT_CM] = {"cm", 10 * OST_PM_PER_MM},  [OST_UNIT_M] = {"m", 1000 * OST_PM_PER_MM},
    [OST_UNIT_INCH] = {"inch", 25400000000},     [OST_UNIT_UM] = {"um", OST_PM_PER_MM / 1000},
};

static const struct {
    const char *label; /* name of the format in reports */
    const char *name;  /* file name by which assimp selects its reader; no file with this name exists */
    ost_status (*check)(mesh_input *in, ost_error *err);
} kinds[] = {
    [MESH_STL_BINARY] = {"STL (binary)", "mesh.stl", ost_mesh_check_stl_binary},
    [MESH_STL_ASCII] = {"STL (ASCII)", "mesh.stl", ost_mesh_check_stl_ascii},
    [MESH_OBJ] = {"OBJ", "mesh.obj", ost_mesh_check_obj},
    [MESH_PLY] = {"PLY", "mesh.ply", ost_mesh_check_ply},
    [MESH_3DS] = {"3DS", "mesh.3ds", ost_mesh_check_3ds},
};

/* --------------------------------------------------- assimp's view of files */

/* A file that assimp has opened; handle.UserData points back to this struct. */
typedef struct memory_file {
    struct aiFile handle;
    const mesh_input *in;
    size_t at;
} memory_file;

static memory_file *file_of(struct aiFile *handle)
{
    return (memory_file *)(void *)handle->UserData;
}

static size_t memory_read(struct aiFile *handle, char *out, size_t size, size_t count)
{
    memory_file *file = file_of(handle);
    size_t elements = size ? (file->in->size - file->at) / size : 0;
    if (count > elements)
        count = elements;
    memcpy(out, file->in->bytes + file->at, count * size);
    file->at += count * size;
    return count;
}

static size_t memory_write(struct aiFile *handle, const char *bytes, size_t size, size_t count)
{
    (void)handle, (void)bytes, (void)size, (void)count;
    return 0;
}

static size_t memory_position(struct aiFile *handle)
{
    return file_of(handle)->at;
}

static size_t memory_size(struct aiFile *handle)
{
    return file_of(handle)->in->size;
}

static void memory_flush(struct aiFile *handle)
{
    (void)handle;
}

static enum aiReturn memory_seek(struct aiFile *handle, size_t offset, enum aiOrigin origin)
{
    memory_file *file = file_of(handle);
    const size_t size = file->in->size;
    size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? file->at : size;
    /* for a negative offset, assimp passes the offset modulo 2^64, so the unsigned sum is correct */
    size_t to = base + offset;
    if (to > size)
        return aiReturn_FAILURE;
    file->at = to;
    return aiReturn_SUCCESS;
}

/* Opens the mesh file itself. Refuses all other names. */
static struct aiFile *memory_open(struct aiFileIO *io, const char *name, const char *mode)
{
    const mesh_input *in = (const mesh_input *)(const void *)io->UserData;
    if (strcmp(name, kinds[in->kind].name) != 0 || mode[0] != 'r')
        return NULL;
    memory_file *file = malloc(sizeof *file);
    if (!file)
        return NULL;
    *file = (memory_file){.in = in};
    file->handle = (struct aiFile){memory_read,  memory_write, memory_position, memory_size, memory_seek,
                                   memory_flush, NULL};
    file->handle.UserData = (char *)(void *)file;
    return &file->handle;
}

static void memory_close(struct aiFileIO *io, struct aiFile *handle)
{
    (void)io;
    free(file_of(handle));
}

/* ------------------------------------------------------------- conversion */

static ost_status count_parts(const mesh_input *in, const struct aiScene *scene, size_t *vertices, ost_error *err)
{
    uint64_t triangles = 0;
    *vertices = 0;
    for (unsigned m = 0; m < scene->mNumMeshes; m++) {
        const struct aiMesh *part = scene->mMeshes[m];
        *vertices += part->mNumVertices;
        for (unsigned f = 0; f < part->mNumFaces; f++)
            triangles += part->mFaces[f].mNumIndices == 3;
    }
    if (triangles != in->triangles)
        return ost_fail(err, OST_ERR_INPUT, "%s: assimp reads %llu triangles where the file has %llu", in->path,
                        (unsigned long long)triangles, (unsigned long long)in->triangles);
    return OST_OK;
}

/*
 * Computes value * unit in picometres, rounded half to even. Returns false for NaN, infinity and results beyond
 * +-OST_LENGTH_MAX. Let value = m 2^e with |m| < 2^24. Because unit < 2^40, |m unit| < 2^64. A value of 2^31
 * units or more (2147 m in micrometres) is out of range; for smaller values, e < 8. For e < -100, the product is
 * less than 2^-36 pm, which rounds to 0.
 */
static bool to_pm(float value, int64_t unit, ost_pm *out)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const int exponent = (int)(bits >> 23 & 0xff);
    if (exponent >= 127 + 31)
        return false;
    ost_i128 product = (ost_i128)((bits & 0x7fffff) | (exponent ? 0x800000 : 0)) * unit;
    const int e = (exponent ? exponent : 1) - 150;
    if (bits >> 31)
        product = -product;
    ost_i128 pm = e >= 0 ? product * (1 << e) : e < -100 ? 0 : ost_rhe_div128(product, (ost_i128)1 << -e);
    *out = (ost_pm)pm;
    return pm >= -OST_LENGTH_MAX && pm <= OST_LENGTH_MAX;
}

static ost_status copy_vertices(const mesh_input *in, const struct aiMesh *part, int64_t unit, size_t first,
                                ost_mesh *out, ost_error *err)
{
    for (unsigned i = 0; i < part->mNumVertices; i++) {
        const struct aiVector3D *v = &part->mVertices[i];
        ost_pm3 *p = &out->vertices[first + i];
        if (!to_pm(v->x, unit, &p->x) || !to_pm(v->y, unit, &p->y) || !to_pm(v->z, unit, &p->z))
            return ost_fail(err, OST_ERR_INPUT,
                            "%s: a vertex at (%.6g %.6g %.6g) mm; expected coordinates from -8000 to 8000 mm", in->path,
                            (double)v->x * ost_pm_to_mm(unit), (double)v->y * ost_pm_to_mm(unit),
                            (double)v->z * ost_pm_to_mm(unit));
    }
    return OST_OK;
}

static ost_status copy_triangles(const mesh_input *in, const struct aiMesh *part, size_t first, ost_mesh *out,
                                 size_t *filled, ost_error *err)
{
    for (unsigned f = 0; f < part->mNumFaces; f++) {
        const struct aiFace *face = &part->mFaces[f];
        if (face->mNumIndices != 3)
            continue;
        for (int c = 0; c < 3; c++) {
            if (face->mIndices[c] >= part->mNumVertices)
                return ost_fail(err, OST_ERR_INPUT, "%s: triangle %zu uses vertex %u of %u", in->path, *filled,
                                face->mIndices[c], part->mNumVertices);
            out->triangles[*filled][c] = (uint32_t)(first + face->mIndices[c]);
        }
        ++*filled;
    }
    return OST_OK;
}

static ost_status convert(const mesh_input *in, const struct aiScene *scene, int64_t unit, ost_mesh *out,
                          ost_error *err)
{
    size_t vertices, first = 0, filled = 0;
    ost_status status = count_parts(in, scene, &vertices, err);
    if (status == OST_OK && (status = ost_mesh_init(out, vertices, (size_t)in->triangles, err)) != OST_OK)
        ost_fail_context(err, "%s", in->path);
    for (unsigned m = 0; status == OST_OK && m < scene->mNumMeshes; m++) {
        const struct aiMesh *part = scene->mMeshes[m];
        status = copy_vertices(in, part, unit, first, out, err);
        if (status == OST_OK)
            status = copy_triangles(in, part, first, out, &filled, err);
        first += part->mNumVertices;
    }
    return status;
}

static ost_status import(mesh_input *in, int64_t unit, ost_mesh *out, ost_error *err)
{
    /* assimp stores the message of its last error in a string that all threads share */
    static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
    struct aiFileIO io = {memory_open, memory_close, (char *)(void *)in};
    char message[201] = "";
    pthread_mutex_lock(&one_at_a_time);
    const struct aiScene *scene = aiImportFileEx(kinds[in->kind].name, 0, &io);
    if (!scene)
        snprintf(message, sizeof message, "%s", aiGetErrorString());
    pthread_mutex_unlock(&one_at_a_time);
    if (!scene && strstr(message, "bad_alloc"))
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory to read its %llu triangles by assimp", in->path,
                        (unsigned long long)in->triangles);
    if (!scene)
        return ost_fail(err, OST_ERR_INPUT, "%s: assimp: %s", in->path, message);
    ost_status status = convert(in, scene, unit, out, err);
    aiReleaseImport(scene);
    return status;
}

/* ------------------------------------------------------------------- size */

static ost_status check_extent(const char *path, double mm, ost_unit unit, ost_error *err)
{
    if (unit != OST_UNIT_AUTO || (mm >= 1.0 && mm <= 1000.0))
        return OST_OK;
    char fits[160] = "";
    for (int u = OST_UNIT_CM; u <= OST_UNIT_UM; u++) {
        double there = mm * ost_pm_to_mm(units[u].pm);
        size_t used = strlen(fits);
        if (there >= 1.0 && there <= 1000.0)
            snprintf(fits + used, sizeof fits - used, "%s--unit %s makes it %.3g mm", used ? ", " : "", units[u].name,
                     there);
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: in millimetres the mesh is %.3g mm across, outside 1 to 1000 mm; pass "
                    "its unit (%s%smm to confirm millimetres)", path, mm, fits, fits[0] ? "; " : "");
}

static ost_status finish(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err)
{
    ost_pm3 min, max;
    ost_status status = ost_mesh_weld(out, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(out, &min, &max, err);
    if (status != OST_OK) {
        ost_fail_context(err, "%s", path);
        return status;
    }
    const double bounds[6] = {ost_pm_to_mm(min.x), ost_pm_to_mm(min.y), ost_pm_to_mm(min.z),
                              ost_pm_to_mm(max.x), ost_pm_to_mm(max.y), ost_pm_to_mm(max.z)};
    double extent = 0;
    for (int a = 0; a < 3; a++) {
        report->bounds_mm[a] = bounds[a];
        report->bounds_mm[3 + a] = bounds[3 + a];
        if (bounds[3 + a] - bounds[a] > extent)
            extent = bounds[3 + a] - bounds[a];
    }
    return check_extent(path, extent, unit, err);
}

ost_status ost_mesh_read(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err)
{
    ost_mesh_report ignored;
    if (!report)
        report = &ignored;
    memset(report, 0, sizeof *report);
    memset(out, 0, sizeof *out);
    if ((unsigned)unit > OST_UNIT_UM)
        return ost_fail(err, OST_ERR_USAGE, "%s: unknown unit %d", path, (int)unit);
    mesh_input in;
    ost_status status = ost_mesh_input_load(path, &in, err);
    if (status != OST_OK)
        return status;
    status = kinds[in.kind].check(&in, err);
    if (status == OST_OK)
        status = import(&in, units[unit].pm, out, err);
    if (status == OST_OK)
        status = finish(path, unit, out, report, err);
    snprintf(report->format, sizeof report->format, "%s", kinds[in.kind].label);
    report->file_triangles = (size_t)in.faces;
    report->bodies = in.bodies;
    if (status != OST_OK)
        ost_mesh_free(out);
    ost_mesh_input_free(&in);
    return status;
}

#else

ost_status ost_mesh_read(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err)
{
    (void)unit;
    memset(out, 0, sizeof *out);
    if (report)
        memset(report, 0, sizeof *report);
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: cannot read meshes: osteon was built without assimp; install libassimp-dev and build again",
                    path);
}

#endif
