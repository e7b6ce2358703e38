/* SPDX-License-Identifier: Apache-2.0 */
/* Checks small grids whose voxels were computed by hand. The comment of each check derives the expected values. */
#include <stdio.h>
#include <string.h>

#include "validation/common/lab.h"

/* Formats values as text, such as "100 200 0". */
static const char *list(const int16_t *v, int count, char text[200])
{
    size_t n = 0;
    text[0] = '\0';
    for (int i = 0; i < count && n + 8 < 200; i++)
        n += (size_t)snprintf(text + n, 200 - n, "%s%d", i ? " " : "", v[i]);
    return text;
}

static void record_list(lab *l, const char *name, const char *requirements, const char *what, const int16_t *expected,
                        const int16_t *got, int count)
{
    char a[200], b[200];
    list(expected, count, a);
    lab_record(l, "golden", name, requirements, what, memcmp(expected, got, (size_t)count * sizeof *got) == 0, a, "%s",
               list(got, count, b));
}

/* Scatters the samples of a 2 x 2 x 2 grid in reverse order, one of them twice. The grid has a spacing of (1, 1, 2) mm
   and its origin at (10, 20, 30) mm. */
static void scatter(lab *l)
{
    static const int16_t expected[8] = {101, 102, 103, 104, 105, 106, 107, 108};
    int16_t got[8] = {0};
    ost_sample s[9];
    ost_scatter_report report = {0};
    ost_grid *rect = NULL;
    const ost_geometry g = {
        .dims = {2, 2, 2}, .spacing = {LAB_MM, LAB_MM, 2 * LAB_MM}, .origin = {10 * LAB_MM, 20 * LAB_MM, 30 * LAB_MM}};
    for (int i = 0; i < 9; i++) {
        /* The ninth sample is a duplicate of voxel 5, (1, 0, 1), with the same density. */
        const int v = i < 8 ? 7 - i : 5;
        s[i] = (ost_sample){.x = (10 + v % 2) * LAB_MM,
                            .y = (20 + v / 2 % 2) * LAB_MM,
                            .z = (30 + 2 * (v / 4)) * LAB_MM,
                            .density = 101 + v,
                            .line = (uint32_t)i};
    }
    if (l->status == OST_OK)
        l->status = ost_grid_create(l->backend, &g, &rect, l->err);
    if (l->status == OST_OK)
        l->status = ost_ct_to_rect(rect, s, 9, 1, OST_DUPLICATES_ERROR, &report, l->err);
    if (l->status == OST_OK)
        l->status = ost_grid_download(rect, 0, 2, got, l->err);
    ost_grid_free(rect);
    record_list(l, "samples", "AR-CT-4 AR-CT-6 AR-GRID-2",
                "eight samples in reverse order, one of them twice, are stored with x fastest, then y, then z",
                expected, got, 8);
}

/*
 * Checks the resampling of layers at 0, 2.5 and 5 mm to a spacing of 1 mm. The grid has ceil(3 x 2.5) = 8 layers, and
 * the first layer is at (1 - 2.5) / 2 = -0.75 mm. By the `linear` rule, layer k lies at t = (2 k - 1.5) / 5, where t
 * counts source layers. For k = 0, t is below 0. For k = 1 to 5, t is 0.1, 0.5, 0.9, 1.3 and 1.7. For k = 6 and 7, t is
 * at least 2. For k = 2, the mean of 119 and 120 is a tie, which becomes 120. For k = 4 and 5, the results are
 * 120 + 180 x 0.3 = 174 and 120 + 180 x 0.7 = 246. The `nearest` rule selects the source layer floor((2 k + 1) / 5),
 * limited to 2, and the `thesis` rule selects floor(k / 2.5). The threshold is applied afterwards.
 */
static void layers(lab *l)
{
    static const struct {
        ost_resample rule;
        const char *name, *requirements;
        int16_t cubic[8];
    } rules[] = {
        {OST_RESAMPLE_LINEAR, "layers-linear", "AR-CUB-1 AR-CUB-2", {119, 119, 120, 120, 174, 246, 300, 300}},
        {OST_RESAMPLE_NEAREST, "layers-nearest", "AR-CUB-1 AR-CUB-3", {119, 119, 120, 120, 120, 300, 300, 300}},
        {OST_RESAMPLE_THESIS, "layers-thesis", "AR-CUB-1 AR-CUB-4", {119, 119, 119, 120, 120, 300, 300, 300}},
    };
    static const int16_t in[3] = {119, 120, 300}, bone_expected[8] = {0, 0, 120, 120, 174, 246, 300, 300};
    ost_grid *rect = NULL;
    const ost_geometry g = {.dims = {1, 1, 3}, .spacing = {LAB_MM, LAB_MM, 5 * LAB_MM / 2}};
    if (l->status == OST_OK)
        l->status = ost_grid_create(l->backend, &g, &rect, l->err);
    if (l->status == OST_OK)
        l->status = ost_grid_upload(rect, 0, 3, in, l->err);
    for (int r = 0; r < 3; r++) {
        int16_t cubic_got[8] = {0}, bone_got[8] = {0};
        ost_grid *cubic = NULL;
        ost_bone *bone = NULL;
        if (l->status == OST_OK)
            l->status = ost_rect_to_cubic(rect, LAB_MM, rules[r].rule, &cubic, l->err);
        const bool eight = l->status == OST_OK && ost_grid_geometry(cubic)->dims.z == 8 &&
                           ost_grid_geometry(cubic)->origin.z == -3 * LAB_MM / 4;
        if (eight)
            l->status = ost_grid_download(cubic, 0, 8, cubic_got, l->err);
        if (l->status == OST_OK && r == 0)
            l->status = ost_cubic_to_chunks(cubic, 16, 120, &bone, l->err);
        if (l->status == OST_OK && r == 0 && eight)
            l->status = ost_bone_download(bone, 0, 8, bone_got, l->err);
        ost_bone_free(bone);
        ost_grid_free(cubic);
        record_list(l, rules[r].name, rules[r].requirements,
                    "three layers 2.5 mm apart become eight layers of 1 mm, the first 0.75 mm before them",
                    rules[r].cubic, cubic_got, 8);
        if (r == 0)
            record_list(l, "threshold", "AR-CHK-1", "119 is no bone, 120 is", bone_expected, bone_got, 8);
    }
    ost_grid_free(rect);
}

/*
 * Checks a cube from 0 to 2 mm with voxels of 1 mm. RHE rounds half to even. The grid begins at RHE(-1 / 2) - 1 = -1
 * and ends at RHE(5 / 2) + 1 = 3, in voxels. This gives 4 voxels per axis with centres at -0.5, 0.5, 1.5 and 2.5; the
 * second and the third centre are inside the cube.
 */
static void cube(lab *l)
{
    ost_mesh mesh;
    ost_tool_volume v;
    bool as_expected = true;
    lab_box(l, (ost_pm3){0, 0, 0}, (ost_pm3){2 * LAB_MM, 2 * LAB_MM, 2 * LAB_MM}, false, &mesh);
    lab_voxelize(l, &mesh, NULL, LAB_MM, &v);
    const ost_dims d = v.geometry.dims;
    const bool grid = l->status == OST_OK && d.x == 4 && d.y == 4 && d.z == 4 && v.geometry.corner.x == -LAB_MM &&
                      v.geometry.corner.z == -LAB_MM;
    for (int i = 0; grid && i < 64; i++) {
        const int x = i % 4, y = i / 4 % 4, z = i / 16;
        as_expected &= v.voxels[i] == ((x == 1 || x == 2) && (y == 1 || y == 2) && (z == 1 || z == 2) ? OST_TOOL_CUTTING
                                                                                                      : OST_TOOL_VOID);
    }
    lab_record(l, "golden", "cube", "AR-TOOL-2 AR-TOOL-3 AR-VOX-1 AR-VOX-2 AR-VOX-3 AR-VOX-4",
               "a cube of 2 mm in voxels of 1 mm gives a grid of 4 x 4 x 4 voxels whose inner 8 are solid",
               grid && as_expected, "4 x 4 x 4 from -1 mm, 8 solid", "%d x %d x %d, %lld solid", d.x, d.y, d.z,
               l->status == OST_OK ? (long long)ost_tool_volume_count(&v, OST_TOOL_CUTTING) : 0);
    ost_tool_volume_free(&v);
    ost_mesh_free(&mesh);
}

/* Checks that an event removes exactly the voxels with lo <= index < hi from a bone of 8 x 8 x 8 voxels. */
static void gone(lab *l, const char *name, const char *what, const char *expected, ost_pose pose, const int lo[3],
                 const int hi[3])
{
    int16_t voxels[512];
    const ost_geometry g = lab_cube(8, 8, 8, LAB_MM);
    ost_tool *tool = lab_tool(l, (ost_dims){4, 4, 4}, LAB_MM / 2, (ost_pm3){0, 0, 0}, OST_TOOL_CUTTING);
    int right = 0, removed = 0;
    for (int i = 0; i < 512; i++)
        voxels[i] = 500;
    lab_remove(l, &g, 16, voxels, tool, &pose, 1, NULL);
    for (int i = 0; i < 512; i++) {
        const int at[3] = {i % 8, i / 8 % 8, i / 64};
        bool in = true;
        for (int a = 0; a < 3; a++)
            in &= at[a] >= lo[a] && at[a] < hi[a];
        right += voxels[i] == (in ? 0 : 500);
        removed += voxels[i] == 0;
    }
    ost_tool_free(tool);
    lab_record(l, "golden", name, "AR-REM-1 AR-REM-2 AR-MAP-1 AR-POSE-1", what, right == 512, expected,
               "%d of 512 voxels as expected, %d removed", right, removed);
}

/* Checks a row of bone voxels under tool voxels of the classes cutting, cutting, cutting, not cutting and empty.
   Density classes are half-open, so the densities 150 and 650 belong to the classes cancellous and cortical. */
static void classes(lab *l)
{
    static const int16_t expected[5] = {0, 0, 0, 700, 700};
    static const uint8_t tool_voxels[5] = {OST_TOOL_CUTTING, OST_TOOL_CUTTING, OST_TOOL_CUTTING, OST_TOOL_NONCUTTING,
                                           OST_TOOL_VOID};
    int16_t voxels[5] = {149, 150, 650, 700, 700};
    const ost_geometry g = lab_cube(5, 1, 1, LAB_MM);
    const ost_pose here = ost_pose_identity();
    ost_tool_volume volume = {.voxels = NULL};
    ost_tool *tool = NULL;
    ost_removal_report r = {0};
    if (l->status == OST_OK)
        l->status = ost_tool_volume_init(
            &volume, &(ost_tool_geometry){{5, 1, 1}, LAB_MM, {-LAB_MM / 2, -LAB_MM / 2, -LAB_MM / 2}}, l->err);
    if (l->status == OST_OK) {
        memcpy(volume.voxels, tool_voxels, sizeof tool_voxels);
        l->status = ost_tool_upload(l->backend, &volume, &tool, l->err);
    }
    ost_tool_volume_free(&volume);
    lab_remove(l, &g, 16, voxels, tool, &here, 1, &r);
    record_list(l, "not cutting", "AR-REM-1 AR-REM-2 AR-TOOL-4", "a tool that does not cut removes nothing", expected,
                voxels, 5);
    lab_record(l, "golden", "classes", "AR-CLS-1 AR-CLS-2 AR-REM-6",
               "149, 150 and 650 are of three classes; one voxel is touched",
               r.voxels[0] == 1 && r.voxels[1] == 1 && r.voxels[2] == 1 && r.touched_voxels == 1, "1, 1, 1; 1 touched",
               "%llu, %llu, %llu; %llu touched", (unsigned long long)r.voxels[0], (unsigned long long)r.voxels[1],
               (unsigned long long)r.voxels[2], (unsigned long long)r.touched_voxels);
    ost_removal_report_free(&r);
    ost_tool_free(tool);
}

/*
 * Checks the digests of two grids. tests/oracle/check_digests.py reads the digests below and compares them
 * with the digests that an independent implementation of AR-DIG computes.
 *
 * The bone has 65 x 1 x 33 voxels of 1 mm with the first centre at (1, -2, 3) mm,
 * threshold 120, and the density 100 + i % 1000 at voxel i. It has 3 x 1 x 2 leaves. The
 * tree hash combines the hash of the first four leaves with the hash of the last two.
 *
 * The tool has 33 x 34 x 33 voxels of 1 mm with the corner at (-1, 0, 2) mm, and the class (i + i / 33) % 3 at
 * voxel i. It has 2 x 2 x 2 leaves. The first leaf lies completely in the grid, and the other seven extend beyond it.
 */
static void digests(lab *l)
{
    static const char bone_expected[] = "0b320bf531e76ab294de8f920ed31a63278f94b194aa78363ef359d58c2bef34";
    static const char tool_expected[] = "c09b15d3164c5d7ced248a8c3575b0f2c6459379295ef8f3f9be1aaba708fdc7";
    const ost_geometry g = {
        .dims = {65, 1, 33}, .spacing = {LAB_MM, LAB_MM, LAB_MM}, .origin = {LAB_MM, -2 * LAB_MM, 3 * LAB_MM}};
    const ost_tool_geometry shape = {{33, 34, 33}, LAB_MM, {-LAB_MM, 0, 2 * LAB_MM}};
    int16_t voxels[65 * 33];
    char bone_hex[OST_DIGEST_HEX] = "", tool_hex[OST_DIGEST_HEX] = "";
    ost_bone *bone = NULL;
    ost_tool *tool = NULL;
    ost_digest digest;
    ost_tool_volume volume = {.voxels = NULL};
    for (int i = 0; i < 65 * 33; i++)
        voxels[i] = (int16_t)(100 + i % 1000);
    if (l->status == OST_OK)
        l->status = ost_bone_create(l->backend, &g, 16, 120, &bone, l->err);
    if (l->status == OST_OK)
        l->status = ost_bone_upload(bone, 0, 33, voxels, l->err);
    if (l->status == OST_OK && (l->status = ost_bone_digest(bone, NULL, &digest, l->err)) == OST_OK)
        ost_digest_hex(&digest, bone_hex);
    if (l->status == OST_OK)
        l->status = ost_tool_volume_init(&volume, &shape, l->err);
    if (l->status == OST_OK) {
        for (int i = 0; i < 33 * 34 * 33; i++)
            volume.voxels[i] = (uint8_t)((i + i / 33) % 3);
        l->status = ost_tool_upload(l->backend, &volume, &tool, l->err);
    }
    if (l->status == OST_OK && (l->status = ost_tool_digest(tool, &digest, l->err)) == OST_OK)
        ost_digest_hex(&digest, tool_hex);
    ost_tool_volume_free(&volume);
    ost_tool_free(tool);
    ost_bone_free(bone);
    lab_record(l, "golden", "digest of a bone", "AR-DIG-2 AR-DIG-3 AR-DIG-4",
               "a bone of 65 x 1 x 33 voxels, six leaves, has the digest that an independent implementation computes",
               strcmp(bone_hex, bone_expected) == 0, bone_expected, "%s", bone_hex);
    lab_record(l, "golden", "digest of a tool", "AR-DIG-2 AR-DIG-4 AR-DIG-5",
               "a tool of 33 x 34 x 33 voxels has the digest that an independent implementation computes",
               strcmp(tool_hex, tool_expected) == 0, tool_expected, "%s", tool_hex);
}

/* Checks the example of docs/spec/arithmetic.md, section 11. The motion d has |d|^2 = 2.5 * 10^17 pm^2, and the bone's
   spacing s has s^2 = 2.209 * 10^17 pm^2. The least n with 4 |d|^2 <= n^2 s^2 is 3. */
static void sweep(lab *l)
{
    const ost_pose a = ost_pose_identity();
    const ost_tool_geometry tool = {{4, 4, 4}, LAB_MM, {0, 0, 0}};
    ost_pose b = a, first = a;
    int count = 0;
    b.t = (ost_pm3){300000000, 400000000, 0};
    if (l->status == OST_OK)
        l->status = ost_sweep_count(&a, &b, &tool, 470000000, &count, l->err);
    if (l->status == OST_OK)
        first = ost_sweep_pose(&a, &b, 1, 3);
    lab_record(l, "golden", "sweep", "AR-SWEEP-2 AR-SWEEP-4",
               "a motion of 0.5 mm in a bone of 0.47 mm has three poses; the first is after a third of the way",
               count == 3 && first.t.x == 100000000 && first.t.y == 133333333 && first.t.z == 0,
               "3; 100000000, 133333333, 0", "%d; %lld, %lld, %lld", count, (long long)first.t.x, (long long)first.t.y,
               (long long)first.t.z);
}

/*
 * Checks the ends of the range of lengths, -8 m and 8 m (AR-LEN-1). With voxels of 1 mm, a mesh begins
 * at min = -8 m + 1.5 mm, which is -7998.5 voxels. The corner of its grid is RHE((2 min - 1) / 2) - 1 =
 * -7999 - 1 = -8000 voxels, which is -8 m and thus in range. A pose that lies a picometre beyond an end of
 * the range is refused.
 */
static void borders(lab *l)
{
    const ost_pm end = OST_LENGTH_MAX;
    const ost_tool_geometry tool = {{4, 4, 4}, LAB_MM, {0, 0, 0}};
    const ost_geometry g = lab_cube(8, 8, 8, LAB_MM);
    ost_mesh mesh;
    ost_tool_volume v;
    ost_map map;
    int count, refused = 0;
    const ost_pm3 min = {-end + 3 * LAB_MM / 2, 0, 0}, max = {-end + 7 * LAB_MM / 2, 2 * LAB_MM, 2 * LAB_MM};
    lab_box(l, min, max, false, &mesh);
    lab_voxelize(l, &mesh, NULL, LAB_MM, &v);
    lab_record(l, "golden", "corner at 8 m", "AR-TOOL-1 AR-TOOL-2", "a tool's grid may begin at -8 m",
               l->status == OST_OK && v.geometry.corner.x == -end, "-8000 mm", "%lld pm",
               (long long)v.geometry.corner.x);
    ost_tool_volume_free(&v);
    ost_mesh_free(&mesh);
    for (int a = 0; a < 6 && l->status == OST_OK; a++) {
        const ost_pose here = ost_pose_identity();
        ost_pose beyond = here;
        const ost_pm at = a % 2 ? -end - 1 : end + 1;
        *(a / 2 == 0 ? &beyond.t.x : a / 2 == 1 ? &beyond.t.y : &beyond.t.z) = at;
        refused += ost_map_make(&beyond, &g, &tool, &map, NULL) == OST_ERR_RANGE;
        refused += ost_sweep_count(&beyond, &beyond, &tool, LAB_MM, &count, NULL) == OST_ERR_RANGE;
    }
    lab_record(l, "golden", "pose beyond 8 m", "AR-POSE-3 AR-LEN-1",
               "a pose one picometre beyond 8 m is refused by the map and by the sweep",
               l->status == OST_OK && refused == 12, "12 refused", "%d refused", refused);
}

void lab_golden(lab *l)
{
    const int32_t half = 759250125; /* sine and cosine of 45 degrees, times 2^30 */
    scatter(l);
    layers(l);
    cube(l);
    gone(l, "removal",
         "a cube of 2 mm at (2, 3, 4) removes the voxels with centres at x 2 and 3, y 3 and 4, z 4 and 5: its box is "
         "half-open",
         "8 removed", (ost_pose){{2 * LAB_MM, 3 * LAB_MM, 4 * LAB_MM}, 1 << 30, 0, 0, 0}, (const int[3]){2, 3, 4},
         (const int[3]){4, 5, 6});
    gone(l, "quarter turn",
         "turned by a quarter about z, the tool's y points along the bone's -x, so at x = 4 it removes x 3 and 4",
         "8 removed", (ost_pose){{4 * LAB_MM, 3 * LAB_MM, 4 * LAB_MM}, half, 0, 0, half}, (const int[3]){3, 3, 4},
         (const int[3]){5, 5, 6});
    gone(l, "border", "across two borders of the bone, only voxels inside the bone are removed", "2 removed",
         (ost_pose){{-LAB_MM, 7 * LAB_MM, 0}, 1 << 30, 0, 0, 0}, (const int[3]){0, 7, 0}, (const int[3]){1, 8, 2});
    classes(l);
    digests(l);
    sweep(l);
    borders(l);
}
