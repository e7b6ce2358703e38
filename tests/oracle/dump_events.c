/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints the library's results for seeded cases. check_events.py computes the results again with exact
 * fractions. The cases are sweeps, maps, and complete removal events on small grids. The program reads no
 * input. A case is one line of key=value words, with values in picometres and Q30:
 *
 *   sweep  s= tool= a= b=                 n= (0 if refused) pose1= ... (three poses)
 *   map    extreme= s= o= dims= tool= pose=  step= block=x,y,z,near,base (three blocks)
 *   event  s= o= dims= tool= seed= a= b=  n= touched= density= hits= (numbers of voxels)
 *
 * Usage: dump_events SEED COUNT BACKEND
 *
 * Densities and tool classes are functions of the voxel's number and the case's seed (`mix`
 * below), so that grids need not be printed.
 *
 * A third of the poses are random. The other poses are constructed so that voxels lie on borders. Their
 * rotations are the 24 rotations of a cube, given by quaternions whose lengths differ from 1 by up to
 * 1/1000. Their translations are multiples of half a voxel and of half a unit of 2^-20.
 */
#include <osteon/backend.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UM (OST_PM_PER_MM / 1000)

static uint64_t state;

static uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static int64_t pick(int64_t lo, int64_t hi)
{
    state += UINT64_C(0x9e3779b97f4a7c15);
    return lo + (int64_t)(mix(state) % (uint64_t)(hi - lo + 1));
}

static void fail(const ost_error *err)
{
    fprintf(stderr, "dump_events: %s\n", err->text);
    exit(1);
}

/* ---------------------------------------------------------------- cases */

/*
 * Makes a random rotation. A random point of the 4-ball is multiplied by 2^30 and divided by its
 * length, which is an integer square root. |q| is then 1 to within a few parts per million.
 */
static void random_turn(int32_t q[4])
{
    int64_t c[4], n, root;
    do {
        n = 0;
        for (int a = 0; a < 4; a++) {
            c[a] = pick(-(1 << 20), 1 << 20);
            n += c[a] * c[a];
        }
    } while (n > INT64_C(1) << 40 || n < INT64_C(1) << 36);
    root = 0;
    for (int64_t bit = INT64_C(1) << 21; bit; bit >>= 1)
        if ((root + bit) * (root + bit) <= n)
            root += bit;
    for (int a = 0; a < 4; a++)
        q[a] = (int32_t)(c[a] * OST_Q30_ONE / root);
}

/*
 * Makes one of the 24 rotations of a cube: one, two or four components have the same magnitude,
 * and |q| is 1 or just within one of the limits 0.999 and 1.001.
 */
static void cube_turn(int32_t q[4])
{
    /*
     * Magnitudes of components. The rows contain 2^30 divided by 1, sqrt 2 and 2. The columns contain these
     * values multiplied by 0.999 (rounded up), by 1, and by 1.001 (rounded down).
     */
    static const int32_t magnitude[3][3] = {
        {1072668083, OST_Q30_ONE, 1074815565}, {758490875, 759250125, 760009375}, {536334042, 536870912, 537407782}};
    int parts = (int)pick(0, 2), length = (int)pick(0, 2);
    memset(q, 0, 4 * sizeof *q);
    if (parts == 0) {
        q[pick(0, 3)] = magnitude[0][length];
    } else if (parts == 1) {
        int i = (int)pick(0, 3), j = (int)pick(0, 2);
        j += j >= i;
        q[i] = magnitude[1][length];
        q[j] = pick(0, 1) ? magnitude[1][length] : -magnitude[1][length];
    } else {
        for (int a = 0; a < 4; a++)
            q[a] = pick(0, 1) ? magnitude[2][length] : -magnitude[2][length];
    }
}

/*
 * Returns a pose around the position `around`. The parameter `style` selects the possible positions: any
 * position, multiples of half a tool voxel, or multiples of half a unit of 2^-20 of a tool voxel.
 */
static ost_pose make_pose(int style, ost_pm3 around, ost_pm spread, ost_pm tool_voxel)
{
    int32_t q[4];
    if (style == 0)
        random_turn(q);
    else
        cube_turn(q);
    ost_pm step = style == 0 ? 1 : style == 1 ? tool_voxel / 2 : tool_voxel >> 21 ? tool_voxel >> 21 : 1;
    ost_pm t[3] = {around.x, around.y, around.z};
    for (int a = 0; a < 3; a++)
        t[a] += step * pick(-(spread / step), spread / step);
    ost_pose pose = {{t[0], t[1], t[2]}, q[0], q[1], q[2], q[3]};
    ost_error err = {0};
    if (ost_pose_check(&pose, &err) != OST_OK)
        fail(&err);
    return pose;
}

typedef struct sizes {
    ost_pm bone, tool;
} sizes;

/*
 * Chooses the voxel sizes of bone and tool from a list. The list contains the thesis' sizes, ratios such as 1, 2 and
 * 16, powers of two, and sizes with many digits.
 */
static sizes make_sizes(void)
{
    static const sizes some[] = {
        {470 * UM, 500 * UM},
        {470 * UM, 470 * UM},
        {470 * UM, 235 * UM},
        {1000 * UM, 500 * UM},
        {1600 * UM, 100 * UM},
        {16000, 1000000},
        {32 * UM, 500 * UM},
        {INT64_C(1) << 30, INT64_C(1) << 30},
        {INT64_C(1) << 31, INT64_C(1) << 30},
        {INT64_C(1) << 30, INT64_C(1) << 26},
        {488281250, 333333333},
        {100000 * UM, 6250 * UM},
    };
    sizes s = some[pick(0, (int64_t)(sizeof some / sizeof some[0]) - 1)];
    s.bone = s.bone < OST_SPACING_MIN ? OST_SPACING_MIN : s.bone;
    return s;
}

/* ---------------------------------------------------------------- print */

static void print_pose(const char *key, const ost_pose *p)
{
    printf(" %s=%" PRId64 ",%" PRId64 ",%" PRId64 ",%" PRId32 ",%" PRId32 ",%" PRId32 ",%" PRId32, key, p->t.x, p->t.y,
           p->t.z, p->qw, p->qx, p->qy, p->qz);
}

static void print_tool(const ost_tool_geometry *t)
{
    printf(" tool=%d,%d,%d,%" PRId64 ",%" PRId64 ",%" PRId64 ",%" PRId64, t->dims.x, t->dims.y, t->dims.z, t->voxel,
           t->corner.x, t->corner.y, t->corner.z);
}

static void print_bone(const ost_geometry *g)
{
    printf(" s=%" PRId64 " o=%" PRId64 ",%" PRId64 ",%" PRId64 " dims=%d,%d,%d", g->spacing.x, g->origin.x, g->origin.y,
           g->origin.z, g->dims.x, g->dims.y, g->dims.z);
}

static void print_step(const ost_map *map)
{
    printf(" step=");
    for (int i = 0; i < 9; i++)
        printf("%s%" PRId32, i ? "," : "", map->step[i / 3][i % 3]);
}

/* ---------------------------------------------------------------- sweeps */

static ost_pose moved(const ost_pose *a, ost_pm by)
{
    ost_pose b = *a;
    b.t.x += pick(-by, by);
    b.t.y += pick(-by, by);
    b.t.z += pick(-by, by);
    int32_t *q[4] = {&b.qw, &b.qx, &b.qy, &b.qz};
    int64_t turn = pick(0, 3) ? INT64_C(2000000) : 0;
    for (int c = 0; c < 4; c++) {
        int64_t value = *q[c] + (*q[c] > 0 ? -pick(0, turn / 8) : *q[c] < 0 ? pick(0, turn / 8) : pick(-turn, turn));
        *q[c] = (int32_t)value;
    }
    if (pick(0, 3) == 0)
        for (int c = 0; c < 4; c++)
            *q[c] = -*q[c];
    return ost_pose_check(&b, NULL) == OST_OK ? b : *a;
}

static void dump_sweep(void)
{
    sizes s = make_sizes();
    ost_tool_geometry tool = {
        {(int32_t)pick(1, 1024), (int32_t)pick(1, 100), (int32_t)pick(1, 9)},
        s.tool,
        {pick(-OST_PM_PER_MM, OST_PM_PER_MM) * 40, pick(-OST_PM_PER_MM, OST_PM_PER_MM) * 40, -s.tool * 3}};
    ost_pose a = make_pose((int)pick(0, 2), (ost_pm3){0, 0, 0}, OST_PM_PER_MM * 100, s.tool), b;
    switch (pick(0, 4)) {
    case 0: /* These are two random poses; the rotation between them is often too large for a sweep. */
        b = make_pose((int)pick(0, 2), a.t, s.bone * 40, s.tool);
        break;
    case 1: /* The motion is near a multiple of half a bone voxel, where the number of poses changes. */
        b = a;
        b.t.y += s.bone / 2 * pick(-5000, 5000) + pick(-1, 1);
        break;
    case 2: /* The rotation is an exact quarter turn, or slightly more. */
        a.qw = OST_Q30_ONE;
        a.qx = a.qy = a.qz = 0;
        b = a;
        b.qw = b.qz = 759250125;
        b.qw -= (int32_t)pick(0, 1);
        break;
    default:
        b = moved(&a, s.bone * 3);
    }
    if (ost_pose_check(&b, NULL) != OST_OK) /* The pose is beyond 8 m. */
        b = a;
    int n;
    if (ost_sweep_count(&a, &b, &tool, s.bone, &n, NULL) != OST_OK)
        n = 0;
    printf("sweep s=%" PRId64, s.bone);
    print_tool(&tool);
    print_pose("a", &a);
    print_pose("b", &b);
    printf(" n=%d", n);
    const int ks[3] = {1, (n + 1) / 2, n};
    for (int i = 0; i < 3 && n > 0; i++) {
        ost_pose p = ost_sweep_pose(&a, &b, ks[i], n);
        char key[16];
        snprintf(key, sizeof key, "pose%d", ks[i]);
        print_pose(key, &p);
    }
    printf("\n");
}

/* ------------------------------------------------------------------ maps */

/*
 * Moves bone, tool and pose as far apart as the ranges of AR-MAP-7 allow: bone and pose are at
 * opposite ends of 16 m, and |q| is near 1.001.
 */
static void go_to_the_limits(ost_geometry *g, ost_tool_geometry *tool, ost_pose *pose)
{
    const ost_pm v = OST_SPACING_MAX;
    g->dims = (ost_dims){40, 35, 30};
    g->spacing = (ost_pm3){v, v, v};
    tool->voxel = v;
    const int32_t bone_dims[3] = {g->dims.x, g->dims.y, g->dims.z},
                  tool_dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z};
    ost_pm *o[3] = {&g->origin.x, &g->origin.y, &g->origin.z}, *t[3] = {&pose->t.x, &pose->t.y, &pose->t.z};
    ost_pm *c[3] = {&tool->corner.x, &tool->corner.y, &tool->corner.z};
    for (int a = 0; a < 3; a++) {
        bool low = pick(0, 1);
        *o[a] = low ? -OST_LENGTH_MAX : OST_LENGTH_MAX - (bone_dims[a] - 1) * v;
        *t[a] = low ? OST_LENGTH_MAX : -OST_LENGTH_MAX;
        *c[a] = pick(0, 1) ? -OST_LENGTH_MAX : OST_LENGTH_MAX - tool_dims[a] * v;
    }
    ost_pose longer = *pose;
    int32_t *q[4] = {&longer.qw, &longer.qx, &longer.qy, &longer.qz};
    for (int k = 0; k < 4; k++)
        *q[k] += *q[k] / 1010;
    if (ost_pose_check(&longer, NULL) == OST_OK)
        *pose = longer;
}

static void dump_map(int style)
{
    ost_error err = {0};
    sizes s = make_sizes();
    ost_geometry g = {.dims = {256, 234, 428}, .spacing = {s.bone, s.bone, s.bone}};
    if (s.bone > 10000 * UM) /* The grid has fewer voxels, so that it stays within 8 m. */
        g.dims = (ost_dims){40, 35, 30};
    bool round_origin = style != 0 && pick(0, 1);
    ost_pm unit = round_origin ? s.bone : 1;
    g.origin = (ost_pm3){pick(-20, 20) * unit, pick(-20, 20) * unit, pick(-20, 20) * unit};
    ost_tool_geometry tool = {
        {(int32_t)pick(1, 80), (int32_t)pick(1, 80), (int32_t)pick(1, 80)},
        s.tool,
        {-s.tool * pick(0, 40), -s.tool * pick(0, 40), style ? -s.tool * pick(0, 40) : pick(-s.tool, s.tool)}};
    ost_dims at = {(int32_t)pick(0, g.dims.x - 1), (int32_t)pick(0, g.dims.y - 1), (int32_t)pick(0, g.dims.z - 1)};
    ost_pm3 around = {g.origin.x + at.x * s.bone, g.origin.y + at.y * s.bone, g.origin.z + at.z * s.bone};
    ost_pose pose = make_pose(style, around, 10 * s.bone, s.tool);
    bool extreme = pick(0, 5) == 0;
    if (extreme)
        go_to_the_limits(&g, &tool, &pose);
    ost_map map;
    if (ost_map_make(&pose, &g, &tool, &map, &err) != OST_OK)
        fail(&err);
    printf("map extreme=%d", extreme);
    print_bone(&g);
    print_tool(&tool);
    print_pose("pose", &pose);
    print_step(&map);
    for (int i = 0; i < 3; i++) {
        ost_dims block = {at.x / 16, at.y / 16, at.z / 16};
        if (i == 1)
            block = (ost_dims){(int32_t)pick(0, (g.dims.x - 1) / 16), (int32_t)pick(0, (g.dims.y - 1) / 16),
                               (int32_t)pick(0, (g.dims.z - 1) / 16)};
        if (i == 2)
            block = (ost_dims){0, 0, 0};
        int32_t base[3] = {0, 0, 0};
        bool near = ost_map_block_base(&map, block, base);
        if (!near)
            memset(base, 0, sizeof base);
        printf(" block=%d,%d,%d,%d,%" PRId32 ",%" PRId32 ",%" PRId32, block.x, block.y, block.z, near, base[0], base[1],
               base[2]);
    }
    printf("\n");
}

/* ---------------------------------------------------------------- events */

enum { POSES_MAX = 12 };

static void dump_event(ost_backend *backend, int style)
{
    ost_error err = {0};
    sizes s = make_sizes();
    int32_t ratio = (int32_t)(s.bone / s.tool + 1);
    ost_geometry g = {.dims = {(int32_t)pick(1, 36), (int32_t)pick(1, 20), (int32_t)pick(1, 20)},
                      .spacing = {s.bone, s.bone, s.bone}};
    g.origin = (ost_pm3){pick(-9, 9) * s.bone, pick(-9, 9) * s.bone / 2, pick(-9, 9)};
    ost_tool_geometry tool = {{(int32_t)pick(1, 12) * ratio, (int32_t)pick(1, 9) * ratio, (int32_t)pick(1, 4) * ratio},
                              s.tool,
                              {-s.tool * pick(0, 8), -s.tool * pick(0, 8), style ? 0 : pick(-s.tool, 0)}};
    uint64_t seed = (uint64_t)pick(0, 1 << 30);
    ost_pm3 around = {g.origin.x + pick(0, g.dims.x) * s.bone, g.origin.y + pick(0, g.dims.y) * s.bone,
                      g.origin.z + pick(0, g.dims.z) * s.bone};
    ost_pose a = make_pose(style, around, 4 * s.bone, s.tool), b = pick(0, 2) ? moved(&a, s.bone) : a;
    int n = 0;
    if (ost_sweep_count(&a, &b, &tool, s.bone, &n, NULL) != OST_OK || n > POSES_MAX) {
        b = a;
        n = 1;
    }

    size_t count = (size_t)ost_dims_count(g.dims);
    int16_t *before = malloc(count * sizeof *before), *after = malloc(count * sizeof *after);
    ost_tool_volume volume;
    ost_bone *bone;
    ost_tool *on_backend;
    ost_map maps[POSES_MAX];
    ost_voxel_box boxes[POSES_MAX];
    ost_density_classes classes = ost_density_classes_default();
    ost_removal_report report = {0};
    if (!before || !after || ost_tool_volume_init(&volume, &tool, &err) != OST_OK)
        fail(&err);
    for (size_t v = 0; v < count; v++) {
        uint64_t h = mix(seed + v);
        before[v] = h % 8 == 0 ? 0 : (int16_t)(120 + h / 8 % 1000);
    }
    for (int64_t v = 0; v < ost_dims_count(tool.dims); v++) {
        uint64_t h = mix(seed + (UINT64_C(1) << 40) + (uint64_t)v) % 8;
        volume.voxels[v] = h < 6 ? OST_TOOL_CUTTING : h == 6 ? OST_TOOL_NONCUTTING : OST_TOOL_VOID;
    }
    for (int k = 1; k <= n; k++) {
        ost_pose p = ost_sweep_pose(&a, &b, k, n);
        if (ost_map_make(&p, &g, &tool, &maps[k - 1], &err) != OST_OK)
            fail(&err);
        boxes[k - 1] = (ost_voxel_box){.hi = {g.dims.x, g.dims.y, g.dims.z}};
    }
    ost_removal_event event = {.pose_count = n, .maps = maps, .boxes = boxes, .classes = &classes};
    if (ost_bone_create(backend, &g, 16 << pick(0, 2), 120, &bone, &err) != OST_OK ||
        ost_bone_upload(bone, 0, g.dims.z, before, &err) != OST_OK ||
        ost_tool_upload(backend, &volume, &on_backend, &err) != OST_OK ||
        ost_bone_remove(bone, on_backend, &event, &report, &err) != OST_OK ||
        ost_bone_download(bone, 0, g.dims.z, after, &err) != OST_OK)
        fail(&err);

    printf("event");
    print_bone(&g);
    print_tool(&tool);
    printf(" seed=%" PRIu64, seed);
    print_pose("a", &a);
    print_pose("b", &b);
    printf(" n=%d touched=%" PRIu64 " density=%" PRId64 ",%" PRId64 ",%" PRId64 " hits=", n, report.touched_voxels,
           report.density[0], report.density[1], report.density[2]);
    const char *comma = "";
    for (size_t v = 0; v < count; v++)
        if (after[v] != before[v]) {
            printf("%s%zu", comma, v);
            comma = ",";
        }
    printf("\n");
    ost_removal_report_free(&report);
    ost_tool_free(on_backend);
    ost_bone_free(bone);
    ost_tool_volume_free(&volume);
    free(before);
    free(after);
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: dump_events SEED COUNT BACKEND\n");
        return 2;
    }
    ost_error err = {0};
    ost_backend *backend;
    state = strtoull(argv[1], NULL, 0);
    long count = strtol(argv[2], NULL, 0);
    if (ost_backend_open(argv[3], &backend, &err) != OST_OK)
        fail(&err);
    for (long i = 0; i < count; i++) {
        dump_sweep();
        dump_map((int)(i % 3));
        if (i % 10 == 0)
            dump_event(backend, (int)(i / 10 % 3));
    }
    ost_backend_close(backend);
    return 0;
}
