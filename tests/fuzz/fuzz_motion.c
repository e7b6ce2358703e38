/* SPDX-License-Identifier: Apache-2.0 */
/* Motions of tracked hands: whatever the bytes, packed or not, increasing times and unit quaternions, or one line that names the file. */
#include "fuzz.h"

#include <math.h>

#include "io/motion_csv.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *file = fuzz_file("motion.csv", data, size);
    ost_error err = {0};
    motion m;
    ost_status status = motion_read_csv(file, &m, &err);
    fuzz_require_error(status, err, file);
    if (status != OST_OK) {
        fuzz_require(m.rows == NULL);
        return 0;
    }
    size_t seen = 0;
    for (size_t i = 0; i < m.count; i++) {
        const motion_row *r = &m.rows[i];
        fuzz_require(i == 0 || r->t_ns > m.rows[i - 1].t_ns);
        if (!motion_seen(r))
            continue;
        seen++;
        fuzz_require(fabs(r->q[0] * r->q[0] + r->q[1] * r->q[1] + r->q[2] * r->q[2] + r->q[3] * r->q[3] - 1) < 1e-9);
        for (int a = 0; a < 3; a++)
            fuzz_require(fabs(r->at[a]) <= 100);
    }
    fuzz_require(seen > 0);
    motion_free(&m);
    return 0;
}

const char *const fuzz_words[] = {"t_s,x_m,y_m,z_m,qw,qx,qy,qz", ",movement", "nan", "NaN", "-inf", "1e999", "1e-999", "86400.1", "101", "0.70710678",
                                  "-0", ",,", ",", "\n", "\r\n", "#", "\xef\xbb\xbf", "\x1f\x8b\x08", NULL};

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t room)
{
    if (index >= 2)
        return 0;
    char *text = (char *)bytes;
    size_t used = (size_t)snprintf(text, room, index ? "t_s,x_m,y_m,z_m,qw,qx,qy,qz,movement\n" : "# a hand\n");
    for (int i = 0; i < 20; i++)
        used += (size_t)snprintf(text + used, room - used, "%.4f,%d.5,-0.34,%de-1,%s0,-0.8,0%s\n", i * 0.0035, i % 9, i, i % 7 == 3 ? "nan," : "0.6,",
                                 index ? ",1" : "");
    return used;
}
