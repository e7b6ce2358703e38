/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/clock.h"
#include "core/printable.h"

static struct {
    bool on, drawn;
    char stage[32];
    double stage_start, last_draw;
} line;

double now_ms(void)
{
    return (double)ost_clock_ns() * 1e-6;
}

void progress_begin(const app_state *app)
{
    line.on = !app->quiet && isatty(STDERR_FILENO);
    line.stage[0] = '\0';
}

void progress_clear(void)
{
    if (line.drawn)
        fputs("\r\033[K", stderr);
    line.drawn = false;
}

bool progress_show(void *user, const char *stage, double share)
{
    (void)user;
    if (!line.on)
        return true;
    double now = now_ms();
    if (strncmp(stage, line.stage, sizeof line.stage - 1) != 0) {
        snprintf(line.stage, sizeof line.stage, "%s", stage);
        ost_make_printable(line.stage);
        line.stage_start = line.last_draw = now;
        return true;
    }
    double spent = now - line.stage_start;
    if (spent < 1000 || now - line.last_draw < 100)
        return true;
    line.last_draw = now;
    if (share > 0.001 && share <= 1) {
        double left = spent / share * (1 - share) / 1000;
        fprintf(stderr, "\r%s %3.0f %%, %.0f s left\033[K", line.stage, share * 100, left);
    } else {
        fprintf(stderr, "\r%s, %.0f s so far\033[K", line.stage, spent / 1000);
    }
    fflush(stderr);
    line.drawn = true;
    return true;
}
