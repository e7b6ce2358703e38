/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/show.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "app/common/backend_choice.h"
#include "app/common/interrupt.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/picture/tool.h"
#include "app/sim/appearance.h"
#include "core/clock.h"
#include "io/thread.h"

enum { THREADS_MAX = 4 };

typedef struct drawer {
    pthread_t thread;
    _Atomic bool stop;
} drawer;

/* Returns the number of processors on which this thread may run. */
static int cores_here(void)
{
    cpu_set_t set;
    const int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return count < THREADS_MAX ? count : THREADS_MAX;
}

static ost_status add_tools(sim_show *show, const simulation *s, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < show->args->tools.count && status == OST_OK; i++)
        status = picture_add_tool(&show->viewer, s->tools[i], show->args->tools.value[i], &show->args->how, err);
    return status;
}

/* Opens a second instance of the backend that --backend selects, because the servo loop uses the first instance at the
   same time. */
static ost_status use_mesh(sim_show *show, ost_error *err)
{
    ost_status status = backend_choose(show->app, &show->mesher, err);
    return status == OST_OK ? ost_viewer_use_mesh(&show->viewer, show->mesher, err) : status;
}

/* Replaces SIM_RENDERER_AUTO with the renderer to use. If the CPU draws, prints the reason. */
static void use_card(sim_show *show)
{
    ost_viewer_use_card(&show->viewer);
    show->renderer = show->viewer.gl ? SIM_RENDERER_GL : SIM_RENDERER_POINTS;
    if (*show->viewer.no_card)
        print_line(show->app, "renderer: points, drawn by the processor: %s", show->viewer.no_card);
}

ost_status sim_show_make(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    ost_glenoid glenoid;
    if (args->renderer == SIM_RENDERER_NONE)
        return OST_OK;
    sim_show *show = calloc(1, sizeof *show);
    if (!show)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a renderer");
    s->show = show;
    show->app = app;
    show->args = args;
    show->on_device = strcmp(ost_backend_name(s->backend), "cl") == 0;
    ost_status status = ost_live_create(s->bone, &show->live, err);
    if (status != OST_OK)
        return status;
    const ost_geometry *g = ost_live_geometry(show->live);
    status = ost_viewer_init(&show->viewer, g, args->style ? OST_STYLE_FACES : OST_STYLE_SMOOTH, NULL, cores_here(),
                             err);
    show->renderer = args->renderer;
    if (status == OST_OK && args->renderer != SIM_RENDERER_POINTS && s->window_can_be_drawn)
        ost_viewer_use_current(&show->viewer, NULL); /* after a failure, OpenGL is opened with a separate context */
    if (status == OST_OK && args->renderer == SIM_RENDERER_AUTO)
        use_card(show);
    else if (status == OST_OK && args->renderer == SIM_RENDERER_MESH)
        status = use_mesh(show, err);
    else if (status == OST_OK && args->renderer >= SIM_RENDERER_GL)
        status = ost_viewer_use_gl(&show->viewer, args->renderer == SIM_RENDERER_GL ? &ost_gl_ours : &ost_gl_thesis,
                                   err);
    if (status == OST_OK)
        status = add_tools(show, s, err);
    if (status != OST_OK)
        return status;
    ost_viewer_follow(&show->viewer, show->live);
    const bool known = target_find(app, &args->plan.target, &s->imported.meta, args->bone, &glenoid, NULL) == OST_OK;
    show->subject = ost_view_subject_make(g, &glenoid.at, known ? glenoid.axis : NULL, known && glenoid.left);
    show->orbit = ost_view_orbit((ost_view_name)args->view, &show->subject, NULL);
    status = sim_scene_make(&show->scene, &args->tools, s->tools, g, s->planned ? &s->plan : NULL, err);
    if (status != OST_OK)
        return status;
    sim_scene_forces(&show->scene, args->safety.max_force_n, args->force_params.scale);
    show->scene.device = args->device;
    show->scene.force_given = s->force != NULL;
    show->scene.recording = s->recorder != NULL;
    status = sim_appearance_make(args, s, known ? &glenoid : NULL, err);
    /* The first update builds the lists of the bone's surface voxels and the appearance of each voxel before the
     * servo loop runs. */
    return status == OST_OK ? ost_viewer_update(&show->viewer, err) : status;
}

void sim_show_free(sim_show *show)
{
    if (!show)
        return;
    sim_hud_free(show->hud);
    sim_appearance_free(show);
    ost_viewer_free(&show->viewer);
    ost_backend_close(show->mesher);
    ost_live_free(show->live);
    free(show);
}

ost_status sim_show_update(sim_show *show, ost_error *err)
{
    show->updated_ns = ost_clock_ns();
    return ost_viewer_update(&show->viewer, err);
}

static ost_status draw(sim_show *show, const ost_camera *camera, const ost_gl_sheet *sheet, ost_error *err)
{
    ost_status status = OST_ERR_UNAVAILABLE;
    if (sheet)
        status = ost_viewer_show(&show->viewer, camera, sheet, err);
    show->on_screen = status == OST_OK;
    show->shown += show->on_screen;
    return status == OST_OK || status == OST_ERR_RANGE ? status : ost_viewer_draw(&show->viewer, camera, err);
}

ost_status sim_show_frame(sim_show *show, int width, int height, const ost_gl_sheet *sheet, ost_error *err)
{
    ost_camera camera;
    ost_status status;
    show->on_screen = false;
    if (show->last_ns)
        frame_times_add(&show->apart, show->updated_ns - show->last_ns);
    show->last_ns = show->updated_ns;
    status = ost_orbit_camera(&show->orbit, width, height, &camera, err);
    if (status == OST_OK)
        status = draw(show, &camera, sheet, err);
    show->width = width;
    show->height = height;
    if (status == OST_OK && show->args->headless && !show->args->hud && !show->args->look.no_legend)
        status = appearance_marks(&show->look, NULL, false, err);
    return status;
}

void sim_show_done(sim_show *show)
{
    if (show->last_ns)
        frame_times_add(&show->drawn, ost_clock_ns() - show->updated_ns);
}

/* ----------------------------------------------------------- without a window */

/* Draws the HUD into a frame in memory, if there is no window. */
static ost_status write_over(sim_show *show, ost_error *err)
{
    const ost_sheet sheet = ost_frame_sheet(&show->viewer.frame);
    double back[3];
    ost_status status = show->hud ? OST_OK : sim_hud_create(sheet.width, sheet.height, 1, &show->hud, err);
    if (status != OST_OK)
        return status;
    sim_hud_facts f = sim_facts_make(&show->scene, &show->viewer.state, show->viewer.has_state);
    f.plain = true;
    f.timings = show->args->timings;
    if (!show->args->look.no_legend)
        f.legend = appearance_legend_of(&show->look);
    f.mm_per_pixel = show->orbit.distance / (OST_VIEW_FOCAL * sheet.height);
    ost_orbit_frame(&show->orbit, f.right, f.up, back);
    sim_hud_draw(show->hud, &sheet, &f);
    return OST_OK;
}

static ost_status frame_of_thread(sim_show *show, ost_error *err)
{
    const ost_planes *p = &show->viewer.frame.planes;
    ost_status status = sim_show_update(show, err);
    if (status == OST_OK)
        status = sim_show_frame(show, show->args->width, show->args->height, NULL, err);
    if (status == OST_OK && show->args->hud)
        status = write_over(show, err);
    if (status == OST_OK && show->film)
        film_frame(show->film, ost_clock_ns(), p->colour, p->stride, show->args->width, show->args->height);
    sim_show_done(show);
    return status;
}

static ost_status write_picture(const sim_show *show, ost_error *err)
{
    ost_picture picture;
    const ost_frame *f = &show->viewer.frame;
    ost_status status = ost_picture_init(&picture, f->width, f->height, err);
    if (status != OST_OK)
        return status;
    ost_frame_copy(f, &picture);
    status = ost_picture_write_png(show->args->picture, &picture, err);
    ost_picture_free(&picture);
    return status;
}

static void *work(void *user)
{
    sim_show *show = user;
    drawer *d = show->thread;
    const int64_t period = show->args->fps > 0 ? INT64_C(1000000000) / show->args->fps : 0;
    int64_t due = ost_clock_ns();
    while (!atomic_load(&d->stop) && show->status == OST_OK) {
        show->status = frame_of_thread(show, &show->err);
        const int64_t now = ost_clock_ns();
        due = due + period > now ? due + period : now; /* after a late frame, the following frames are due later too */
        const struct timespec t = {.tv_sec = due / 1000000000, .tv_nsec = due % 1000000000};
        if (due > now)
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
    }
    return NULL;
}

ost_status sim_show_begin(sim_show *show, ost_error *err)
{
    drawer *d = calloc(1, sizeof *d);
    if (!d)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a renderer's thread");
    show->thread = d;
    const int error = ost_thread_begin(&d->thread, work, show);
    if (!error)
        return OST_OK;
    free(d);
    show->thread = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for a renderer: %s", strerror(error));
}

ost_status sim_show_end(sim_show *show, ost_error *err)
{
    drawer *d = show->thread;
    if (!show->end_ns)
        show->end_ns = ost_clock_ns();
    if (d) {
        atomic_store(&d->stop, true);
        pthread_join(d->thread, NULL);
        free(d);
        show->thread = NULL;
    }
    if (show->status != OST_OK)
        return ost_fail(err, show->status, "the renderer: %.500s", show->err.text);
    ost_status status = ost_live_flush(show->live, err);
    if (status == OST_OK && show->args->picture) {
        status = sim_show_update(show, err);
        if (status == OST_OK)
            status = sim_show_frame(show, show->args->width, show->args->height, NULL, err);
        if (status == OST_OK && show->args->hud)
            status = write_over(show, err);
        if (status == OST_OK)
            status = write_picture(show, err);
    }
    return status;
}

/*
 * Reports the chunks that were copied from OpenCL to OpenGL through the processor's memory. OpenCL and OpenGL share no
 * voxels, because the processor computes the surface points from the voxels (docs/design/rendering.md).
 */
static void print_copied(const app_state *app, const sim_show *show, json_t *row)
{
    const int64_t side = ost_live_chunk_size(show->live);
    const int64_t bytes = (int64_t)show->viewer.changed * side * side * side / 8;
    char a[FORMAT_TEXT];
    put_integer(row, "copied_bytes", bytes);
    if (show->args->stats)
        print_line(app, "  voxels copied from OpenCL to OpenGL through the processor's memory: %s chunks, %.1f MB",
                   format_count(a, (int64_t)show->viewer.changed), (double)bytes * 1e-6);
}

/* Reports the OpenGL driver if OpenGL was used. */
static void print_gl(const app_state *app, const sim_show *show, json_t *row)
{
    char a[FORMAT_TEXT];
    if (show->viewer.gl) {
        const ost_gl_info info = ost_gl_info_get(show->viewer.gl);
        put_text(row, "opengl", info.version);
        put_text(row, "driver", info.driver);
        put_integer(row, "shown_directly", (int64_t)show->shown);
        if (show->args->stats)
            print_line(app, "  renderer: OpenGL %s, %s%s", info.version, info.driver,
                       info.software ? " (software; --renderer points is faster)" : "");
        if (show->args->stats && show->shown)
            print_line(app, "  frames drawn directly into the window, without reading them back: %s",
                       format_count(a, (int64_t)show->shown));
        if (show->on_device)
            print_copied(app, show, row);
    } else if (*show->viewer.lost) {
        put_text(row, "lost", show->viewer.lost);
        print_line(app, "  renderer: OpenGL failed, so the processor drew the remaining frames: %s", show->viewer.lost);
    }
}

void sim_show_report(const app_state *app, const sim_show *show)
{
    const frame_times *drawn = &show->drawn, *apart = &show->apart;
    const double p50 = frame_times_ms(apart, 0.5), worst = frame_times_ms(apart, 0.99);
    const double work50 = frame_times_ms(drawn, 0.5), work99 = frame_times_ms(drawn, 0.99);
    json_t *o = json_object();
    char a[FORMAT_TEXT];
    put_text(o, "name", sim_renderer_names[show->renderer]);
    if (*show->viewer.no_card)
        put_text(o, "no_card", show->viewer.no_card);
    put_integer(o, "frames", (int64_t)drawn->count);
    if (!show->args->headset) { /* the headset determines the size of its frames */
        put_integer(o, "width", show->width);
        put_integer(o, "height", show->height);
    }
    put_real(o, "fps", p50 > 0 ? 1000 / p50 : 0);
    put_real(o, "fps_worst_1_percent", worst > 0 ? 1000 / worst : 0);
    put(o, "frame_ms", json_pack("{s:f,s:f,s:f}", "p50", work50, "p99", work99, "max", (double)drawn->max_ns * 1e-6));
    put_integer(o, "changed_chunks", (int64_t)show->viewer.changed);
    put_integer(o, "surface_voxels", (int64_t)show->viewer.bone.points);
    put(app->result, "renderer", o);
    print_gl(app, show, o);
    if (apart->count && show->args->stats)
        print_line(app,
                   "  frames: %s; rate %.0f per second at the median, %.0f in the slowest 1 %%; %.1f ms per frame, "
                   "%.1f ms at 99 %%",
                   format_count(a, (int64_t)drawn->count), 1000 / p50, 1000 / worst, work50, work99);
    if (show->args->picture)
        print_line(app, "  last frame: %s", show->args->picture);
}
