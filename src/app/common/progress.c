/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/progress.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "core/clock.h"
#include "core/printable.h"

/*
 * After other output, the progress line is not drawn for HOLD_MS milliseconds, so that an output of several lines is
 * not interrupted.
 */
enum { QUIET_MS = 1000, PERIOD_MS = 100, HOLD_MS = 300 };
/*
 * The remaining time is printed only after LEFT_MS milliseconds and at a completed share of at least LEFT_SHARE,
 * because earlier estimates vary too much.
 */
static const double LEFT_MS = 300, LEFT_SHARE = 0.001;

static struct {
    pthread_mutex_t lock; /* protects all members, and the progress line on the terminal */
    bool on, drawn;
    char stage[32];       /* name of the current stage; "" if no stage is running */
    double share;
    double begin, stage_begin, not_before; /* times in ms */
} line = {.lock = PTHREAD_MUTEX_INITIALIZER};

double now_ms(void)
{
    return (double)ost_clock_ns() * 1e-6;
}

static void erase(void)
{
    if (line.drawn)
        fputs("\r\033[K", stderr);
    line.drawn = false;
}

static void draw(double now)
{
    const double spent = now - line.stage_begin;
    if (!line.stage[0] || now - line.begin < QUIET_MS || now < line.not_before)
        return;
    if (line.share < LEFT_SHARE || line.share > 1)
        fprintf(stderr, "\r%s, %.0f s so far\033[K", line.stage, spent / 1000);
    else if (spent < LEFT_MS)
        fprintf(stderr, "\r%s %3.0f %%\033[K", line.stage, line.share * 100);
    else
        fprintf(stderr, "\r%s %3.0f %%, %.0f s left\033[K", line.stage, line.share * 100,
                spent / line.share * (1 - line.share) / 1000);
    fflush(stderr);
    line.drawn = true;
}

static void *draw_lines(void *unused)
{
    (void)unused;
    const struct timespec period = {.tv_nsec = PERIOD_MS * 1000000L};
    for (;;) {
        nanosleep(&period, NULL);
        pthread_mutex_lock(&line.lock);
        draw(now_ms());
        pthread_mutex_unlock(&line.lock);
    }
    return NULL;
}

/*
 * Starts the thread that draws the line. The thread blocks all signals, so that signals are delivered to the verb's
 * own threads.
 */
static bool start_thread(void)
{
    pthread_t thread;
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    const bool started = pthread_create(&thread, NULL, draw_lines, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (started)
        pthread_detach(thread);
    return started;
}

void progress_begin(const app_state *app)
{
    if (line.on || app->quiet || !isatty(STDERR_FILENO))
        return;
    line.begin = now_ms();
    line.on = start_thread();
}

bool progress_show(void *user, const char *stage, double share)
{
    (void)user;
    if (!line.on)
        return true;
    char name[sizeof line.stage];
    snprintf(name, sizeof name, "%s", stage);
    ost_make_printable(name);
    pthread_mutex_lock(&line.lock);
    if (strcmp(name, line.stage) != 0 || share < line.share) {
        memcpy(line.stage, name, sizeof name);
        line.stage_begin = now_ms();
    }
    line.share = share;
    pthread_mutex_unlock(&line.lock);
    return true;
}

void progress_clear(void)
{
    pthread_mutex_lock(&line.lock);
    erase();
    line.not_before = now_ms() + HOLD_MS;
    pthread_mutex_unlock(&line.lock);
}

void progress_end(void)
{
    pthread_mutex_lock(&line.lock);
    erase();
    line.stage[0] = '\0';
    line.share = 0;
    pthread_mutex_unlock(&line.lock);
}
