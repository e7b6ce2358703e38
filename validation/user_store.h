/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stores the user's own files as cases. The files are read once, before any backend runs, and stored as the
 * integers that every backend gets.
 *
 *   CT, meshes, paths --the command reads and checks--> user_case_begin, _samples, _end
 *        '--> a file without a name (scratch.h) --mapped by this process and every worker--> user_scene
 *
 * A worker inherits the store as descriptor WORKER_USER. The worker has neither the original files nor their
 * names. Samples remain in the mapped store, 32 bytes each, so that memory use does not grow with the number
 * of workers.
 */
#ifndef OST_VALIDATION_USER_STORE_H
#define OST_VALIDATION_USER_STORE_H

#include "validation/scene.h"

enum { USER_CASES_MAX = 16 };
typedef struct user_store user_store;

/* ---------------------------------------------------------- writing a store */

ost_status user_store_begin(user_store **out, ost_error *err);
/* Appends samples to the next case. Backends scatter the samples in this order. Sets the line number of each sample. */
ost_status user_case_samples(user_store *u, const ost_sample *samples, size_t count, size_t batch, ost_error *err);
/*
 * Adds all data of the case except its samples. The members `samples`, `sample_count` and `batch` of `head` are
 * ignored.
 */
ost_status user_case_end(user_store *u, const scene *head, ost_error *err);
/* Completes the store. Afterwards user_scene can make the cases. */
ost_status user_store_end(user_store *u, ost_error *err);

/* ---------------------------------------------------------- reading a store */

/*
 * Opens the store in a worker. The caller remains the owner of `fd`. Returns OST_ERR_INPUT if `fd` is not a user store.
 */
ost_status user_store_open(int fd, user_store **out, ost_error *err);
void user_store_free(user_store *u); /* u may be NULL */

int user_store_count(const user_store *u);
/* Returns the descriptor to be passed to workers, or -1 if u is NULL. */
int user_store_fd(const user_store *u);

/* Generates case `number`, counted from 1. The scene borrows its samples from the store. */
ost_status user_scene(const user_store *u, int number, scene *out, ost_error *err);
uint64_t user_trace_bytes(const user_store *u, int number);

#endif
