/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds two landmarks of a scapula, the trigonum spinae (TS) and the inferior angle (IA), from the scapula's cells
 * (field.h) and the face of its glenoid (G).
 *
 *                    acromion                          superior
 *      medial       .--------.                            ^
 *      border  .---/  spine   '--.  G  glenoid            |
 *             TS===.............---(                medial <--+  lateral
 *              |                 .'                 anterior and posterior: across the blade
 *              |  infraspinous .'
 *               \  fossa     .'
 *                '-- IA ----'
 *
 *   inferior angle  the bone's farthest point in the direction 20 degrees medial of inferior; the inferior direction
 *                   is first estimated from the point that is farthest from the glenoid
 *   posterior       the side of the blade's plane on which the spine rises
 *   trigonum        the point at which the line of the spine's crest meets the medial border
 */
#ifndef OST_ANATOMY_BLADE_H
#define OST_ANATOMY_BLADE_H

#include "anatomy/field.h"

typedef struct anatomy_cells {
    double (*at)[3]; /* owned; centres of the cells that are bone */
    size_t count;
} anatomy_cells;

typedef struct anatomy_blade {
    double trigonum[3], inferior[3];
    double superior[3]; /* unit vector in the plane of the blade, perpendicular to the medial direction */
    bool left;
} anatomy_blade;

/* Lists the cells whose share of bone is at least 0.3. Returns OST_ERR_INPUT if there are more than 2^21 such cells. */
ost_status ost_anatomy_cells_make(const anatomy_field *field, anatomy_cells *out, ost_error *err);
void ost_anatomy_cells_free(anatomy_cells *cells);

/*
 * Finds the landmarks of the blade. `centre` and `inward` are the centre and the inward axis of the glenoid's
 * face. Returns OST_ERR_INPUT with the reason if a landmark is not found.
 */
ost_status ost_anatomy_blade_find(const anatomy_cells *cells, const double centre[3], const double inward[3],
                                  double step, anatomy_blade *out, ost_error *err);

#endif
