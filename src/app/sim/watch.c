/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/watch.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "app/common/progress.h"
#include "app/sim/recorder_watch.h"
#include "app/common/print.h"
#include "io/thread.h"

enum { PERIOD_NS = 100000000 };

struct sim_watch {
    const app_state *app;
    ost_recorder *recorder;
    const char *name;
    uint64_t capacity;
    double seconds;
    recorder_watch seen;
    pthread_t thread;
    _Atomic bool stop;
};

static void print_progress(sim_watch *w)
{
    char text[RECORDER_WATCH_TEXT];
    ost_recorder_state state;
    if (!w->recorder)
        return;
    ost_recorder_state_get(w->recorder, &state);
    const char *line = recorder_watch_update(&w->seen, w->name, &state, w->capacity, now_ms(), text);
    if (line)
        warn(w->app, "%s", line);
}

static void *work(void *user)
{
    sim_watch *w = user;
    const double begin = now_ms();
    const struct timespec pause = {.tv_nsec = PERIOD_NS};
    while (!atomic_load(&w->stop)) {
        nanosleep(&pause, NULL);
        print_progress(w);
        progress_show(NULL, "simulating", w->seconds > 0 ? (now_ms() - begin) * 1e-3 / w->seconds : 0);
    }
    print_progress(w);
    progress_end();
    return NULL;
}

ost_status sim_watch_begin(const app_state *app, ost_recorder *recorder, const char *name, uint64_t capacity,
                           double seconds, sim_watch **out, ost_error *err)
{
    sim_watch *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a run's monitor");
    w->app = app;
    w->recorder = recorder;
    w->name = name;
    w->capacity = capacity;
    w->seconds = seconds;
    const int error = ost_thread_begin(&w->thread, work, w);
    if (error) {
        free(w);
        return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for watching a run: %s", strerror(error));
    }
    *out = w;
    return OST_OK;
}

void sim_watch_end(sim_watch *watch)
{
    if (!watch)
        return;
    atomic_store(&watch->stop, true);
    pthread_join(watch->thread, NULL);
    free(watch);
}
