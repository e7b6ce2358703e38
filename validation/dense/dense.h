/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A second implementation of the function table, written from
 * docs/spec/arithmetic.md alone, on dense arrays and with the simplest loops.
 *
 * Without a deviation it is evidence against mistakes that the reference and
 * the backends derived from it have in common: it has its own division, uses
 * neither far blocks nor the event's boxes, and processes rows and triangles in
 * their given order.
 * With a deviation it behaves as a port with that mistake (deviation.h).
 *
 * It belongs to the command's validation and not to the library: no backend
 * string opens it.
 */
#ifndef OST_VALIDATION_DENSE_H
#define OST_VALIDATION_DENSE_H

#include <osteon/backend.h>

#include "validation/dense/deviation.h"

/* Opens the dense backend. how may be NULL (no deviation). The caller closes *out with ost_backend_close. */
ost_status dense_open(const deviation *how, ost_backend **out, ost_error *err);

/* Returns the record of the deviation up to now; all zeros without one. backend must come from dense_open. */
deviation_record dense_record(ost_backend *backend);

#endif
