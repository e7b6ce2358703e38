/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shaded view: orthographic, one ray for each sub-pixel, first hit, no display.
 *
 *        eye plane            field (field.h)
 *      up ^                  .-------.
 *         |  ----- ray ---->/  *hit  /|     step a sample, bisect the
 *         +--> right        '-------' |     crossing, skip empty bricks
 *
 * Shading: the normal is the field's gradient; there are a key light from the
 * upper left of the picture with a soft shadow, a weaker light from the right, and
 * light from all sides reduced by ambient occlusion.  Shadow and occlusion are
 * computed by cones that are marched through the field's coarser levels: the
 * wider the cone is at a position, the coarser the level.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <cglm/cglm.h>

#include "render/canvas.h"
#include "render/field.h"

enum { RAYS = 4, CONES = 9 }; /* rays for each pixel; cones for the ambient occlusion of a hit */
/* Value of the field at the surface; a plate of one voxel still reaches about this value. */
static const float SURFACE = 0.40f;

/* Colours in linear light: of bone (#e3dac9) and of a fresh cut. */
static const vec3 BONE = {0.768f, 0.701f, 0.584f};
static const vec3 CUT = {0.72f, 0.105f, 0.045f};

typedef struct scene {
    ost_field bone, removed; /* removed has no levels if there is no `before` */
    vec3 right, up, forward; /* directions of the picture in mm, unit vectors */
    vec3 key, fill;          /* directions toward the lights */
    vec3 cones[CONES];       /* directions about +z, cosine-distributed */
    vec3 inv_step;
    float step_mm;
} scene;

static void to_samples(const ost_field *field, const vec3 mm, vec3 out)
{
    for (int a = 0; a < 3; a++)
        out[a] = (mm[a] - (float)field->origin_mm[a]) / (float)field->step_mm[a];
}

/* ------------------------------------------------------------------ rays */

/*
 * Computes the part of the ray o + t d (in samples) inside the field's box; returns false if it
 * misses the box.
 */
static bool clip(const ost_field *field, const vec3 o, const vec3 d, float *t0, float *t1)
{
    *t0 = 0, *t1 = 1e30f;
    for (int a = 0; a < 3; a++) {
        float lo = 0.0f, hi = (float)(field->level[0].n[a] - 1);
        if (fabsf(d[a]) < 1e-9f) {
            if (o[a] < lo || o[a] > hi)
                return false;
            continue;
        }
        float ta = (lo - o[a]) / d[a], tb = (hi - o[a]) / d[a];
        *t0 = fmaxf(*t0, fminf(ta, tb));
        *t1 = fminf(*t1, fmaxf(ta, tb));
    }
    return *t0 < *t1;
}

/* Returns the t at which the ray leaves the brick. */
static float brick_exit(const vec3 o, const vec3 d, const int brick[3])
{
    float t = 1e30f;
    for (int a = 0; a < 3; a++)
        if (fabsf(d[a]) >= 1e-9f)
            t = fminf(t, ((float)((brick[a] + (d[a] > 0)) * OST_FIELD_BRICK) - o[a]) / d[a]);
    return t;
}

static bool march(const ost_field *field, const vec3 o, const vec3 d, float step, vec3 hit)
{
    float t, end;
    if (!clip(field, o, d, &t, &end))
        return false;
    uint8_t least = (uint8_t)(SURFACE * 255.0f);
    for (float before = t; t < end; before = t, t += step) {
        vec3 p = {o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]};
        int brick[3];
        for (int a = 0; a < 3; a++) {
            brick[a] = (int)p[a] / OST_FIELD_BRICK;
            brick[a] = brick[a] < 0 ? 0 : brick[a] >= field->bricks[a] ? field->bricks[a] - 1 : brick[a];
        }
        if (field->brick_max[brick[0] + field->bricks[0] * (brick[1] + (size_t)field->bricks[1] * (size_t)brick[2])] <= least) {
            float out = brick_exit(o, d, brick);
            if (out > t)
                t = out; /* the loop's step moves the ray beyond the border */
            continue;
        }
        if (ost_field_at(field, 0, p) < SURFACE)
            continue;
        float in = t, outside = before;
        for (int i = 0; i < 6; i++) {
            float mid = 0.5f * (in + outside);
            vec3 q = {o[0] + mid * d[0], o[1] + mid * d[1], o[2] + mid * d[2]};
            if (ost_field_at(field, 0, q) < SURFACE)
                outside = mid;
            else
                in = mid;
        }
        for (int a = 0; a < 3; a++)
            hit[a] = o[a] + in * d[a];
        return true;
    }
    return false;
}

/* --------------------------------------------------------------- shading */

static const float NORMAL_WEIGHT[3] = {0.4f, 0.5f, 0.25f};

/*
 * Computes the outward normal at p (in samples): gradients over one, two and four samples, each
 * from its own level.
 */
static void normal_at(scene *s, vec3 p, vec3 n)
{
    for (int a = 0; a < 3; a++) {
        float sum = 0;
        for (int level = 0; level < 3; level++) {
            vec3 lo, hi;
            glm_vec3_copy(p, lo);
            glm_vec3_copy(p, hi);
            lo[a] -= (float)(1 << level);
            hi[a] += (float)(1 << level);
            sum += NORMAL_WEIGHT[level] * (ost_field_at(&s->bone, level, lo) - ost_field_at(&s->bone, level, hi));
        }
        n[a] = sum * s->inv_step[a];
    }
    if (glm_vec3_norm(n) < 1e-9f)
        glm_vec3_negate_to(s->forward, n);
    glm_vec3_normalize(n);
}

/*
 * Returns the share of light that reaches p (in samples) along a cone about the unit direction d
 * (mm). spread: ratio of its diameter to its length.
 */
static float cone(scene *s, const vec3 p, const vec3 d, float start, float reach, float spread)
{
    float light = 1.0f;
    for (float t = start; t < reach && light > 0.02f;) {
        float width = fmaxf(t * spread, s->step_mm);
        float level = log2f(width / s->step_mm);
        int coarse = (int)level;
        coarse = coarse > s->bone.levels - 1 ? s->bone.levels - 1 : coarse;
        vec3 q;
        for (int a = 0; a < 3; a++)
            q[a] = p[a] + t * d[a] * s->inv_step[a];
        float filled = ost_field_at(&s->bone, coarse, q);
        light *= 1.0f - fminf(1.0f, filled * 1.25f);
        t += width * 0.75f;
    }
    return light;
}

/*
 * The shares of the sky and of the key light that reach a position.  They are slow to compute
 * and vary slowly, so sub-pixels share them.
 */
typedef struct surroundings {
    vec3 at; /* in samples */
    bool known;
    float open, key;
} surroundings;

static void look_about(scene *s, vec3 from, vec3 n, surroundings *out)
{
    vec3 tangent, bitangent;
    glm_vec3_ortho(n, tangent);
    glm_vec3_normalize(tangent);
    glm_vec3_cross(n, tangent, bitangent);
    float reach = 60.0f * s->step_mm, open = 0;
    for (int i = 0; i < CONES; i++) {
        vec3 d;
        for (int a = 0; a < 3; a++)
            d[a] = s->cones[i][0] * tangent[a] + s->cones[i][1] * bitangent[a] + s->cones[i][2] * n[a];
        open += cone(s, from, d, 1.5f * s->step_mm, reach, 0.7f);
    }
    out->open = open / CONES;
    out->key = glm_vec3_dot(n, s->key) > 0 ? 0.25f + 0.75f * cone(s, from, s->key, 1.5f * s->step_mm, 2.5f * reach, 0.18f) : 0;
}

static void shade(scene *s, vec3 p, surroundings *about, vec3 out)
{
    vec3 n, from;
    normal_at(s, p, n);
    for (int a = 0; a < 3; a++)
        from[a] = p[a] + 1.2f * n[a] * s->step_mm * s->inv_step[a];
    if (!about->known || glm_vec3_distance2(about->at, p) > 4.0f) {
        look_about(s, from, n, about);
        glm_vec3_copy(p, about->at);
        about->known = true;
    }

    float key = fmaxf(glm_vec3_dot(n, s->key), 0) * about->key, fill = fmaxf(glm_vec3_dot(n, s->fill), 0);
    float facing = fmaxf(-glm_vec3_dot(n, s->forward), 0), sky = 0.5f + 0.5f * glm_vec3_dot(n, s->up);
    float light = 0.78f * key + 0.16f * fill + about->open * (0.20f + 0.14f * sky + 0.10f * facing);

    vec3 half;
    glm_vec3_sub(s->key, s->forward, half);
    glm_vec3_normalize(half);
    float gloss = fmaxf(glm_vec3_dot(n, half), 0);
    gloss *= gloss, gloss *= gloss, gloss *= gloss, gloss *= gloss; /* 16th power */
    gloss *= key > 0 ? 0.07f * about->open : 0;

    float cut = 0;
    if (s->removed.levels) {
        vec3 mm, q;
        for (int a = 0; a < 3; a++)
            mm[a] = (float)s->bone.origin_mm[a] + from[a] / s->inv_step[a];
        to_samples(&s->removed, mm, q);
        cut = glm_smoothstep(0.22f, 0.42f, ost_field_at(&s->removed, 0, q));
    }
    for (int a = 0; a < 3; a++) {
        float albedo = BONE[a] + cut * (CUT[a] - BONE[a]);
        /*
         * Light that was reflected between bone surfaces is warmer: deep positions become redder
         * and not black.
         */
        float warm = albedo + (1.0f - about->open) * 0.25f * (albedo * albedo - albedo);
        out[a] = warm * light + gloss;
    }
}

/* ---------------------------------------------------------------- picture */

static uint8_t to_srgb(float v)
{
    v = v < 0 ? 0 : v > 1 ? 1 : v;
    v = v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1.0f / 2.4f) - 0.055f;
    return (uint8_t)(v * 255.0f + 0.5f);
}

typedef struct pick_bone {
    const int16_t *now, *before;
    int32_t threshold;
} pick_bone;

/*
 * Returns a greater weight for denser voxels, from the threshold to compact bone: partial volume
 * smooths the surface, and the inner texture is hardly visible.
 */
static void weigh_bone(const void *user, size_t voxel, uint8_t *weight)
{
    const pick_bone *pick = user;
    int32_t over = pick->now[voxel] - pick->threshold;
    *weight = (uint8_t)(over < 0 ? 0 : over >= 600 ? 255 : 135 + over / 5);
}

static void weigh_removed(const void *user, size_t voxel, uint8_t *weight)
{
    const pick_bone *pick = user;
    *weight = pick->before[voxel] >= pick->threshold && pick->now[voxel] < pick->threshold ? 255 : 0;
}

static ost_status look(scene *s, const ost_view_options *o, ost_error *err)
{
    vec3 forward = {(float)o->direction[0], (float)o->direction[1], (float)o->direction[2]};
    vec3 up = {(float)o->up[0], (float)o->up[1], (float)o->up[2]};
    if (glm_vec3_norm(forward) < 1e-12f)
        glm_vec3_copy((vec3){0, 1, 0}, forward);
    if (glm_vec3_norm(up) < 1e-12f)
        glm_vec3_copy(fabsf(forward[2]) > 0.99f * glm_vec3_norm(forward) ? (vec3){0, -1, 0} : (vec3){0, 0, 1}, up);
    glm_vec3_normalize(forward);
    glm_vec3_cross(forward, up, s->right);
    if (!(glm_vec3_norm(s->right) > 1e-4f * glm_vec3_norm(up)))
        return ost_fail(err, OST_ERR_USAGE, "the view's direction %g %g %g and its up %g %g %g are parallel", o->direction[0],
                        o->direction[1], o->direction[2], o->up[0], o->up[1], o->up[2]);
    glm_vec3_normalize(s->right);
    glm_vec3_cross(s->right, forward, s->up);
    glm_vec3_copy(forward, s->forward);
    for (int a = 0; a < 3; a++) {
        s->key[a] = -0.52f * s->right[a] + 0.62f * s->up[a] - 0.70f * s->forward[a];
        s->fill[a] = 0.80f * s->right[a] - 0.10f * s->up[a] - 0.55f * s->forward[a];
    }
    glm_vec3_normalize(s->key);
    glm_vec3_normalize(s->fill);
    for (int i = 0; i < CONES; i++) { /* a sunflower pattern on the disc, projected onto the hemisphere */
        float r2 = ((float)i + 0.5f) / CONES, angle = 2.3999632f * (float)i;
        s->cones[i][0] = sqrtf(r2) * cosf(angle);
        s->cones[i][1] = sqrtf(r2) * sinf(angle);
        s->cones[i][2] = sqrtf(1.0f - r2);
    }
    return OST_OK;
}

/* Computes a light background that is a little darker toward the bottom. */
static void backdrop(const ost_picture *picture, int y, vec3 out)
{
    float f = (float)y / (float)picture->height;
    out[0] = 0.93f - 0.10f * f;
    out[1] = 0.94f - 0.095f * f;
    out[2] = 0.955f - 0.085f * f;
}

static void paint(scene *s, const vec3 centre, float extent, ost_picture *out)
{
    /* A rotated square of four positions, so that vertical and horizontal edges cross them one at a time. */
    static const float place[RAYS][2] = {{-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}, {-0.375f, 0.125f}};
    float pixel = extent / (float)out->height;
    vec3 d;
    float step = 1e30f, back = 0;
    for (int a = 0; a < 3; a++) {
        d[a] = s->forward[a] * s->inv_step[a]; /* samples per mm */
        step = fminf(step, (float)s->bone.step_mm[a]);
        back += (float)(s->bone.level[0].n[a] * s->bone.step_mm[a]);
    }
    for (int y = 0; y < out->height; y++)
        for (int x = 0; x < out->width; x++) {
            vec3 sum = {0, 0, 0}, behind;
            surroundings about = {.known = false};
            backdrop(out, y, behind);
            for (int k = 0; k < RAYS; k++) {
                float u = ((float)x + 0.5f + place[k][0] - 0.5f * (float)out->width) * pixel;
                float v = (0.5f * (float)out->height - (float)y - 0.5f - place[k][1]) * pixel;
                vec3 mm, o, hit, colour;
                for (int a = 0; a < 3; a++)
                    mm[a] = centre[a] + u * s->right[a] + v * s->up[a] - back * s->forward[a];
                to_samples(&s->bone, mm, o);
                if (s->bone.levels && march(&s->bone, o, d, step, hit))
                    shade(s, hit, &about, colour);
                else
                    glm_vec3_copy(behind, colour);
                glm_vec3_add(sum, colour, sum);
            }
            uint8_t *rgb = out->rgb + 3 * ((size_t)y * (size_t)out->width + (size_t)x);
            for (int a = 0; a < 3; a++)
                rgb[a] = to_srgb(sum[a] / RAYS);
        }
}

static void annotate(scene *s, double mm_per_pixel, ost_picture *out)
{
    static const ost_rgb ink = {0x5a, 0x61, 0x6b};
    int least = out->width < out->height ? out->width : out->height;
    int scale = least >= 1600 ? 4 : least >= 1000 ? 3 : least >= 480 ? 2 : 1;
    int margin = 6 * scale, high = OST_GLYPH_HEIGHT * scale;
    ost_canvas_scale_bar(out, margin, out->height - margin, out->width / 4, mm_per_pixel, scale, ink);
    for (int side = 0; side < 4; side++) {
        const float *axis = side < 2 ? s->right : s->up;
        double sign = side % 2 ? -1 : 1, direction[3];
        char letters[4];
        for (int a = 0; a < 3; a++)
            direction[a] = sign * axis[a];
        ost_orientation_letters(direction, letters);
        int wide = ost_canvas_text_width(letters, scale);
        int x = side == 0 ? out->width - margin - wide : side == 1 ? margin : (out->width - wide) / 2;
        int y = side < 2 ? (out->height - high) / 2 : side == 2 ? margin : out->height - margin - high;
        ost_canvas_text(out, x, y, scale, ink, letters);
    }
}

/* Computes extent and centre of a view of all active voxels, from the bricks that contain some. */
static double frame(scene *s, double aspect, vec3 centre)
{
    const ost_field *f = &s->bone;
    vec3 lo = {1e30f, 1e30f, 1e30f}, hi = {-1e30f, -1e30f, -1e30f}; /* along right, up, forward */
    size_t at = 0;
    for (int z = 0; z < f->bricks[2]; z++)
        for (int y = 0; y < f->bricks[1]; y++)
            for (int x = 0; x < f->bricks[0]; x++)
                if (f->brick_max[at++] > SURFACE * 255.0f) {
                    const int b[3] = {x, y, z};
                    vec3 mm;
                    for (int a = 0; a < 3; a++)
                        mm[a] = (float)(f->origin_mm[a] + (b[a] + 0.5) * OST_FIELD_BRICK * f->step_mm[a]);
                    vec3 p = {glm_vec3_dot(mm, s->right), glm_vec3_dot(mm, s->up), glm_vec3_dot(mm, s->forward)};
                    glm_vec3_minv(lo, p, lo);
                    glm_vec3_maxv(hi, p, hi);
                }
    if (lo[0] > hi[0])
        glm_vec3_zero(lo), glm_vec3_zero(hi);
    vec3 middle, half;
    glm_vec3_lerp(lo, hi, 0.5f, middle);
    glm_vec3_sub(hi, middle, half);
    for (int a = 0; a < 3; a++)
        centre[a] = middle[0] * s->right[a] + middle[1] * s->up[a] + middle[2] * s->forward[a];
    float brick = 0.5f * OST_FIELD_BRICK * s->step_mm;
    double high = half[1] + brick, wide = (half[0] + brick) / aspect;
    return 2.2 * (high > wide ? high : wide);
}

ost_status ost_picture_view(const ost_volume *volume, const ost_volume *before, const ost_view_options *options, ost_picture *out,
                            ost_error *err)
{
    static const ost_view_options defaults;
    const ost_view_options *o = options ? options : &defaults;
    memset(out, 0, sizeof *out);
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "a view needs a volume with voxels");
    if (before && (!before->voxels || !ost_geometry_equal(&volume->geometry, &before->geometry)))
        return ost_fail(err, OST_ERR_USAGE, "the volume before and the one after must have the same dims, spacing and origin");

    pick_bone pick = {volume->voxels, before ? before->voxels : NULL, o->threshold > 0 ? o->threshold : 120};
    scene s;
    memset(&s, 0, sizeof s);
    ost_status status = look(&s, o, err);
    if (status != OST_OK)
        return status;
    int lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
    /* so the view stays the same while bone is removed */
    ost_field_bounds(before ? before : volume, pick.threshold, lo, hi);
    if (hi[2] == 0)
        lo[0] = lo[1] = lo[2] = 0, hi[0] = hi[1] = hi[2] = 1;
    status = ost_field_init(&s.bone, volume, lo, hi, weigh_bone, &pick, OST_FIELD_LEVELS, err);
    if (status == OST_OK && before)
        status = ost_field_init(&s.removed, volume, lo, hi, weigh_removed, &pick, 1, err);
    if (status == OST_OK)
        status = ost_picture_init(out, o->width > 0 ? o->width : 800, o->height > 0 ? o->height : 800, err);
    if (status == OST_OK) {
        s.step_mm = 1e30f;
        for (int a = 0; a < 3; a++) {
            s.inv_step[a] = (float)(1.0 / s.bone.step_mm[a]);
            s.step_mm = fminf(s.step_mm, (float)s.bone.step_mm[a]);
        }
        vec3 centre = {(float)o->centre_mm[0], (float)o->centre_mm[1], (float)o->centre_mm[2]};
        double extent = o->extent_mm > 0 ? o->extent_mm : frame(&s, (double)out->width / out->height, centre);
        paint(&s, centre, (float)extent, out);
        annotate(&s, extent / out->height, out);
    }
    ost_field_free(&s.removed);
    ost_field_free(&s.bone);
    return status;
}
