/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints the grid that the reader of CT texts finds in each file. The output for a file is one line "dims
 * spacing origin" of nine integers (in voxels and picometres), or "refused " and the message.
 * check_lattices.py compares these lines with the pseudo-code of docs/spec/arithmetic.md.
 *
 * Usage: dump_lattices FILE...
 */
#include <inttypes.h>
#include <stdio.h>

#include "io/text/scan.h"

static ost_status read_geometry(const char *path, ost_geometry *out, ost_error *err)
{
    ost_text_source source;
    ost_text_summary summary;
    const ost_pm3 found = {0, 0, 0};
    bool inferred[3];
    ost_text_summary_begin(&summary, found);
    ost_status status = ost_text_source_open(&source, path, err);
    if (status != OST_OK)
        return status;
    status = ost_text_scan(&source, found, NULL, NULL, NULL, &summary, err);
    if (status == OST_OK)
        status = ost_text_geometry(path, &summary, out, inferred, err);
    ost_text_summary_free(&summary);
    ost_text_source_close(&source);
    return status;
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        ost_geometry g;
        ost_error err;
        if (read_geometry(argv[i], &g, &err) == OST_OK)
            printf("%d %d %d %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 "\n", (int)g.dims.x,
                   (int)g.dims.y, (int)g.dims.z, g.spacing.x, g.spacing.y, g.spacing.z, g.origin.x, g.origin.y,
                   g.origin.z);
        else
            printf("refused %s\n", err.text);
    }
    return 0;
}
