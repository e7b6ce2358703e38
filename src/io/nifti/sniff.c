/* SPDX-License-Identifier: Apache-2.0 */
/* Recognises a NIfTI header by two fields: its size, in the first four bytes, and its magic string. */
#include "io/nifti/read.h"

#include <string.h>

static bool starts_with_size(const unsigned char *bytes, unsigned size)
{
    const unsigned char little[4] = {(unsigned char)size, (unsigned char)(size >> 8), 0, 0};
    const unsigned char big[4] = {0, 0, (unsigned char)(size >> 8), (unsigned char)size};
    return memcmp(bytes, little, 4) == 0 || memcmp(bytes, big, 4) == 0;
}

int ost_nifti_sniff(const unsigned char *bytes, size_t size)
{
    if (size >= 12 && starts_with_size(bytes, 540) &&
        (memcmp(bytes + 4, "n+2", 4) == 0 || memcmp(bytes + 4, "ni2", 4) == 0))
        return 2;
    if (size < OST_NIFTI_SNIFF || !starts_with_size(bytes, 348))
        return 0;
    return memcmp(bytes + 344, "n+1", 4) == 0 || memcmp(bytes + 344, "ni1", 4) == 0 ? 1 : 7;
}

bool ost_nifti_is_truncated(const unsigned char *bytes, size_t size)
{
    return size >= 4 && size < OST_NIFTI_SNIFF && starts_with_size(bytes, 348);
}
