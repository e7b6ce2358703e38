/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The five models of the thesis (Tables 3.1 and 3.2). The thesis' CTs are not public. Phantoms of the same dimensions
 * and spacings (phantom.h) or CTs of the user replace them.
 *
 *   phantom or the user's CT --> rect grid --> bone, counts
 *
 * A model is made when it is first used, and remains in memory until the model_store is freed. It needs 2 bytes
 * per voxel of the rect grid, which is 234 MB for all five phantoms.
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
    char name[MODEL_NAME]; /* name of the thesis' model, followed by "(own CT)" for a CT of the user */
    ost_volume rect;       /* densities of the CT */
    /* valid after a call of model_counted */
    ost_bone_info info[MODEL_CHUNK_SIZES]; /* properties of the bone with chunks of model_chunk[i]^3 voxels */
    int64_t surface_voxels; /* active voxels with a face neighbour that is not active */
} model;

typedef struct model_store {
    model model[MODELS];
    const char *ct[MODELS]; /* for each model, the file of the CT that replaces the phantom, or NULL; borrowed */
    ost_progress *progress;
    void *progress_user;
} model_store;

extern const char *const model_words[MODELS]; /* names of the models in --ct and in file names: "foam", "core-2", ... */

/* Returns a model with its rect grid. The pointer is valid until the store is freed. */
ost_status model_get(model_store *store, model_id id, const model **out, ost_error *err);
/* Returns a model whose counts are computed. */
ost_status model_counted(model_store *store, model_id id, const model **out, ost_error *err);
void model_store_free(model_store *store);

/*
 * Creates the bone of a model on a backend, with chunks of the given size. The cubic voxels are computed by linear
 * interpolation.
 */
ost_status model_bone(const model *m, ost_backend *backend, int chunk, ost_bone **out, ost_error *err);
/* Copies the cubic voxels of a model to host memory. The caller owns *out. */
ost_status model_cubic(const model *m, ost_volume *out, ost_error *err);
/* Reads the position of the scapula's glenoid from the facts of the CT. */
ost_status model_glenoid(const model *m, ost_glenoid *out, ost_error *err);
/* Returns true if the model is a CT of the user. In this case the values that the thesis states do not apply. */
bool model_is_own(const model_store *store, model_id id);

#endif
