/* SPDX-License-Identifier: Apache-2.0 */
#include "app/film/film.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/film/file.h"
#include "app/common/options.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "io/outfile.h"
#include "io/thread.h"
#include "render/png.h"
#include "render/points/frame.h"

enum { QUEUE_CAPACITY = 12, STILLS = 100000 };

typedef struct job {
    bool still;
    int64_t index; /* number of the frame in the video, from 0 */
    int width, height;
    uint32_t *pixels; /* owned */
    size_t capacity;
} job;

struct film {
    film_options options;
    film_file *file; /* NULL if no video is written */
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t more, capacity;
    job job[QUEUE_CAPACITY]; /* ring buffer */
    int first, count;
    bool end;
    /* time of the first frame, and index of the latest frame that a caller passed */
    int64_t begin_ns, last;
    bool begun;
    uint64_t dropped;
    bool news;
    char text[FILM_TEXT];
    ost_status status;
    ost_error err;
    /* The following members are used only on the writer thread. */
    int stills;
    film_report report;
};

/* ----------------------------------------------------------------- writer */

static void set_message(film *f, const char *text)
{
    pthread_mutex_lock(&f->lock);
    snprintf(f->text, sizeof f->text, "%.*s", FILM_TEXT - 1, text);
    f->news = true;
    pthread_mutex_unlock(&f->lock);
}

static ost_status encode(const job *j, int effort, uint8_t **bytes, size_t *size, ost_error *err)
{
    ost_picture picture;
    ost_status status = ost_picture_init(&picture, j->width, j->height, err);
    if (status != OST_OK)
        return status;
    ost_colours_copy(j->pixels, j->width, &picture);
    status = ost_png_encode(&picture, effort, bytes, size, err);
    ost_picture_free(&picture);
    return status;
}

static void write_still(film *f, const job *j)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    ost_error err = {0};
    char name[64] = "", text[FILM_TEXT];
    bool taken = true;
    ost_status status = encode(j, OST_PNG_SMALL, &bytes, &size, &err);
    if (status == OST_OK)
        do {
            snprintf(name, sizeof name, "osteon-%03d.png", ++f->stills);
            status = ost_outfile_put_new(name, bytes, size, &taken, &err);
        } while (taken && f->stills < STILLS);
    snprintf(text, sizeof text, status != OST_OK ? "no picture: %.150s" : "saved: %.150s",
             status != OST_OK ? err.text : name);
    set_message(f, text);
    free(bytes);
}

/*
 * Repeats the previous frame until the video has `index` frames. The repeated frames fill the time for which no frame
 * was passed.
 */
static ost_status repeat_until(film *f, int64_t index, ost_error *err)
{
    ost_status status = OST_OK;
    while (status == OST_OK && f->report.frames > 0 && (int64_t)f->report.frames < index) {
        status = film_file_again(f->file, err);
        f->report.frames++;
        f->report.repeated++;
    }
    return status;
}

static ost_status write_frame(film *f, const job *j, ost_error *err)
{
    ost_status status = repeat_until(f, j->index, err);
    if (status == OST_OK)
        status = film_file_frame(f->file, j->pixels, j->width, j->height, err);
    if (f->report.frames == 0) {
        f->report.width = j->width;
        f->report.height = j->height;
    }
    f->report.frames += status == OST_OK;
    return status;
}

static void *work(void *user)
{
    film *f = user;
    pthread_mutex_lock(&f->lock);
    for (;;) {
        while (!f->count && !f->end)
            pthread_cond_wait(&f->more, &f->lock);
        if (!f->count)
            break;
        job *j = &f->job[f->first];
        const bool works = f->status == OST_OK;
        ost_error err = {0};
        ost_status status = OST_OK;
        pthread_mutex_unlock(&f->lock);
        if (j->still)
            write_still(f, j);
        else if (works && (status = write_frame(f, j, &err)) != OST_OK)
            set_message(f, err.text);
        pthread_mutex_lock(&f->lock);
        if (status != OST_OK) {
            f->status = status;
            f->err = err;
        }
        f->first = (f->first + 1) % QUEUE_CAPACITY;
        f->count--;
        pthread_cond_signal(&f->capacity);
    }
    pthread_mutex_unlock(&f->lock);
    return NULL;
}

/* ------------------------------------------------------------------- open */

ost_status film_check(const app_state *app, const film_options *options, ost_error *err)
{
    if (options->target && options->pipe)
        return usage_error(app, err, "--video %s and --video-pipe cannot be combined", options->target);
    return OST_OK;
}

ost_status film_open(const film_options *options, film **out, ost_error *err)
{
    *out = NULL;
    film *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a video");
    f->options = *options;
    if (options->target || options->pipe) {
        const ost_status status = film_file_open(options->target, options->pipe, (int)options->fps, &f->file, err);
        if (status != OST_OK) {
            free(f);
            return status;
        }
    }
    pthread_mutex_init(&f->lock, NULL);
    pthread_cond_init(&f->more, NULL);
    pthread_cond_init(&f->capacity, NULL);
    const int error = ost_thread_begin(&f->thread, work, f);
    if (error) {
        film_file_close(f->file, NULL);
        free(f);
        return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for pictures: %s", strerror(error));
    }
    *out = f;
    return OST_OK;
}

/* ----------------------------------------------------------------- frames */

/* Queues a copy of the frame. Returns false if the queue is full or memory is exhausted. */
static bool queue(film *f, bool still, int64_t index, const uint32_t *pixels, int stride, int width, int height)
{
    pthread_mutex_lock(&f->lock);
    while (f->count == QUEUE_CAPACITY && f->options.wait)
        pthread_cond_wait(&f->capacity, &f->lock);
    const bool capacity = f->count < QUEUE_CAPACITY;
    job *j = &f->job[(f->first + f->count) % QUEUE_CAPACITY];
    pthread_mutex_unlock(&f->lock);
    if (!capacity)
        return false;
    /* The writer thread reads only queued jobs. This job is not yet queued, so it is filled without the lock. */
    const size_t size = (size_t)width * (size_t)height;
    if (size > j->capacity) {
        free(j->pixels);
        j->pixels = malloc(size * sizeof *j->pixels);
        j->capacity = j->pixels ? size : 0;
        if (!j->pixels)
            return false;
    }
    for (int y = 0; y < height; y++)
        memcpy(j->pixels + (size_t)y * (size_t)width, pixels + (size_t)y * (size_t)stride,
               (size_t)width * sizeof *pixels);
    j->still = still;
    j->index = index;
    j->width = width;
    j->height = height;
    pthread_mutex_lock(&f->lock);
    f->count++;
    pthread_cond_signal(&f->more);
    pthread_mutex_unlock(&f->lock);
    return true;
}

static int64_t index_at(const film *f, int64_t t_ns)
{
    return f->begun ? (int64_t)((double)(t_ns - f->begin_ns) * 1e-9 * (double)f->options.fps + 1e-6) : 0;
}

bool film_is_due(const film *f, int64_t t_ns)
{
    return f->file && (!f->begun || index_at(f, t_ns) > f->last);
}

void film_frame(film *f, int64_t t_ns, const uint32_t *pixels, int stride, int width, int height)
{
    if (!film_is_due(f, t_ns))
        return;
    const int64_t index = index_at(f, t_ns);
    if (!queue(f, false, index, pixels, stride, width, height)) {
        pthread_mutex_lock(&f->lock);
        f->dropped++;
        pthread_mutex_unlock(&f->lock);
        if (!f->begun)
            return;
    }
    if (!f->begun)
        f->begin_ns = t_ns;
    f->begun = true;
    f->last = index;
}

void film_still(film *f, const uint32_t *pixels, int stride, int width, int height)
{
    if (!queue(f, true, 0, pixels, stride, width, height))
        set_message(f, "no picture: those before are still being written");
}

const char *film_message(film *f, char text[FILM_TEXT])
{
    pthread_mutex_lock(&f->lock);
    const bool news = f->news;
    if (news)
        memcpy(text, f->text, FILM_TEXT);
    f->news = false;
    pthread_mutex_unlock(&f->lock);
    return news ? text : NULL;
}

uint64_t film_dropped(film *f)
{
    pthread_mutex_lock(&f->lock);
    const uint64_t dropped = f->dropped;
    pthread_mutex_unlock(&f->lock);
    return dropped;
}

ost_status film_close(film *f, int64_t end_ns, film_report *report, ost_error *err)
{
    if (!f)
        return OST_OK;
    pthread_mutex_lock(&f->lock);
    f->end = true;
    pthread_cond_signal(&f->more);
    pthread_mutex_unlock(&f->lock);
    pthread_join(f->thread, NULL);
    ost_status status = f->status;
    if (status != OST_OK && err)
        *err = f->err;
    if (status == OST_OK && f->file && f->begun)
        status = repeat_until(f, index_at(f, end_ns), err);
    const ost_status closed = film_file_close(f->file, status == OST_OK ? err : NULL);
    status = status == OST_OK ? closed : status;
    f->report.dropped = f->dropped;
    if (report)
        *report = f->report;
    for (int i = 0; i < QUEUE_CAPACITY; i++)
        free(f->job[i].pixels);
    pthread_cond_destroy(&f->capacity);
    pthread_cond_destroy(&f->more);
    pthread_mutex_destroy(&f->lock);
    free(f);
    return status;
}

void film_print_report(const app_state *app, const film_options *options, const film_report *r)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    const char *to = options->target ? options->target : options->pipe;
    json_t *o = json_object();
    put_text(o, "to", to);
    put_integer(o, "frames", (int64_t)r->frames);
    put_integer(o, "repeated", (int64_t)r->repeated);
    put_integer(o, "dropped", (int64_t)r->dropped);
    put_integer(o, "fps", options->fps);
    put_integer(o, "width", r->width);
    put_integer(o, "height", r->height);
    put(app->result, "video", o);
    if (r->dropped)
        print_line(
            app, "  %s: %s frames of video, %.1f s; %s were left out, the disk or the encoder being too slow for them",
            to, format_count(a, (int64_t)r->frames), (double)r->frames / (double)options->fps,
            format_count(b, (int64_t)r->dropped));
    else
        print_line(app, "  %s: %s frames of video, %.1f s", to, format_count(a, (int64_t)r->frames),
                   (double)r->frames / (double)options->fps);
}
