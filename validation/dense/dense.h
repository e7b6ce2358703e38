/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A second implementation of the function table. It was written only from the text of
 * docs/spec/arithmetic.md, and uses dense arrays and simple loops.
 *
 * Without a deviation, its results show whether the reference and the backends derived from the reference
 * have an error in common. It has its own functions for integer division, uses neither far blocks nor the
 * event's boxes, and processes rows and triangles in their given order. With a deviation (deviation.h), it
 * behaves like a backend that contains this deliberate mistake.
 *
 * The second implementation is part of the command and not of the library, so no backend string opens it.
 */
#ifndef OST_VALIDATION_DENSE_H
#define OST_VALIDATION_DENSE_H

#include <osteon/backend.h>

#include "validation/dense/deviation.h"

/* Opens the dense backend. `how` is the deviation, or NULL for correct results. The caller closes *out with
   ost_backend_close. */
ost_status dense_open(const deviation *how, ost_backend **out, ost_error *err);

/* Returns the current record of the deviation; all zeros if there is no deviation. The backend must have been opened by
   dense_open. */
deviation_record dense_record(ost_backend *backend);

#endif
