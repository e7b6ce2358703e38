/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A second implementation of the whole function table, written from
 * docs/arithmetic.md alone, on dense arrays and with the plainest loops.
 *
 * Without a deviation it is evidence against mistakes that the reference and
 * those who were built after it share: it divides by its own division, knows
 * neither far blocks nor the event's boxes, and takes rows and triangles as
 * they come.
 * With one it is the port that made that mistake (deviation.h).
 *
 * Part of the command's validation, never of the library: no string opens it.
 */
#ifndef OST_VALIDATION_DENSE_H
#define OST_VALIDATION_DENSE_H

#include <osteon/backend.h>

#include "validation/dense/deviation.h"

/* how may be NULL. Close with ost_backend_close. */
ost_status dense_open(const deviation *how, ost_backend **out, ost_error *err);

/* What the deviation did until now; zeros without one. backend came from dense_open. */
deviation_record dense_record(ost_backend *backend);

#endif
