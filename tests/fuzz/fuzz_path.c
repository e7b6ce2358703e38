/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes, compressed or not, as paths and tracked motions. The result must have
 * increasing times and unit quaternions, or be an error of one line that names the file.
 */
#include "fuzz.h"

#include <osteon/io.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *file = fuzz_file("path.csv", data, size);
    ost_error err = {0};
    ost_path path;
    ost_path_report report;
    const ost_path_options options[] = {{0}, {OST_PATH_NO_GAPS, OST_PATH_NO_GAPS}, {1000000, OST_PM_PER_MM}};
    ost_status status = ost_path_read(file, &options[size % 3], &path, &report, &err);
    fuzz_require_error(status, err, file);
    if (status != OST_OK) {
        fuzz_require(path.ticks == NULL);
        return 0;
    }
    fuzz_require(path.count > 0 && !path.ticks[0].lifted && report.rows == path.count + report.lost_rows &&
                 report.gaps < path.count);
    fuzz_require(report.begin_ns <= path.ticks[0].t_ns && report.end_ns >= path.ticks[path.count - 1].t_ns);
    for (size_t i = 0; i < path.count; i++) {
        fuzz_require(i == 0 || path.ticks[i].t_ns > path.ticks[i - 1].t_ns);
        fuzz_require(path.ticks[i].tool >= 0);
        fuzz_require(ost_pose_check(&path.ticks[i].pose, NULL) == OST_OK);
    }
    ost_path_free(&path);
    return 0;
}

const char *const fuzz_words[] = {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz",
                                  "t_s,x_m,y_m,z_m,qw,qx,qy,qz",
                                  ",tool",
                                  ",lifted",
                                  ",movement",
                                  "nan",
                                  "NaN",
                                  "\x1f\x8b\x08",
                                  "-inf",
                                  "1e999",
                                  "1e-999",
                                  "9223372036.854775807",
                                  "8000",
                                  "0.70710678",
                                  "-0",
                                  ",,",
                                  ",",
                                  "\n",
                                  "\r\n",
                                  "#",
                                  "\xef\xbb\xbf",
                                  "2147483648",
                                  NULL};

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index >= 3)
        return 0;
    char *text = (char *)bytes;
    size_t used = (size_t)snprintf(text, capacity, index == 2   ? "t_s,x_m,y_m,z_m,qw,qx,qy,qz,movement,lifted\n"
                                                     : index == 1 ? "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool\n"
                                                                  : "# a path\n");
    for (int i = 0; i < 20; i++)
        used += (size_t)snprintf(text + used, capacity - used, "%d.%03d,%s,-0.34,%de-1,0.6,0,-0.8,0%s\n", i / 10,
                                 i % 10 * 100, i % 7 == 3 ? "nan" : "0.5", i,
                                 index == 2 ? ",a,1"
                                 : index    ? ",1"
                                            : "");
    return used;
}
