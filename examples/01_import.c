/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 01: converts a CT to a bone.
 *
 *   01_import CT BONE.nrrd
 *
 * CT is a text file with lines "x y z density", an NRRD file or a NIfTI file. The
 * bone is a grid with equal spacing on all axes. It contains only the voxels with
 * a density of at least 120 HU.
 */
#include <osteon/osteon.h>

#include <stdio.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL; /* the object that stores the voxels and executes all operations */
    ost_bone *bone = NULL;
    ost_import_result result;
    ost_bone_info info;
    ost_status status;

    if (argc != 3) {
        fprintf(stderr, "usage: 01_import CT BONE.nrrd\n");
        return 2;
    }

    status = ost_backend_open("cpu", &backend, &err);
    if (!status)
        status = ost_import(backend, argv[1], NULL, &bone, &result, &err);
    if (!status)
        status = ost_bone_info_get(bone, &info, &err);
    if (!status) /* result.meta contains facts such as the glenoid's position, which are copied to the output file */
        status = ost_bone_write(argv[2], bone, &result.meta, NULL, &err);

    if (status) /* one line of text with the file, the position in the file, the value, and what was expected */
        fprintf(stderr, "01_import: %s\n", err.text);
    else
        printf("%lld active voxels in %lld of %lld chunks\n", (long long)info.active_voxels,
               (long long)info.active_chunks, (long long)info.chunks);

    /* Free the objects first, then their backend. All these functions accept NULL. */
    ost_bone_free(bone);
    ost_backend_close(backend);
    return ost_status_exit(status);
}
