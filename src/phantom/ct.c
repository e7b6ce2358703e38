/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Generates a CT of the scapula: an image of the solid that scapula.h defines, in the
 * pose of a lying patient.
 *
 *   voxel centre --pose--> the bone's frame --scapula_at--> distances
 *        distances --cover--> shares of soft tissue, cartilage, plate and
 *        shell, spongy bone --> HU, + noise
 *
 * At a surface, a share changes smoothly over the width of a voxel (partial volume). Noise does not move any voxel
 * across 120 HU. Therefore only the surface determines which voxels are bone, and there are no isolated bone
 * voxels.
 *
 * Far from the bone there is only soft tissue.  The grid is computed in blocks.  A
 * block is background if its centre is so far from the bone that the corners of the
 * block cannot reach the bone.
 */
#include <stdio.h>

#include "phantom/noise.h"
#include "phantom/scan.h"
#include "phantom/scapula.h"

#define ACTIVE 120 /* default threshold, for which the phantom is designed */
/*
 * SHELL is the thickness in mm of the compact bone on the outer walls. A plate thinner than 2 SHELL has no spongy core.
 */
#define SHELL 1.4
#define PLATE 1.9  /* thickness of compact bone under the cartilage in mm */

/*
 * The pose of the scapula in the patient. Each of the three rotations is given by the tangent of half its angle, so
 * that the rotation matrix is rational and requires no libm.
 */
#define TURN_HALF 0.21 /* 24 degrees: the lateral end of the blade is turned forward out of the coronal plane */
#define LEAN_HALF 0.09 /* 10 degrees: the top of the blade leans forward */
/* 18 degrees: the lateral end of the blade is lifted, as if the arms were raised out of the beam */
#define LIFT_HALF 0.16
static const ost_v3 MIDDLE = {53.85, 19.0, -32.7}; /* position of the centre of the box in the bone's frame */

typedef struct pose {
    /* Rotation matrix: its rows are the patient's lateral, anterior and superior directions in the bone's frame. */
    ost_v3 row[3];
    ost_v3 centre;   /* centre of the box in the patient's LPS frame, in mm */
    double scale;    /* size relative to the mean shape */
} pose;

static pose make_pose(double scale)
{
    double t = TURN_HALF, c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);
    double l = LEAN_HALF, a = (1 - l * l) / (1 + l * l), b = 2 * l / (1 + l * l);
    double h = LIFT_HALF, e = (1 - h * h) / (1 + h * h), f = 2 * h / (1 + h * h);
    /*
     * The lift rotates the bone in the plane of the blade, the lean rotates it about the lateral axis, and the turn
     * rotates it about the vertical axis.
     */
    ost_v3 lift[3] = {{e, 0, -f}, {0, 1, 0}, {f, 0, e}};
    const double basis[3][3] = {{c, -s * a, -s * b}, {s, c * a, c * b}, {0, -b, a}};
    pose p = {.scale = scale};
    for (int r = 0; r < 3; r++) {
        p.row[r] = (ost_v3){0, 0, 0};
        for (int k = 0; k < 3; k++)
            p.row[r] = ost_v3_mad(p.row[r], lift[k], basis[r][k]);
    }
    return p;
}

static ost_v3 to_bone(const pose *p, ost_v3 lps)
{
    ost_v3 d = {-(lps.x - p->centre.x) / p->scale, -(lps.y - p->centre.y) / p->scale, (lps.z - p->centre.z) / p->scale};
    return (ost_v3){MIDDLE.x + p->row[0].x * d.x + p->row[1].x * d.y + p->row[2].x * d.z,
                    MIDDLE.y + p->row[0].y * d.x + p->row[1].y * d.y + p->row[2].y * d.z,
                    MIDDLE.z + p->row[0].z * d.x + p->row[1].z * d.y + p->row[2].z * d.z};
}

static ost_v3 turn_to_lps(const pose *p, ost_v3 v)
{
    return (ost_v3){-ost_v3_dot(p->row[0], v), -ost_v3_dot(p->row[1], v), ost_v3_dot(p->row[2], v)};
}

static ost_v3 to_lps(const pose *p, ost_v3 bone)
{
    ost_v3 v = turn_to_lps(p, ost_v3_sub(bone, MIDDLE));
    return ost_v3_mad(p->centre, v, p->scale);
}

/* ----------------------------------------------------------------- tissue */

/*
 * Returns the density of the soft tissue: muscles separated by sheets of fat, and the lung inside the chest. The
 * density is below 100 HU.
 */
static double soft_tissue(uint64_t seed, ost_noise_cell cells[2], ost_v3 p, double bone)
{
    double x = (0.8 * p.x + 0.6 * p.y + 0.3 * p.z) / 23, y = (0.8 * p.y - 0.6 * p.x - 0.2 * p.z) / 19, z = p.z / 45;
    double belly = ost_value_noise_in(&cells[0], seed + 31, x, y, z);
    double seam = ost_value_noise_in(&cells[1], seed + 32, x + 0.9 * belly, y - 0.7 * belly, z);
    double off = seam - 0.5;
    off = off < 0 ? -off : off;
    double hu = 52 + 10 * (belly - 0.5);
    hu += (-95 - hu) * (1 - ost_smooth(0.015, 0.05, off)) * ost_smooth(1, 4, bone);
    double u = (p.x + 22) / 62, v = (p.y + 88) / 66, w = (p.z + 62) / 130;
    double chest = u * u + v * v + w * w;
    if (chest < 1)
        hu += (-840 + 60 * belly - hu) * ost_smooth(1, 0.97, chest);
    return hu;
}

/*
 * Returns the density, in HU, of spongy bone in a CT. Spongy bone consists of struts about a millimetre in size. It is
 * denser toward the back and under the plate, and less dense in the processes.
 */
static double spongy(uint64_t seed, ost_v3 q, const ost_scapula_sample *at)
{
    double coarse = ost_value_noise(seed + 21, q.x / 1.5, q.y / 1.5, q.z / 1.9);
    double fine = ost_value_noise(seed + 22, q.x / 0.8, q.y / 0.8, q.z / 0.8);
    double mesh = 2 * coarse - 1;
    mesh = 1 - (mesh < 0 ? -mesh : mesh);
    double hu = 165 + 200 * mesh * mesh + 90 * (fine - 0.5);
    if (at->dish < 40)
        hu += 55 * ost_smooth(12, 2, at->dish) + 70 * ost_smooth(4, -12, at->ahead);
    return hu;
}

int16_t ost_hu(double v, int lo, int hi)
{
    int64_t r = ost_floor64(v + 0.5);
    return (int16_t)(r < lo ? lo : r > hi ? hi : r);
}

static int16_t voxel_hu(const ost_scan *scan, ost_noise_cell cells[2], const ost_scapula_sample *at, ost_v3 p, ost_v3 q,
                        double blur, uint64_t hash)
{
    double noise = 24 * ost_bell(hash); /* The standard deviation is 12 HU, as with a smooth reconstruction kernel. */
    double soft = soft_tissue(scan->seed, cells, p, at->bone);
    double gristle = ost_scan_cover(at->cartilage, 0.5 * blur), bone = ost_scan_cover(at->bone, blur);
    double hu = soft + (135 - soft) * gristle;
    int lo = -1024, hi = 3071;
    if (bone > 0) {
        double core = -ost_min(-at->wall - SHELL, at->dish - PLATE);
        double inner = ost_scan_cover(core, blur);
        double grain = ost_value_noise(scan->seed + 23, q.x / 3, q.y / 3, q.z / 3);
        double hard = 1120 + 320 * grain;
        if (at->dish < 6)
            hard += 120 * ost_smooth(6, 0, at->dish) + 110 * ost_smooth(4, -12, at->ahead);
        if (inner > 0) {
            double soft_core = ost_clamp(spongy(scan->seed, q, at), 150, 500);
            hard += (soft_core - hard) * inner;
            if (inner == 1 && bone == 1)
                lo = 150, hi = 500;
        }
        hu += (hard - hu) * bone;
        noise *= 1.25;
    } else if (gristle == 1) {
        lo = ACTIVE + 1, hi = ACTIVE + 29; /* range of the density class to which cartilage belongs */
    }
    if (hu >= ACTIVE)
        lo = lo > ACTIVE ? lo : ACTIVE;
    else
        hi = ACTIVE - 1;
    return ost_hu(hu + noise, lo, hi);
}

/* ---------------------------------------------------------------- humerus */

#define HEAD_RADIUS 24.0
#define TOUCHING 0.0     /* depth in mm to which the head penetrates the cartilage */
#define SHAFT_RADIUS 11.0
#define SHAFT_LENGTH 90.0

/* A humerus in the bone's frame: a ball in front of the glenoid, and a shaft below the ball. */
typedef struct humerus {
    ost_v3 head, end; /* ends of the shaft's axis; `head` is also the centre of the head */
    double size;      /* size relative to the mean shape */
} humerus;

static humerus make_humerus(const ost_scapula *s)
{
    humerus h = {.size = s->size, .head = ost_v3_mad(s->face, s->out, HEAD_RADIUS - TOUCHING)};
    h.end = ost_v3_mad(ost_v3_mad(h.head, s->above, -SHAFT_LENGTH), s->out, 0.2 * SHAFT_LENGTH);
    return h;
}

/* Returns the signed distance from q to the surface of the humerus, in mm at the actual size of the bone. */
static double humerus_distance(const humerus *h, ost_v3 q)
{
    const ost_v3 axis = ost_v3_sub(h->end, h->head), from = ost_v3_sub(q, h->head);
    const double along = ost_clamp(ost_v3_dot(from, axis) / ost_v3_dot(axis, axis), 0, 1);
    const double head = ost_v3_length(from) - HEAD_RADIUS,
                 shaft = ost_v3_length(ost_v3_mad(from, axis, -along)) - SHAFT_RADIUS;
    return ost_blend(head, shaft, 6) * h->size;
}

/*
 * Returns the density of a voxel of the scapula's CT after adding the humerus, which has a compact shell and a spongy
 * core.
 */
static int16_t with_humerus(int16_t hu, double distance, double blur, uint64_t hash)
{
    const double share = ost_scan_cover(distance, blur), inner = ost_scan_cover(distance + SHELL, blur);
    if (share == 0)
        return hu;
    const double hard = 1150 + (220 - 1150) * inner + 30 * ost_bell(hash);
    return ost_hu(hu > hard ? hu : hu + (hard - hu) * share, -1024, 3071);
}

/* ------------------------------------------------------------------- scan */

typedef struct scanner {
    const ost_scan *scan;
    ost_scapula scapula;
    humerus humerus;
    pose pose;
    double blur;     /* mean spacing in mm before scaling; passed to ost_scan_cover as the width */
    int64_t first[3]; /* index of this grid's first voxel in the grid for which the noise is defined */
} scanner;

static ost_v3 centre_of(const ost_scan *scan, int64_t i, int64_t j, int64_t k)
{
    const ost_pm3 *s = &scan->volume->geometry.spacing;
    return (ost_v3){ost_scan_mm(scan->corner.x, s->x, i), ost_scan_mm(scan->corner.y, s->y, j),
                    ost_scan_mm(scan->corner.z, s->z, k)};
}

static void scan_block(void *user, const int lo[3], const int hi[3])
{
    const scanner *c = user;
    const ost_scan *scan = c->scan;
    const ost_geometry *g = &scan->volume->geometry;
    ost_v3 a = centre_of(scan, lo[0], lo[1], lo[2]), b = centre_of(scan, hi[0] - 1, hi[1] - 1, hi[2] - 1);
    const ost_v3 middle = to_bone(&c->pose, ost_v3_mad(a, ost_v3_sub(b, a), 0.5));
    ost_scapula_sample at;
    ost_scapula_part part;
    ost_scapula_near(&c->scapula, middle, 0, &part);
    ost_scapula_at(&part, middle, &at);
    /*
     * A computed distance is at most 1.5 times the true distance. If the computed distances from a block's centre to
     * the bone and to the cartilage are both greater than `reach`, no voxel of the block depends on a surface.
     */
    double reach = 1.5 * 0.5 * ost_v3_length(ost_v3_sub(b, a)) / scan->scale + c->blur + 4;
    ost_noise_cell cells[2] = {{.known = 0}, {.known = 0}};
    bool empty = at.bone > reach && at.cartilage > reach;
    if (!empty) /* the pose only rotates and scales the ball; 1e-6 mm exceeds the rounding errors of its radius */
        ost_scapula_near(&c->scapula, middle, 0.5 * ost_v3_length(ost_v3_sub(b, a)) / c->pose.scale + 1e-6, &part);
    for (int k = lo[2]; k < hi[2]; k++)
        for (int j = lo[1]; j < hi[1]; j++) {
            int16_t *row = scan->volume->voxels + (size_t)g->dims.x * ((size_t)j + (size_t)g->dims.y * (size_t)k);
            for (int i = lo[0]; i < hi[0]; i++) {
                ost_v3 p = centre_of(scan, i, j, k), q = {0, 0, 0};
                if (!empty) {
                    q = to_bone(&c->pose, p);
                    ost_scapula_at(&part, q, &at);
                }
                uint64_t hash = ost_hash3(scan->seed + 41, c->first[0] + i, c->first[1] + j, c->first[2] + k);
                row[i] = voxel_hu(scan, cells, &at, p, q, c->blur, hash);
                if (scan->has_humerus)
                    row[i] = with_humerus(row[i], humerus_distance(&c->humerus, to_bone(&c->pose, p)), c->blur, hash);
            }
        }
}

/*
 * Writes a point, rounded to micrometres, or a direction, rounded to millionths. The numbers are rounded explicitly and
 * printed as integers by %lld, so that the text is the same on every machine.
 */
static ost_status write_three(ost_meta *meta, const char *key, ost_v3 v, int places, ost_error *err)
{
    char text[OST_META_VALUE], word[3][48];
    const double in[3] = {v.x, v.y, v.z};
    const int64_t unit = places == 3 ? 1000 : 1000000;
    for (int a = 0; a < 3; a++) {
        int64_t n = ost_floor64(in[a] * (double)unit + 0.5), m = n < 0 ? -n : n;
        snprintf(word[a], sizeof word[a], "%s%lld.%0*lld", n < 0 ? "-" : "", (long long)(m / unit), places,
                 (long long)(m % unit));
    }
    snprintf(text, sizeof text, "%s %s %s", word[0], word[1], word[2]);
    return ost_meta_set(meta, key, text, err);
}

static ost_status write_meta(const scanner *c, ost_error *err)
{
    ost_meta *meta = &c->scan->volume->meta;
    const ost_v3 axis = turn_to_lps(&c->pose, c->scapula.out);
    ost_status status = write_three(meta, OST_META_GLENOID_AT, to_lps(&c->pose, c->scapula.face), 3, err);
    if (status == OST_OK)
        status = write_three(meta, OST_META_GLENOID_AXIS, (ost_v3){-axis.x, -axis.y, -axis.z}, 6, err);
    if (status == OST_OK)
        status = write_three(meta, OST_META_TRIGONUM, to_lps(&c->pose, c->scapula.trigonum), 3, err);
    if (status == OST_OK)
        status = write_three(meta, OST_META_INFERIOR_ANGLE, to_lps(&c->pose, c->scapula.inferior), 3, err);
    if (status == OST_OK && c->scan->has_humerus)
        status = write_three(meta, OST_SCAN_HEAD, to_lps(&c->pose, c->humerus.head), 3, err);
    return status;
}

ost_status ost_scan_scapula(const ost_scan *scan, ost_error *err)
{
    const ost_geometry *g = &scan->volume->geometry;
    scanner c = {.scan = scan};
    ost_status status = ost_scapula_init(&c.scapula, scan->seed, err);
    if (status != OST_OK)
        return status;
    c.humerus = make_humerus(&c.scapula);
    c.pose = make_pose(scan->scale * c.scapula.size);
    c.pose.centre = (ost_v3){-110 * scan->scale, -15 * scan->scale, 0}; /* centre of the scapula's box (phantom.c) */
    double spacing[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    c.blur = (spacing[0] + spacing[1] + spacing[2]) / 3 / scan->scale;
    const ost_pm corner[3] = {scan->corner.x, scan->corner.y, scan->corner.z},
                 extent[3] = {scan->extent.x, scan->extent.y, scan->extent.z};
    const ost_pm step[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    for (int a = 0; a < 3; a++)
        c.first[a] = (corner[a] - extent[a]) / (2 * step[a]);
    status = ost_scan_blocks(scan, 4, scan_block, &c, err);
    if (status == OST_OK)
        status = write_meta(&c, err);
    ost_scapula_free(&c.scapula);
    return status;
}
