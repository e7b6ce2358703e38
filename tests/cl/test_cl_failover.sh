#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests osteon ream --backend cl on a device that fails during the run. The output file must equal
# that of the backend cpu, one line must report the failure, and --no-failover must stop the run. A
# library that is preloaded before the OpenCL loader injects the failure.
# Covers: REQ-FAILOVER
. "${srcdir:-.}/tests/app/lib.sh"

skip() {
    echo "skipped: $*"
    exit 77
}
grep -q '^#define HAVE_OPENCL 1' "$build/config.h" || skip "built without OpenCL"
[ -z "${OST_SAN_CFLAGS:-}" ] || skip "the run-time library of a sanitizer must be loaded first"
mkdir -p "$build/tests/cl/cache"
export XDG_CACHE_HOME="$build/tests/cl/cache"

# After FAIL_AT launches, every launch and every read and write of a buffer fails. If FAIL_AT is not set, the launches
# are only counted.
cat >failing.c <<'END'
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

static long launches;

static int lost(void)
{
    const char *at = getenv("FAIL_AT");
    return at && launches > atol(at);
}

__attribute__((destructor)) static void report(void)
{
    FILE *file = fopen(getenv("LAUNCHES"), "w");
    if (file) {
        fprintf(file, "%ld\n", launches);
        fclose(file);
    }
}

#define QUEUE(name, parameters, arguments)                               \
    cl_int name parameters                                               \
    {                                                                    \
        cl_int (*next) parameters;                                       \
        *(void **)&next = dlsym(RTLD_NEXT, #name);                       \
        return lost() ? CL_OUT_OF_RESOURCES : next arguments;            \
    }

cl_int clEnqueueNDRangeKernel(cl_command_queue q, cl_kernel k, cl_uint n, const size_t *o, const size_t *g, const size_t *l, cl_uint c,
                              const cl_event *w, cl_event *e)
{
    cl_int (*next)(cl_command_queue, cl_kernel, cl_uint, const size_t *, const size_t *, const size_t *, cl_uint, const cl_event *, cl_event *);
    *(void **)&next = dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel");
    launches++;
    return lost() ? CL_OUT_OF_RESOURCES : next(q, k, n, o, g, l, c, w, e);
}
QUEUE(clEnqueueReadBuffer,
      (cl_command_queue q, cl_mem b, cl_bool s, size_t o, size_t n, void *p, cl_uint c, const cl_event *w, cl_event *e),
      (q, b, s, o, n, p, c, w, e))
QUEUE(clEnqueueWriteBuffer,
      (cl_command_queue q, cl_mem b, cl_bool s, size_t o, size_t n, const void *p, cl_uint c, const cl_event *w, cl_event *e),
      (q, b, s, o, n, p, c, w, e))
END
${CC:-cc} -shared -fPIC -o failing.so failing.c -ldl 2>cc.log || skip "cannot build the failing library: $(head -n 1 cc.log)"
export LAUNCHES="$scratch/launches"

run 0 phantom glenoid --out ct.txt
run 0 import ct.txt --out bone.nrrd
run 0 tool reamer --out reamer.stl
run 0 voxelize reamer.stl --voxel 0.5 --out reamer.nrrd
ream="ream --bone bone.nrrd --tool reamer.nrrd --path builtin:glenoid-ream --rate 100"
"$osteon" $ream --out cl.nrrd --backend cl >out 2>err || skip "$(cat err)"

run 0 $ream --out cpu.nrrd
checks=$((checks + 1))
cmp cpu.nrrd cl.nrrd || fail "the output of backend cl differs from that of backend cpu"

export LD_PRELOAD="$scratch/failing.so"
run 0 $ream --out counted.nrrd --backend cl
many=$(cat launches)
echo "# $many launches"
[ "$many" -gt 100 ] || fail "only $many kernels were launched; more than 100 are needed"

# The device fails after 20 % of the launches, and in another run after 97 %.
for percent in 20 97; do
    FAIL_AT=$((many * percent / 100))
    export FAIL_AT
    run 0 $ream --out failing.nrrd --backend cl --json
    checks=$((checks + 1))
    cmp cpu.nrrd failing.nrrd || fail "the output differs if launch $FAIL_AT fails"
    has failover.ticks failover.reason
    echo "# launch $FAIL_AT of $many failed after $(value failover.ticks) complete ticks"
    check "lines on standard error" "$(wc -l <err | tr -d ' ')" 1
    checks=$((checks + 1))
    grep -q 'failover to backend cpu' err || fail "standard error does not report the failover: '$(cat err)'"
    run 2 $ream --out stopped.nrrd --backend cl --no-failover
    check "lines on standard error" "$(wc -l <err | tr -d ' ')" 1
    [ ! -e stopped.nrrd ] || fail "the stopped run wrote an output file"
done
finish
