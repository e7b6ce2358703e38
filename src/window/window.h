/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A window that shows pixels and reports the user's input.
 *
 *   GLFW: the window, keys, mouse        OpenGL 3.3: a texture on a triangle that covers it
 *
 * Other modules draw the pictures. OpenGL shows them, on a graphics card or in software. On a graphics card, another
 * module can also draw directly into the window's framebuffer.
 *
 * There is at most one window. All functions must be called on the program's main thread.
 */
#ifndef OST_WINDOW_WINDOW_H
#define OST_WINDOW_WINDOW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

typedef struct ost_window ost_window;

typedef enum ost_window_event_kind {
    OST_WINDOW_KEY,    /* key; uses `key`, `pressed` and `mods` */
    /* mouse button; uses `button` (0 left, 1 right, 2 middle), `pressed` and `mods` */
    OST_WINDOW_BUTTON,
    OST_WINDOW_MOVE,   /* pointer motion; x and y are the new position in picture pixels */
    /* wheel; y is the number of steps, positive away from the user; also uses `mods` */
    OST_WINDOW_WHEEL,
    OST_WINDOW_RELEASE /* events were lost; all keys and buttons must be treated as released */
} ost_window_event_kind;

enum { OST_WINDOW_SHIFT = 1, OST_WINDOW_CONTROL = 2, OST_WINDOW_ALT = 4 };

/* Codes of keys. The code of a printable key is its capital letter or digit on a US layout. */
enum {
    OST_KEY_ESCAPE = 256,
    OST_KEY_ENTER,
    OST_KEY_TAB,
    OST_KEY_LEFT,
    OST_KEY_RIGHT,
    OST_KEY_UP,
    OST_KEY_DOWN,
    OST_KEY_HOME,
    OST_KEY_PAGE_UP,
    OST_KEY_PAGE_DOWN,
    OST_KEY_PLUS,
    OST_KEY_MINUS,
    OST_KEY_F1 = 300 /* F2 to F12 have the following codes */
};

typedef struct ost_window_event {
    ost_window_event_kind kind;
    int key, button;
    bool pressed;
    unsigned mods;
    double x, y;
} ost_window_event;

typedef struct ost_window_info {
    const char *renderer; /* name of OpenGL's renderer, for example "llvmpipe (LLVM 15.0.6, 256 bits)" */
    const char *version;
    bool software;        /* true for a software renderer */
    bool robust;          /* true if the driver reports resets */
    int resets;           /* number of driver resets that the window has survived with a new context */
} ost_window_info;

/* Returns NULL if this build supports windows, otherwise the reason why it does not, with a remedy. */
const char *ost_window_missing(void);

/*
 * Opens a window. Returns OST_ERR_UNAVAILABLE if this build has no windows, if there is no display, or if OpenGL 3.3 is
 * missing; the message names the missing component. Tries a context of version 4.4 first, and requests that the driver
 * report resets.
 */
ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err);
void ost_window_close(ost_window *window); /* NULL is allowed */
ost_window_info ost_window_info_get(const ost_window *window);

/*
 * Returns the size in pixels that the next picture must have. It is the size of the framebuffer, limited to the maximum
 * that can be shown, or 0 x 0 while the window is not visible. *scale is the display's resolution divided by 96 pixels
 * per inch.
 */
enum { OST_WINDOW_SIDE = 8192 }; /* maximum width and height */
void ost_window_size(const ost_window *window, int *width, int *height, double *scale);
/* Returns true if the user has requested to close the window, or if its display is gone. */
bool ost_window_closing(const ost_window *window);
/* Returns OST_ERR_UNAVAILABLE, with the reason in err, if the window or its display is gone. */
ost_status ost_window_check(const ost_window *window, ost_error *err);
/* Switches full screen on or off, on the screen that contains most of the window. No-op if there is no screen. */
void ost_window_full_screen(ost_window *window, bool on);
bool ost_window_is_full_screen(const ost_window *window);
void ost_window_title(ost_window *window, const char *title);
/* Returns true if the system has lost the window's contents, so that the picture must be presented again. */
bool ost_window_damaged(const ost_window *window);

/*
 * ost_window_poll waits up to timeout_s seconds for an event; 0 means no wait. Afterwards, each call of
 * ost_window_next stores one event in *out, in the order of arrival. It returns false if there are no more events.
 */
void ost_window_poll(ost_window *window, double timeout_s);
bool ost_window_next(ost_window *window, ost_window_event *out);

enum { OST_WINDOW_CELL_WIDTH = 16, OST_WINDOW_CELL_HEIGHT = 8 };
typedef struct ost_window_picture {
    /* pixels 0x..BBGGRR, with the top row first; a row has `stride` pixels */
    const uint32_t *pixels;
    int stride, width, height;
    /*
     * array of bits, one for each cell of 16 x 8 pixels, in rows of changed_words words. A bit is set if its cell may
     * differ from the last presented picture. NULL if any pixel may differ; ignored if the last picture had a different
     * size
     */
    const uint64_t *changed;
    int changed_words;
} ost_window_picture;

/*
 * Shows a picture of the size that ost_window_size last returned. If `sync` is true, waits for the screen's vertical
 * sync, if there is one. After a driver reset, creates a new context and does not show the picture; the next call shows
 * one. Returns OST_ERR_UNAVAILABLE if no new context can be created, if resets recur, or if the display is gone. The
 * caller must then close the window.
 */
ost_status ost_window_present(ost_window *window, const ost_window_picture *picture, bool sync, ost_error *err);

/*
 * Returns true if another module can draw a picture of the given size directly into framebuffer 0. The window must
 * exist, its framebuffer must have this size, and OpenGL must run on a graphics card. If true, the context is current
 * on the main thread. A driver reset increases ost_window_info.resets; the old context, with all objects of the other
 * module, is then lost.
 */
bool ost_window_can_be_drawn(const ost_window *window, int width, int height);
/* Shows the contents of framebuffer 0. In all other respects, the function works like ost_window_present. */
ost_status ost_window_show_drawn(ost_window *window, bool sync, ost_error *err);

#endif
