/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares every stage of the cl backend with the reference through the public API: grids, bones,
 * tools, digests and reports, byte by byte. The tests use both kernel sets, several work-group
 * sizes and two orders of the work items, and they transfer large data in parts. All tests of a
 * kernel set together enter every path that core/paths.h lists.
 *
 * The file has more than 500 lines, because the last test counts the paths that all tests of the process entered.
 *
 * Covers: AR-CT-4, AR-CT-5, AR-CT-6, AR-CUB-2, AR-CUB-3, AR-CHK-1, AR-CHK-2, AR-CHK-3, AR-VOX-1..7,
 * AR-REM-1, AR-REM-2, AR-REM-3,
 * AR-REM-5, AR-REM-6, AR-CLS-1, AR-DIG-2, REQ-CL, REQ-CL-SETS
 */
#include "cl/on_device.h"
#include "core/paths.h"
#include "mesh/mesh_make.h"
#include "ref/scene.h"

typedef struct pair {
    ost_backend *ref, *cl;
} pair;

/*
 * The tested options for work groups. Without OST_TEST_LONG=1 only some of them are tested, because an
 * implementation may compile every kernel again for each size.
 */
static const char *const workgroups[] = {NULL, "workgroup=7,staging=1024,order=3", "workgroup=1,order=3",
                                         "workgroup=256,staging=20000"};

static size_t workgroup_count(void)
{
    return getenv("OST_TEST_LONG") ? sizeof workgroups / sizeof workgroups[0] : 2;
}

/* Kernel set of the current group of tests. */
static const char *set;

/* The paths of the set, each with the number of times that it was entered. */
enum { PATHS = 128 };
static struct {
    char name[OST_PATH_NAME];
    uint64_t entered;
} paths[PATHS];
static int path_count;

static void add_path(void *user, const char *name, uint64_t entered)
{
    int i = 0;
    (void)user;
    while (i < path_count && strcmp(paths[i].name, name) != 0)
        i++;
    assert_true(i < PATHS && strlen(name) < OST_PATH_NAME);
    if (i == path_count) {
        snprintf(paths[path_count++].name, OST_PATH_NAME, "%s", name);
        paths[i].entered = 0;
    }
    paths[i].entered += entered;
}

static pair open_pair(const char *workgroup)
{
    ost_error err = {0};
    char option[200], spec[256];
    pair p;
    snprintf(option, sizeof option, "kernels=%s%s%s", set, workgroup ? "," : "", workgroup ? workgroup : "");
    spec_with(spec, sizeof spec, option);
    assert_ok(ost_backend_open("ref", &p.ref, &err));
    assert_ok(ost_backend_open(spec, &p.cl, &err));
    return p;
}

static void close_pair(pair p)
{
    ost_backend_paths(p.cl, add_path, NULL);
    ost_backend_close(p.cl);
    ost_backend_close(p.ref);
}

/* ---------------------------------------------------------------- grids */

static int16_t *grid_content(const ost_grid *grid)
{
    ost_error err = {0};
    const ost_geometry *g = ost_grid_geometry(grid);
    int16_t *voxels = malloc(voxel_count(g) * sizeof *voxels);
    assert_non_null(voxels);
    assert_ok(ost_grid_download(grid, 0, g->dims.z, voxels, &err));
    return voxels;
}

static void assert_same_grids(const ost_grid *a, const ost_grid *b)
{
    int16_t *va = grid_content(a), *vb = grid_content(b);
    assert_true(ost_geometry_equal(ost_grid_geometry(a), ost_grid_geometry(b)));
    assert_same_voxels(vb, va, ost_grid_geometry(a));
    free(va);
    free(vb);
}

/*
 * Makes random samples: most are at lattice points, some are off the lattice or outside the grid, and many are
 * duplicates.
 */
static void some_samples(test_rng *rng, const ost_geometry *g, ost_sample *samples, size_t count, bool clean)
{
    const ost_pm origin[3] = {g->origin.x, g->origin.y, g->origin.z},
                 spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (size_t i = 0; i < count; i++) {
        ost_pm at[3];
        for (int a = 0; a < 3; a++) {
            at[a] = origin[a] + rng_range(rng, 0, dims[a] - 1) * spacing[a];
            const int64_t kind = clean ? 9 : rng_range(rng, 0, 60);
            if (kind == 0)
                at[a] += rng_range(rng, -spacing[a] / 2, spacing[a] / 2);
            else if (kind == 1)
                at[a] += spacing[a] / 8;
            else if (kind == 2)
                at[a] = origin[a] + rng_range(rng, -1, dims[a]) * spacing[a];
        }
        samples[i] = (ost_sample){
            .x = at[0], .y = at[1], .z = at[2], .density = (int32_t)rng_range(rng, 100, 104), .line = (uint32_t)i};
    }
}

static void samples(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("samples");
    const pair ways[2] = {open_pair(NULL), open_pair("staging=1024")};
    for (int round = 0; round < 40; round++) {
        const pair p = ways[round / 4 % 2];
        const ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 20), (int32_t)rng_range(&rng, 1, 20), (int32_t)rng_range(&rng, 1, 20)},
            .spacing = {rng_range(&rng, 1, 900) * UM, 470 * UM, rng_range(&rng, 1, 2000) * UM},
            .origin = {rng_range(&rng, -500, 500) * UM, -57340 * UM, 3},
        };
        ost_grid *grid[2];
        ost_scatter_report report[2] = {{0}, {0}};
        assert_ok(ost_grid_create(p.ref, &g, &grid[0], &err));
        assert_ok(ost_grid_create(p.cl, &g, &grid[1], &err));
        const ost_duplicates rule = (ost_duplicates)(round % 4);
        const bool clean = round % 3 == 0;
        int64_t line = 5;
        for (int batch = 0; batch < 3; batch++) {
            enum { COUNT = 700 };
            ost_sample batch_samples[COUNT];
            some_samples(&rng, &g, batch_samples, COUNT, clean);
            for (int b = 0; b < 2; b++)
                assert_ok(ost_ct_to_rect(grid[b], batch_samples, COUNT, line, rule, &report[b], &err));
            line += COUNT;
        }
        assert_memory_equal(&report[0], &report[1], sizeof report[0]);
        if (report[0].rejected_line == 0 && report[0].conflict_line == 0)
            assert_same_grids(grid[0], grid[1]);
        for (int b = 0; b < 2; b++)
            ost_grid_free(grid[b]);
    }
    close_pair(ways[0]);
    close_pair(ways[1]);
}

static void cubic(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("cubic");
    for (size_t w = 0; w < workgroup_count(); w++) {
        pair p = open_pair(workgroups[w]);
        for (int round = 0; round < 12; round++) {
            const ost_geometry g = {
                .dims = {(int32_t)rng_range(&rng, 1, 40), (int32_t)rng_range(&rng, 1, 30),
                         (int32_t)rng_range(&rng, 1, 30)},
                .spacing = {rng_range(&rng, 100, 900) * UM, rng_range(&rng, 100, 900) * UM,
                            rng_range(&rng, 100, 2000) * UM},
            };
            int16_t *voxels = random_densities(&rng, &g, 5);
            ost_grid *rect[2], *out[2];
            const ost_pm spacing = rng_range(&rng, 90, 1000) * UM;
            const ost_resample rule = (ost_resample)(round % 3);
            for (int b = 0; b < 2; b++) {
                const int32_t cut = g.dims.z / 2;
                assert_ok(ost_grid_create(b ? p.cl : p.ref, &g, &rect[b], &err));
                assert_ok(ost_grid_upload(rect[b], 0, cut, voxels, &err));
                assert_ok(ost_grid_upload(rect[b], cut, g.dims.z - cut,
                                          voxels + (size_t)cut * (size_t)g.dims.x * (size_t)g.dims.y, &err));
                assert_ok(ost_rect_to_cubic(rect[b], spacing, rule, &out[b], &err));
            }
            assert_same_grids(rect[0], rect[1]);
            assert_same_grids(out[0], out[1]);
            for (int b = 0; b < 2; b++) {
                ost_grid_free(out[b]);
                ost_grid_free(rect[b]);
            }
            free(voxels);
        }
        close_pair(p);
    }
}

/* ---------------------------------------------------------------- bones */

static void assert_same_bones(const ost_bone *a, const ost_bone *b, const ost_geometry *g)
{
    ost_error err = {0};
    ost_bone_info info[2];
    assert_ok(ost_bone_info_get(a, &info[0], &err));
    assert_ok(ost_bone_info_get(b, &info[1], &err));
    assert_int_equal(info[0].active_chunks, info[1].active_chunks);
    assert_int_equal(info[0].active_voxels, info[1].active_voxels);
    assert_int_equal(info[0].chunk_bytes, info[1].chunk_bytes);
    int16_t *va = content(a, g), *vb = content(b, g);
    assert_same_voxels(vb, va, g);
    free(va);
    free(vb);
    const ost_digest da = digest_of(a), db = digest_of(b);
    assert_memory_equal(&da, &db, sizeof da);
}

static void bones(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("bones");
    for (size_t w = 0; w < workgroup_count(); w++) {
        pair p = open_pair(workgroups[w]);
        for (int round = 0; round < 6; round++) {
            const int n = 16 << round % 3;
            const ost_geometry g = cubic_geometry((int32_t)rng_range(&rng, 1, 90), (int32_t)rng_range(&rng, 1, 80),
                                                  (int32_t)rng_range(&rng, 1, 70), 400 * UM, (ost_pm3){1, 2, 3});
            int16_t *voxels = random_densities(&rng, &g, round);
            ost_bone *bone[2];
            for (int b = 0; b < 2; b++) {
                ost_grid *grid;
                assert_ok(ost_grid_create(b ? p.cl : p.ref, &g, &grid, &err));
                assert_ok(ost_grid_upload(grid, 0, g.dims.z, voxels, &err));
                assert_ok(ost_cubic_to_chunks(grid, n, 120, &bone[b], &err));
                ost_grid_free(grid);
            }
            assert_same_bones(bone[0], bone[1], &g);
            /*
             * Uploads overwrite slices. They add, remove and change chunks, in complete layers of chunks
             * and in parts of layers.
             */
            for (int part = 0; part < 6; part++) {
                const int32_t z0 = (int32_t)rng_range(&rng, 0, g.dims.z - 1),
                              count = (int32_t)rng_range(&rng, 0, g.dims.z - z0);
                const size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
                const bool empty = part % 2 == 0;
                int16_t *slices = calloc(slice * (size_t)count + 1, sizeof *slices),
                        *back = calloc(slice * (size_t)count + 1, sizeof *back);
                for (size_t i = 0; i < slice * (size_t)count; i++)
                    slices[i] = (int16_t)(empty ? rng_range(&rng, 0, 1 << 14) / (1 << 14) * 500
                                                : rng_range(&rng, 100, 300));
                for (int b = 0; b < 2; b++)
                    assert_ok(ost_bone_upload(bone[b], z0, count, slices, &err));
                assert_same_bones(bone[0], bone[1], &g);
                assert_ok(ost_bone_download(bone[0], z0, count, slices, &err));
                assert_ok(ost_bone_download(bone[1], z0, count, back, &err));
                assert_memory_equal(slices, back, slice * (size_t)count * sizeof *slices);
                free(slices);
                free(back);
            }
            for (int b = 0; b < 2; b++)
                ost_bone_free(bone[b]);
            free(voxels);
        }
        close_pair(p);
    }
}

/* A grid that was resampled along z may share voxels with its source grid. If one of the two grids is written or
   freed, the other must not change. */
static void resampled_grid_and_source_are_independent(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("shared");
    pair p = open_pair(NULL);
    for (int round = 0; round < 30; round++) {
        const bool large = round % 5 == 4; /* The backend reuses buffers of one megabyte or more. */
        const ost_pm side = rng_range(&rng, 100, 900) * UM;
        const ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, large ? 140 : 40),
                     (int32_t)rng_range(&rng, large ? 110 : 1, large ? 120 : 30),
                     (int32_t)rng_range(&rng, 1, large ? 70 : 30)},
            .spacing = {side, side, rng_range(&rng, 100, 2000) * UM},
        };
        int16_t *voxels = random_densities(&rng, &g, 5), *others = random_densities(&rng, &g, 5);
        const ost_pm finer = rng_range(&rng, 0, 1) ? side : (large ? side : rng_range(&rng, 90, 1000) * UM);
        const ost_resample rule = (ost_resample)(round % 3);
        const int order = (int)rng_range(&rng, 0, 3), size = 16 << rng_range(&rng, 0, 2);
        ost_grid *rect[2], *first[2], *second[2];
        ost_bone *bone[2];
        for (int b = 0; b < 2; b++) {
            assert_ok(ost_grid_create(b ? p.cl : p.ref, &g, &rect[b], &err));
            assert_ok(ost_grid_upload(rect[b], 0, g.dims.z, voxels, &err));
            assert_ok(ost_rect_to_cubic(rect[b], side, rule, &first[b], &err));
            if (order == 0) { /* writes to the source grid */
                const ost_sample one = {.density = 777, .line = 1};
                ost_scatter_report report = {0};
                assert_ok(ost_ct_to_rect(rect[b], &one, 1, 1, OST_DUPLICATES_LAST, &report, &err));
            } else if (order == 1) { /* writes to the resampled grid */
                assert_ok(ost_grid_upload(first[b], 0, 1, others, &err));
            } else if (order == 2) {
                assert_ok(ost_grid_upload(rect[b], g.dims.z / 2, g.dims.z - g.dims.z / 2, others, &err));
            }
            assert_ok(ost_rect_to_cubic(first[b], finer, rule, &second[b], &err));
            assert_ok(ost_cubic_to_chunks(second[b], size, 120, &bone[b], &err));
        }
        assert_same_bones(bone[0], bone[1], ost_grid_geometry(second[0]));
        assert_same_grids(rect[0], rect[1]);
        for (int b = 0; b < 2; b++)
            ost_grid_free(order == 3 ? rect[b] : first[b]);
        assert_same_grids(second[0], second[1]);
        assert_same_grids(order == 3 ? first[0] : rect[0], order == 3 ? first[1] : rect[1]);
        for (int b = 0; b < 2; b++) {
            ost_grid_free(order == 3 ? first[b] : rect[b]);
            ost_grid_free(second[b]);
            ost_bone_free(bone[b]);
        }
        free(voxels);
        free(others);
    }
    close_pair(p);
}

/* ---------------------------------------------------------------- tools */

static void assert_same_tools(const ost_tool *a, const ost_tool *b)
{
    ost_error err = {0};
    ost_tool_volume va, vb;
    assert_ok(ost_tool_download(a, &va, &err));
    assert_ok(ost_tool_download(b, &vb, &err));
    assert_memory_equal(&va.geometry, &vb.geometry, sizeof va.geometry);
    assert_memory_equal(va.voxels, vb.voxels, (size_t)ost_dims_count(va.geometry.dims));
    ost_tool_volume_free(&va);
    ost_tool_volume_free(&vb);
}

static void voxelizer(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("voxelizer");
    for (size_t w = 0; w < workgroup_count(); w++) {
        pair p = open_pair(workgroups[w]);
        for (int round = 0; round < 25; round++) {
            /* A great depth gives long triangles, which are in the lists of many slices. */
            const int32_t depth = round == 24 ? 200 : 24;
            const ost_dims dims = {(int32_t)rng_range(&rng, 2, 24), (int32_t)rng_range(&rng, 2, 24),
                                   (int32_t)rng_range(&rng, round == 24 ? 150 : 2, depth)};
            ost_snapped_mesh mesh = make_closed(&rng, dims, (uint32_t)rng_range(&rng, 3, 8),
                                                (uint32_t)rng_range(&rng, 3, 8));
            ost_snapped_mesh shaft = make_closed(&rng, dims, 3, 5);
            if (round % 4 == 1)
                mesh.triangle_count--; /* makes a hole, so that the mesh is not closed */
            const ost_snapped_mesh *other = round % 3 ? &shaft : NULL;
            const ost_fill_rule rule = round % 2 ? OST_FILL_PARITY : OST_FILL_WINDING;
            ost_tool *tool[2];
            ost_voxelize_report report[2];
            for (int b = 0; b < 2; b++)
                assert_ok(ost_voxelize(b ? p.cl : p.ref, &mesh, other, rule, &report[b], &tool[b], &err));
            assert_memory_equal(&report[0], &report[1], sizeof report[0]);
            assert_same_tools(tool[0], tool[1]);
            for (int b = 0; b < 2; b++)
                ost_tool_free(tool[b]);
            ost_snapped_mesh_free(&mesh);
            ost_snapped_mesh_free(&shaft);
        }
        close_pair(p);
    }
}

/* --------------------------------------------------------------- events */

/* Makes a tool from balls or random classes, so that many different values of reach occur. */
static ost_tool_volume some_tool(test_rng *rng, ost_tool_geometry g)
{
    ost_error err = {0};
    ost_tool_volume v;
    assert_ok(ost_tool_volume_init(&v, &g, &err));
    const int kind = (int)rng_range(rng, 0, 2);
    for (int32_t k = 0; k < g.dims.z; k++)
        for (int32_t j = 0; j < g.dims.y; j++)
            for (int32_t i = 0; i < g.dims.x; i++) {
                const int64_t x = 2 * i - g.dims.x, y = 2 * j - g.dims.y, z = 2 * k - g.dims.z;
                const bool ball = x * x + y * y + z * z < (int64_t)g.dims.x * g.dims.y;
                uint8_t c = kind == 0 ? (uint8_t)rng_range(rng, 0, 2) : ball ? OST_TOOL_CUTTING : OST_TOOL_VOID;
                if (kind == 2 && !ball && k > g.dims.z / 2)
                    c = OST_TOOL_NONCUTTING;
                v.voxels[i + (int64_t)g.dims.x * (j + (int64_t)g.dims.y * k)] = c;
            }
    return v;
}

static void removal(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("removal");
    for (size_t w = 0; w < workgroup_count(); w++) {
        pair p = open_pair(workgroups[w]);
        for (int round = 0; round < 9; round++) {
            const ost_geometry g = cubic_geometry((int32_t)rng_range(&rng, 8, 80), (int32_t)rng_range(&rng, 8, 60),
                                                  (int32_t)rng_range(&rng, 8, 70), rng_range(&rng, 100, 900) * UM,
                                                  (ost_pm3){rng_range(&rng, -9, 9) * UM, 0, 5});
            const ost_tool_geometry tg = {
                .dims = {(int32_t)rng_range(&rng, 1, 40), (int32_t)rng_range(&rng, 1, 40),
                         (int32_t)rng_range(&rng, 1, 30)},
                .voxel = rng_range(&rng, 200, 900) * UM,
                .corner = {-5000 * UM, -5000 * UM, -300 * UM},
            };
            int16_t *voxels = random_densities(&rng, &g, 7);
            ost_tool_volume volume = some_tool(&rng, tg);
            ost_bone *bone[2];
            ost_tool *tool[2];
            for (int b = 0; b < 2; b++) {
                bone[b] = bone_of(b ? p.cl : p.ref, &g, 16 << round % 3, voxels);
                assert_ok(ost_tool_upload(b ? p.cl : p.ref, &volume, &tool[b], &err));
            }
            assert_same_tools(tool[0], tool[1]);
            const ost_pm3 lo = {0, 0, 0}, hi = {g.dims.x * g.spacing.x, g.dims.y * g.spacing.x, g.dims.z * g.spacing.x};
            scene_event *e = malloc(sizeof *e);
            ost_removal_report report[2] = {{0}, {0}};
            for (int event = 0; event < 8; event++) {
                ost_pose poses[12];
                const int count = (int)rng_range(&rng, 1, 12);
                for (int k = 0; k < count; k++)
                    poses[k] = random_pose(&rng, lo, hi);
                event_of(e, &g, tool[0], poses, count);
                for (int k = 0; k < count && event % 2; k++)
                    for (int a = 0; a < 3; a++) {
                        e->boxes[k].lo[a] = (int32_t)rng_range(&rng, -5, 30);
                        e->boxes[k].hi[a] = (int32_t)rng_range(&rng, 0, 90);
                    }
                for (int b = 0; b < 2; b++)
                    assert_ok(ost_bone_collide(bone[b], tool[b], &e->event, &report[b], &err));
                assert_same_report(&report[0], &report[1]);
                for (int b = 0; b < 2; b++)
                    assert_ok(ost_bone_remove(bone[b], tool[b], &e->event, &report[b], &err));
                assert_same_report(&report[0], &report[1]);
                assert_same_bones(bone[0], bone[1], &g);
            }
            for (int b = 0; b < 2; b++) {
                ost_removal_report_free(&report[b]);
                ost_tool_free(tool[b]);
                ost_bone_free(bone[b]);
            }
            free(e);
            ost_tool_volume_free(&volume);
            free(voxels);
        }
        close_pair(p);
    }
}

/* When all voxels are removed, all slots return to the pool and are reused. */
static void emptied_bone_reuses_its_slots(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("emptied");
    pair p = open_pair(NULL);
    const ost_geometry g = cubic_geometry(70, 50, 40, 500 * UM, (ost_pm3){0, 0, 0});
    const ost_tool_geometry tg = {
        .dims = {100, 100, 100}, .voxel = 1000 * UM, .corner = {-50000 * UM, -50000 * UM, -50000 * UM}};
    const ost_pose pose = {.qw = OST_Q30_ONE};
    int16_t *voxels = random_densities(&rng, &g, 8);
    for (int n = 16; n <= 64; n *= 2) {
        ost_bone *bone[2];
        ost_removal_report report[2] = {{0}, {0}};
        for (int b = 0; b < 2; b++) {
            ost_backend *backend = b ? p.cl : p.ref;
            ost_tool *tool = solid_tool(backend, tg, OST_TOOL_CUTTING);
            bone[b] = bone_of(backend, &g, n, voxels);
            for (int again = 0; again < 3; again++) {
                remove_at(bone[b], &g, tool, &pose, 1, &report[b]);
                assert_int_equal(report[b].total_voxels, voxel_count(&g));
                assert_ok(ost_bone_upload(bone[b], 0, g.dims.z, voxels, &err));
            }
            ost_tool_free(tool);
        }
        assert_same_report(&report[0], &report[1]);
        assert_same_bones(bone[0], bone[1], &g);
        for (int b = 0; b < 2; b++) {
            ost_removal_report_free(&report[b]);
            ost_bone_free(bone[b]);
        }
    }
    free(voxels);
    close_pair(p);
}

static bool all_entered(void)
{
    for (int i = 0; i < path_count; i++)
        if (paths[i].entered == 0)
            return false;
    return true;
}

/* Samples a bone of 20^3 voxels, removes a cube, and samples the bone again. */
static void sample_twice(ost_backend *backend, ost_bone *bone, const ost_geometry *g, int16_t densities[2][20])
{
    ost_error err = {0};
    ost_removal_report report = {0};
    int32_t index[20];
    const int32_t *const diagonal[3] = {index, index, index};
    const ost_pose pose = ost_pose_identity();
    ost_tool *tool = solid_tool(backend, (ost_tool_geometry){{12, 12, 12}, 500 * UM, {0, 0, 0}}, OST_TOOL_CUTTING);
    for (int i = 0; i < 20; i++)
        index[i] = i;
    assert_ok(ost_bone_sample(bone, 20, diagonal, densities[0], &err));
    remove_at(bone, g, tool, &pose, 1, &report);
    assert_true(report.total_voxels > 0);
    assert_ok(ost_bone_sample(bone, 20, diagonal, densities[1], &err));
    ost_removal_report_free(&report);
    ost_tool_free(tool);
}

/* Fails if a path of the kernel set was never entered, because the results of such a path were not compared. This
   test must run last. */
static void every_path_was_entered(void **state)
{
    ost_error err = {0};
    pair p = open_pair(NULL);
    const ost_geometry g = cubic_geometry(20, 20, 20, 500 * UM, (ost_pm3){0, 0, 0});
    int16_t voxels[20 * 20 * 20], back[20 * 20 * 20];
    uint32_t words[2][16 * 16 * 16 / 32];
    int16_t densities[2][2][20];
    const int32_t chunk = 1;
    for (int i = 0; i < 20 * 20 * 20; i++)
        voxels[i] = (int16_t)(i % 3 * 200);
    ost_bone *bone[2], *empty;
    for (int b = 0; b < 2; b++) {
        bone[b] = bone_of(b ? p.cl : p.ref, &g, 16, voxels);
        assert_ok(ost_bone_occupancy(bone[b], 1, &chunk, words[b], &err));
        sample_twice(b ? p.cl : p.ref, bone[b], &g, densities[b]);
        ost_bone_free(bone[b]);
    }
    assert_memory_equal(words[0], words[1], sizeof words[0]);
    assert_memory_equal(densities[0], densities[1], sizeof densities[0]);
    assert_ok(ost_bone_create(p.cl, &g, 16, 120, &empty, &err));
    assert_ok(ost_bone_download(empty, 0, g.dims.z, back, &err));
    for (int i = 0; i < 20 * 20 * 20; i++)
        assert_int_equal(back[i], 0);
    ost_bone_free(empty);
    close_pair(p);
    /*
     * The tests are repeated, because their shapes are random and some shapes do not need a
     * second list, a second launch or a larger pool.
     */
    for (int again = 0; again < 10 && !all_entered(); again++) {
        bones(state);
        voxelizer(state);
        removal(state);
    }
    int missing = 0;
    for (int i = 0; i < path_count; i++)
        if (paths[i].entered == 0) {
            print_error("kernels=%s: the path '%s' was not entered\n", set, paths[i].name);
            missing++;
        }
    assert_int_equal(missing, 0);
    assert_true(path_count > 30);
}

/* Opens a backend with the kernel set. If the device cannot run the set, prints a message and returns 0. */
static int has_set(void)
{
    ost_error err = {0};
    char option[32], spec[256];
    ost_backend *backend;
    snprintf(option, sizeof option, "kernels=%s", set);
    spec_with(spec, sizeof spec, option);
    const ost_status status = ost_backend_open(spec, &backend, &err);
    if (status == OST_ERR_UNAVAILABLE && strstr(err.text, "too early for kernels=cpu")) {
        print_message("# skipped: %s\n", err.text);
        return 0;
    }
    assert_ok(status);
    ost_backend_close(backend);
    return 1;
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples),
        cmocka_unit_test(cubic),
        cmocka_unit_test(resampled_grid_and_source_are_independent),
        cmocka_unit_test(bones),
        cmocka_unit_test(voxelizer),
        cmocka_unit_test(removal),
        cmocka_unit_test(emptied_bone_reuses_its_slots),
        cmocka_unit_test(every_path_was_entered),
    };
    static const char *const sets[] = {"cpu", "gpu"};
    int failures = 0;
    for (int i = 0; i < 2; i++) {
        set = sets[i];
        path_count = 0;
        if (!strstr(device_spec(), "kernels=") ? has_set() : strstr(device_spec(), set) != NULL)
            failures += cmocka_run_group_tests_name(set, tests, NULL, NULL);
    }
    return failures;
}
