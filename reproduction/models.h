/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The five models of the thesis (Tables 3.1 and 3.2). The thesis' CTs are not public, so that phantoms of
 * the same dimensions and spacings take their places (phantom.h), or a CT of the user.
 *
 *   phantom or the user's CT --> rect grid --> bone, counts
 *
 * A model is made when it is first used, and stays in memory until the store is freed: 2 bytes per voxel
 * of the rect grid, 234 MB for all five phantoms.
 */
#ifndef OST_REPRODUCTION_MODELS_H
#define OST_REPRODUCTION_MODELS_H

#include <osteon/backend.h>
#include <osteon/grid.h>
#include <osteon/sim.h>

typedef enum model_id { MODEL_FOAM, MODEL_CORE_2, MODEL_CORE_1, MODEL_SCAPULA, MODEL_GLENOID, MODELS } model_id;

enum { MODEL_THRESHOLD = 120, MODEL_CHUNK_SIZES = 3, MODEL_CHUNK_32 = 1, MODEL_NAME = 96 };
extern const int model_chunk[MODEL_CHUNK_SIZES]; /* 16, 32, 64 */

typedef struct model {
    bool made, counted;
    char name[MODEL_NAME]; /* name of the thesis' model, and "(own CT)" for a CT of the user */
    ost_volume rect;       /* densities as in the CT */
    /* after model_counted */
    ost_bone_info info[MODEL_CHUNK_SIZES]; /* of the bone with chunks of model_chunk[i]^3 voxels */
    int64_t surface_voxels; /* active voxels with a face neighbour that is not active */
} model;

typedef struct model_store {
    model model[MODELS];
    const char *ct[MODELS]; /* file of a CT that takes the place of a model; NULL: the phantom; borrowed */
    ost_progress *progress;
    void *progress_user;
} model_store;

extern const char *const model_words[MODELS]; /* words for --ct and file names: "foam", "core-2", ... */

/* Returns a model with its rect grid. The pointer is valid until the store is freed. */
ost_status model_get(model_store *store, model_id id, const model **out, ost_error *err);
/* Returns a model whose counts are also known. */
ost_status model_counted(model_store *store, model_id id, const model **out, ost_error *err);
void model_store_free(model_store *store);

/* Creates the bone of a model on a backend: cubic voxels by linear interpolation, in chunks of the given size. */
ost_status model_bone(const model *m, ost_backend *backend, int chunk, ost_bone **out, ost_error *err);
/* Copies the cubic voxels of a model to host memory. The caller owns *out. */
ost_status model_cubic(const model *m, ost_volume *out, ost_error *err);
/* Reads the glenoid of the scapula from the facts of its CT. */
ost_status model_glenoid(const model *m, ost_glenoid *out, ost_error *err);
/* Returns true if the model is a CT of the user. The figures of the thesis do not apply to it. */
bool model_is_own(const model_store *store, model_id id);

#endif
