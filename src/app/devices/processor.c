/* SPDX-License-Identifier: Apache-2.0 */
#include "app/devices/devices.h"

#include <string.h>

#if defined __aarch64__ && defined __linux__
#include <sys/auxv.h>
#endif

#include "app/common/print.h"
#include "app/common/result.h"

void devices_list_instruction_sets(const app_state *app)
{
    json_t *array = json_array();
    char text[256] = "";
    const char *names[16];
    int count = 0;
#if defined __x86_64__
    __builtin_cpu_init();
#define OST_HAS(feature)                 \
    if (__builtin_cpu_supports(feature)) \
        names[count++] = feature;
    OST_HAS("sse2")
    OST_HAS("ssse3")
    OST_HAS("sse4.1")
    OST_HAS("avx2")
    OST_HAS("avx512f")
    OST_HAS("avx512bw")
    OST_HAS("avx512vl")
    OST_HAS("avx512vbmi")
#undef OST_HAS
#elif defined __aarch64__
    names[count++] = "neon";
#if defined __linux__ && defined HWCAP_SVE
    if (getauxval(AT_HWCAP) & HWCAP_SVE)
        names[count++] = "sve";
#endif
#endif
    for (int i = 0; i < count; i++) {
        append(array, json_string(names[i]));
        strcat(text, i ? ", " : "");
        strcat(text, names[i]);
    }
    put(app->result, "instruction_sets", array);
    print_line(app, "%s", "");
    print_line(app, "instruction sets of this processor");
    print_line(app, "  %s", count ? text : "none that osteon uses");
}
