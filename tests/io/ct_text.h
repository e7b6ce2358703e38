/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes CT texts. The code is independent of the library's writer: positions are rounded half up, and
 * densities follow a formula that gives different values in neighbouring layers.
 */
#ifndef OST_TESTS_CT_TEXT_H
#define OST_TESTS_CT_TEXT_H

#include <stdint.h>
#include <stdio.h>

typedef struct ct_text {
    int dims[3];
    int64_t spacing[3]; /* in picometres, as is `origin` */
    int64_t origin[3];
    int decimals;
} ct_text;

static inline int ct_density(int i, int j, int k)
{
    return (i * 31 + j * 57 + k * 101) % 3000 - 500;
}

static inline void ct_put_length(FILE *file, int64_t pm, int decimals)
{
    int64_t unit = 1000000000, one = 1;
    for (int d = 0; d < decimals; d++) {
        unit /= 10;
        one *= 10;
    }
    int64_t shifted = pm + unit / 2;
    int64_t units = shifted / unit - (shifted % unit < 0);
    int64_t magnitude = units < 0 ? -units : units;
    fprintf(file, "%s%lld", units < 0 ? "-" : "", (long long)(magnitude / one));
    if (decimals > 0)
        fprintf(file, ".%0*lld", decimals, (long long)(magnitude % one));
}

static inline void ct_text_write(const char *path, const ct_text *ct)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int k = 0; k < ct->dims[2]; k++)
        for (int j = 0; j < ct->dims[1]; j++)
            for (int i = 0; i < ct->dims[0]; i++) {
                ct_put_length(file, ct->origin[0] + i * ct->spacing[0], ct->decimals);
                fputc(' ', file);
                ct_put_length(file, ct->origin[1] + j * ct->spacing[1], ct->decimals);
                fputc(' ', file);
                ct_put_length(file, ct->origin[2] + k * ct->spacing[2], ct->decimals);
                fprintf(file, " %d\n", ct_density(i, j, k));
            }
    assert_int_equal(fclose(file), 0);
}

#endif
