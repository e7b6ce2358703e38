/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 01: a CT to a bone.
 *
 *   01_import CT BONE.nrrd
 *
 * CT is a text of "x y z density" lines, an NRRD or a NIfTI.  The bone is a
 * grid of equal spacing on all axes that keeps what is at least 120 HU.
 */
#include <osteon/osteon.h>

#include <stdio.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL; /* who keeps the voxels and works on them */
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
    if (!status) /* result.meta: where the glenoid is and the like, carried from file to file */
        status = ost_bone_write(argv[2], bone, &result.meta, NULL, &err);

    if (status) /* one line: the file, the place in it, the value, what was expected */
        fprintf(stderr, "01_import: %s\n", err.text);
    else
        printf("%lld active voxels in %lld of %lld chunks\n", (long long)info.active_voxels, (long long)info.active_chunks,
               (long long)info.chunks);

    /* Objects first, then the backend they live on. NULL is allowed everywhere. */
    ost_bone_free(bone);
    ost_backend_close(backend);
    return ost_status_exit(status);
}
