/* SPDX-License-Identifier: Apache-2.0 */
/* Reads a CT in text form by fscanf, the usual method of C programs. */
#include "bench/baseline.h"

#include <stdio.h>

#include "core/file.h"

size_t bench_fscanf_lines(const char *path, float *positions, int16_t *densities, size_t capacity)
{
    FILE *file;
    (void)ost_file_stream(path, &file, NULL, NULL);
    size_t count = 0;
    int density, first;
    if (!file)
        return 0;
    /* Skips the comments that osteon writes before the first line of voxels. */
    while ((first = fgetc(file)) == '#')
        while (first != '\n' && first != EOF)
            first = fgetc(file);
    ungetc(first, file);
    while (count < capacity && fscanf(file, "%f %f %f %d", &positions[3 * count], &positions[3 * count + 1],
                                      &positions[3 * count + 2], &density) == 4)
        densities[count++] = (int16_t)density;
    fclose(file);
    return count;
}
