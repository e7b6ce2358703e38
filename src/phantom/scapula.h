/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A right scapula as one implicit solid, in millimetres and in the scapula's own frame:
 *
 *            superior angle      acromion            x  lateral, from the root of the
 *                 .-.          .-------.                spine to the glenoid's centre
 *                /   `--. n .-' coracoid                (Friedman's line)
 *        root   (  spine===========-- )              y  anterior (the ribs' side)
 *        (0,0,0) \          neck  (   glenoid        z  superior
 *                 \            .-'    (99,0,0)
 *        medial    \         .'                      n  suprascapular notch
 *        border     \      .'  lateral border
 *                    `---'  inferior angle
 *
 * The mean shape is the mean of an adult population. The seed slightly changes size, version, inclination and outlines.
 */
#ifndef OST_PHANTOM_SCAPULA_H
#define OST_PHANTOM_SCAPULA_H

#include "phantom/shape.h"

typedef struct ost_scapula {
    uint64_t seed;
    double size;  /* size relative to the mean shape; all coordinates are in the frame of the mean shape */
    ost_v3 trigonum, inferior; /* landmarks; the trigonum is the root of the spine on the medial border */
    ost_v3 face;  /* centre of the glenoid's face, on the cartilage */
    /* Unit vectors of the glenoid's frame. out: outward; ahead: anterior along the face; above: superior along the
     * face. */
    ost_v3 out, ahead, above;
    ost_v3 dish, pad; /* centres of the spheres that form the bony dish (dish) and the face of the cartilage (pad) */
    ost_outline body, spine, acromion, pear;
    ost_bar crest, pillar, coracoid, root;
} ost_scapula;

/*
 * The position of a point relative to the parts of the scapula, in mm at its actual size. Distances are negative
 * inside.
 */
typedef struct ost_scapula_sample {
    double bone;      /* distance to the bone's surface, without cartilage */
    double wall;      /* distance to the outer walls of the bone, as if there were no dish */
    /* Depth below the surface of the bony dish, positive in the bone. Away from the glenoid, this is a large value. */
    double dish;
    double cartilage; /* distance to the layer of cartilage on the dish */
    double depth;     /* position along the glenoid's axis, positive into the bone */
    double ahead;     /* position along the glenoid's face, positive forward */
} ost_scapula_sample;

ost_status ost_scapula_init(ost_scapula *scapula, uint64_t seed, ost_error *err);
void ost_scapula_free(ost_scapula *scapula);
/* The segments of the bars (shape.h) that affect the samples in a ball. The scapula must outlive this struct. */
typedef struct ost_scapula_part {
    const ost_scapula *scapula;
    ost_bar_part crest, pillar, coracoid, root;
} ost_scapula_part;

/* Selects the segments for the ball around `centre`. A larger radius costs time but does not change the samples. */
void ost_scapula_near(const ost_scapula *scapula, ost_v3 centre, double radius, ost_scapula_part *part);
/* Computes the sample at p, which must lie in the ball of `part`. Any ball that contains p gives the same result. */
void ost_scapula_at(const ost_scapula_part *part, ost_v3 p, ost_scapula_sample *out);

#endif
