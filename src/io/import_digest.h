/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_IMPORT_DIGEST_H
#define OST_IO_IMPORT_DIGEST_H

#include <osteon/backend.h>
#include <osteon/digest.h>

/*
 * Computes the digest of a grid. Downloads one slab of leaves at a time. `path` is the imported file, for error
 * messages.
 */
ost_status ost_import_digest(const char *path, ost_grid_kind kind, const ost_grid *grid, ost_digest *out,
                             ost_error *err);

#endif
