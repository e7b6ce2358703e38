/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The user's own files as cases: they are read once, before any backend runs,
 * and stored as the integers that every backend gets.
 *
 *   CT, meshes, paths --the command reads and checks--> user_case_begin, _samples, _end
 *        '--> a file without a name (scratch.h) --mapped by this process and every worker--> user_scene
 *
 * A worker has the store as descriptor WORKER_USER; it has neither the files
 * that were read nor their names.  Samples stay in the store, 32 bytes each, so
 * that memory does not grow with the number of workers.
 */
#ifndef OST_VALIDATION_USER_STORE_H
#define OST_VALIDATION_USER_STORE_H

#include "validation/scene.h"

enum { USER_CASES_MAX = 16 };
typedef struct user_store user_store;

/* ------------------------------------------------------------------ writing */

ost_status user_store_begin(user_store **out, ost_error *err);
/* Samples of the next case, in the order in which they are scattered; their lines are set here. */
ost_status user_case_samples(user_store *u, const ost_sample *samples, size_t count, size_t batch, ost_error *err);
/* Adds the case except its samples; samples, sample_count and batch of head are ignored. */
ost_status user_case_end(user_store *u, const scene *head, ost_error *err);
/* Ends the writing; afterwards user_scene can make the cases. */
ost_status user_store_end(user_store *u, ost_error *err);

/* ------------------------------------------------------------------ reading */

/* Called in a worker. fd remains owned by the caller. Returns OST_ERR_INPUT if it is not a user store. */
ost_status user_store_open(int fd, user_store **out, ost_error *err);
void user_store_free(user_store *u); /* u may be NULL */

int user_store_count(const user_store *u);
/* Returns the descriptor to be passed to workers, or -1 without a store. */
int user_store_fd(const user_store *u);

/* Makes case `number`, counted from 1; its samples are borrowed from the store. */
ost_status user_scene(const user_store *u, int number, scene *out, ost_error *err);
uint64_t user_trace_bytes(const user_store *u, int number);

#endif
