/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as CT text. The result must be a geometry within its bounds, or an
 * error of one line that names the file. The grid itself is not created, so the memory does not
 * depend on its size.
 */
#include "fuzz.h"

#include "io/text/scan.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *path = fuzz_file("ct.txt", data, size);
    ost_error err = {0};
    ost_text_source source;
    ost_text_summary summary;
    ost_geometry geometry;
    bool inferred[3];
    ost_status status = ost_text_source_open(&source, path, &err);
    fuzz_require(status == OST_OK);
    status = ost_text_scan(&source, (ost_pm3){0, 0, 0}, NULL, NULL, NULL, &summary, &err);
    if (status == OST_OK)
        status = ost_text_geometry(path, &summary, &geometry, inferred, &err);
    if (status == OST_OK) {
        fuzz_require(ost_geometry_check(&geometry, "grid", NULL) == OST_OK);
        fuzz_require(summary.fingerprint.rows > 0);
        /* The second pass must read the same rows. */
        ost_text_fingerprint again = {0, 0};
        ost_text_row rows[64];
        size_t count = 1;
        fuzz_require(ost_text_source_rewind(&source, &err) == OST_OK);
        while (count > 0) {
            fuzz_require(ost_text_source_next(&source, rows, 1 + size % 64, &count, &err) == OST_OK);
            ost_text_fingerprint_add(&again, rows, count);
        }
        fuzz_require(again.rows == summary.fingerprint.rows && again.hash == summary.fingerprint.hash);
    }
    fuzz_require_error(status, err, path);
    ost_text_summary_free(&summary);
    ost_text_source_close(&source);
    return 0;
}

const char *const fuzz_words[] = {"# osteon spacing_mm: 1 1 1\n",
                                  "# osteon dims: 2 2 2\n",
                                  "# osteon origin_mm: 0 0 0\n",
                                  "# osteon ",
                                  "spacing_mm: ",
                                  "nan",
                                  "inf",
                                  "1e999",
                                  "1e-999",
                                  "e",
                                  "-",
                                  "32768",
                                  "8000.0000000001",
                                  "0.0000000005",
                                  "99999999999999999999",
                                  "\n",
                                  "\r\n",
                                  ",",
                                  ";",
                                  "\t",
                                  "\xef\xbb\xbf",
                                  "x y z density\n",
                                  NULL};

static int put_row(char *to, size_t capacity, unsigned style, const double p[3], int density)
{
    switch (style) {
    case 0:
        return snprintf(to, capacity, "%g %g %g %d\n", p[0], p[1], p[2], density);
    case 1:
        return snprintf(to, capacity, "%.4f,%.4f,%.4f,%d\r\n", p[0], p[1], p[2], density);
    case 2:
        return snprintf(to, capacity, "%.2f;%.2f;%.2f;%d.0 # note\n", p[0], p[1], p[2], density);
    default:
        return snprintf(to, capacity, "%e\t%e\t%e\t%d\n", p[0], p[1], p[2], density);
    }
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const char *const heads[] = {"", "x,y,z,density\n", "\xef\xbb\xbf# osteon spacing_mm: 0.47 0.47 1\n",
                                        "# osteon dims: 4 3 3\n# osteon side: left\n"};
    if (index >= 4)
        return 0;
    char *text = (char *)bytes;
    size_t used = (size_t)snprintf(text, capacity, "%s", heads[index]);
    for (int v = 0; v < 36; v++) {
        const double position[3] = {v % 4 * 0.47 - 57.34, v / 4 % 3 * 0.47, v / 12};
        used += (size_t)put_row(text + used, capacity - used, index, position, v * 31 - 100);
    }
    return used;
}
