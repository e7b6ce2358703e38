/* SPDX-License-Identifier: Apache-2.0 */
#include "window/shm.h"

#include <dlfcn.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ipc.h>
#include <sys/shm.h>

#include "window/changed.h"
#include "window/x11.h"

/* constants of the binary interfaces of libX11 and libxcb */

enum { Z_PIXMAP = 2, TRUE_COLOR = 4, VISUAL_ID_MASK = 1 };

typedef struct xcb_cookie {
    unsigned sequence;
} xcb_cookie;

/* Must have the layout of XVisualInfo. */
typedef struct visual_info {
    void *visual;
    unsigned long id;
    int screen, depth, class;
    unsigned long red, green, blue;
    int colormap_size, bits_per_rgb;
} visual_info;

/* Must have the layout of the first fields of xcb_get_window_attributes_reply_t. */
typedef struct attributes {
    uint8_t type, backing_store;
    uint16_t sequence;
    uint32_t length, visual;
} attributes;

typedef struct calls {
    void *(*glfw_display)(void);
    unsigned long (*glfw_window)(void *);
    void *(*connection)(void *);
    visual_info *(*visuals)(void *, long, visual_info *, int *);
    int (*x_free)(void *);
    uint32_t (*id)(void *);
    int (*has_error)(void *);
    int (*flush)(void *);
    void *(*check)(void *, xcb_cookie);
    xcb_cookie (*get_attributes)(void *, uint32_t);
    attributes *(*attributes_reply)(void *, xcb_cookie, void **);
    xcb_cookie (*create_gc)(void *, uint32_t, uint32_t, uint32_t, const void *);
    xcb_cookie (*free_gc)(void *, uint32_t);
    xcb_cookie (*attach)(void *, uint32_t, uint32_t, uint8_t);
    xcb_cookie (*detach)(void *, uint32_t);
    xcb_cookie (*put)(void *, uint32_t, uint32_t, uint16_t, uint16_t, uint16_t, uint16_t, uint16_t, uint16_t, int16_t,
                      int16_t, uint8_t, uint8_t, uint8_t, uint32_t, uint32_t);
} calls;

/*
 * Finds a function by name. Returns false if the function or the library is missing. If the library is missing, its
 * handle is NULL, which equals RTLD_DEFAULT. dlsym then searches the program, which does not contain the function.
 */
static bool find(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

/* ------------------------------------------------------------------ shared */

struct ost_shm {
    calls x;
    void *library[4];
    void *display, *connection;
    uint32_t window, gc, segment;
    uint8_t depth;
    uint32_t *pixels; /* owned; pixels in memory that is shared with the server */
    size_t capacity;  /* number of pixels for which memory is reserved */
    /* size of the picture in shared memory and in the window; 0 if unknown */
    int width, height;
    bool pending;     /* true while the server copies the last picture */
    xcb_cookie copied;
};

static bool load(ost_shm *s)
{
    static const char *const names[] = {"libX11.so.6", "libX11-xcb.so.1", "libxcb.so.1", "libxcb-shm.so.0"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        s->library[i] = dlopen(names[i], RTLD_LAZY);
    calls *x = &s->x;
    void *x11 = s->library[0], *xcb = s->library[2], *shm = s->library[3];
    return find(RTLD_DEFAULT, "glfwGetX11Display", &x->glfw_display) &&
           find(RTLD_DEFAULT, "glfwGetX11Window", &x->glfw_window) && find(x11, "XGetVisualInfo", &x->visuals) &&
           find(x11, "XFree", &x->x_free) && find(s->library[1], "XGetXCBConnection", &x->connection) &&
           find(xcb, "xcb_generate_id", &x->id) && find(xcb, "xcb_connection_has_error", &x->has_error) &&
           find(xcb, "xcb_request_check", &x->check) && find(xcb, "xcb_flush", &x->flush) &&
           find(xcb, "xcb_get_window_attributes", &x->get_attributes) &&
           find(xcb, "xcb_get_window_attributes_reply", &x->attributes_reply) &&
           find(xcb, "xcb_create_gc_checked", &x->create_gc) && find(xcb, "xcb_free_gc", &x->free_gc) &&
           find(shm, "xcb_shm_attach_checked", &x->attach) && find(shm, "xcb_shm_detach", &x->detach) &&
           find(shm, "xcb_shm_put_image", &x->put);
}

/* Waits for a reply. Requests are processed in order, so all earlier requests are then complete. */
static attributes *wait_for(ost_shm *s, xcb_cookie pending)
{
    void *error = NULL;
    attributes *reply = s->x.attributes_reply(s->connection, pending, &error);
    free(error);
    return reply;
}

static bool went_well(ost_shm *s, xcb_cookie checked)
{
    void *error = s->x.check(s->connection, checked);
    free(error);
    return !error && !s->x.has_error(s->connection);
}

/*
 * Returns true if pixels have eight bits per colour in native byte order, with red in the highest of the three bytes.
 * Sets s->depth.
 */
static bool learn_pixels(ost_shm *s)
{
    const uint32_t one = 1;
    int count = 0;
    attributes *a = wait_for(s, s->x.get_attributes(s->connection, s->window));
    visual_info wanted = {.id = a ? a->visual : 0},
                *found = a ? s->x.visuals(s->display, VISUAL_ID_MASK, &wanted, &count) : NULL;
    const bool fine = found && count == 1 && found->class == TRUE_COLOR && (found->depth == 24 || found->depth == 32) &&
                      found->red == 0xff0000 && found->green == 0xff00 && found->blue == 0xff &&
                      *(const uint8_t *)&one == 1;
    s->depth = fine ? (uint8_t)found->depth : 0;
    if (found)
        s->x.x_free(found);
    free(a);
    return fine;
}

static void give_back(ost_shm *s)
{
    if (!s->pixels)
        return;
    if (!s->x.has_error(s->connection))
        s->x.detach(s->connection, s->segment);
    shmdt(s->pixels);
    s->pixels = NULL;
    s->capacity = 0;
    s->width = s->height = 0;
}

/*
 * Reserves memory for `count` pixels. The segment is marked for removal at once, so it is freed when its last user
 * detaches, even if this process is killed.
 */
static bool reserve_memory(ost_shm *s, size_t count)
{
    if (count <= s->capacity)
        return true;
    give_back(s);
    const int id = shmget(IPC_PRIVATE, count * sizeof *s->pixels, IPC_CREAT | 0600);
    if (id < 0)
        return false;
    void *at = shmat(id, NULL, 0);
    s->segment = s->x.id(s->connection);
    const bool attached = at != (void *)-1 && went_well(s, s->x.attach(s->connection, s->segment, (uint32_t)id, 1));
    shmctl(id, IPC_RMID, NULL);
    if (!attached) {
        if (at != (void *)-1)
            shmdt(at);
        return false;
    }
    s->pixels = at;
    s->capacity = count;
    return true;
}

ost_shm *ost_shm_open(void *glfw_window)
{
    ost_shm *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    if (load(s) && (s->display = s->x.glfw_display()) != NULL &&
        (s->connection = s->x.connection(s->display)) != NULL) {
        s->window = (uint32_t)s->x.glfw_window(glfw_window);
        if (learn_pixels(s) && reserve_memory(s, 1)) {
            s->gc = s->x.id(s->connection);
            if (went_well(s, s->x.create_gc(s->connection, s->gc, s->window, 0, NULL)))
                return s;
            s->gc = 0;
        }
    }
    ost_shm_close(s);
    return NULL;
}

void ost_shm_close(ost_shm *shm)
{
    if (!shm)
        return;
    if (shm->pending)
        free(wait_for(shm, shm->copied));
    give_back(shm);
    if (shm->gc && !shm->x.has_error(shm->connection))
        shm->x.free_gc(shm->connection, shm->gc);
    for (size_t i = 0; i < sizeof shm->library / sizeof *shm->library; i++)
        if (shm->library[i])
            dlclose(shm->library[i]);
    free(shm);
}

/* ------------------------------------------------------------------ picture */

static bool lost(const ost_shm *s)
{
    if (s->x.has_error(s->connection))
        ost_x11_lost(OST_X11_NO_SERVER);
    return false;
}

void ost_shm_forget(ost_shm *shm)
{
    if (shm)
        shm->width = shm->height = 0;
}

bool ost_shm_present(ost_shm *shm, const ost_window_picture *picture)
{
    const int width = picture->width, height = picture->height;
    ost_changed_box box[OST_CHANGED_BOXES];
    if (shm->pending) {
        attributes *a = wait_for(shm, shm->copied);
        shm->pending = false;
        if (!a) {
            lost(shm);
            /* no-op if the loss of the server has already been recorded */
            ost_x11_lost(OST_X11_NO_WINDOW);
            return false;
        }
        free(a);
    }
    if (!reserve_memory(shm, (size_t)width * (size_t)height))
        return lost(shm);
    const bool everything = width != shm->width || height != shm->height;
    const int count = ost_changed_copy(picture, everything, shm->pixels, box);
    shm->width = width;
    shm->height = height;
    if (count == 0)
        return true;
    for (int i = 0; i < count; i++) {
        const uint16_t x = (uint16_t)box[i].x, y = (uint16_t)box[i].y, w = (uint16_t)box[i].width,
                       h = (uint16_t)box[i].height;
        shm->x.put(shm->connection, shm->window, shm->gc, (uint16_t)width, (uint16_t)height, x, y, w, h, (int16_t)x,
                   (int16_t)y, shm->depth, Z_PIXMAP, 0, shm->segment, 0);
    }
    shm->copied = shm->x.get_attributes(shm->connection, shm->window);
    shm->pending = true;
    /* Without this flush, libxcb would keep the request until the program waits for a reply or the buffer is full. */
    return shm->x.flush(shm->connection) > 0 || lost(shm);
}
