/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A window that shows pixels and reports the user's input.
 *
 *   GLFW: the window, keys, mouse        OpenGL 3.3: a texture on a triangle that covers it
 *
 * Other modules draw the pictures. OpenGL, on a graphics card or in software, shows them on the
 * screen. On a graphics card, another module can also draw directly into the window's framebuffer.
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
    OST_WINDOW_KEY,    /* a key; uses the fields key, pressed and mods */
    /* a mouse button; uses the fields button (0 left, 1 right, 2 middle), pressed and mods */
    OST_WINDOW_BUTTON,
    OST_WINDOW_MOVE,   /* a motion; x and y are the position of the pointer in picture pixels */
    /* the wheel; y is the number of steps, positive if the wheel is turned away from the user; also uses mods */
    OST_WINDOW_WHEEL,
    OST_WINDOW_RELEASE /* events were lost; all keys and buttons count as released */
} ost_window_event_kind;

enum { OST_WINDOW_SHIFT = 1, OST_WINDOW_CONTROL = 2, OST_WINDOW_ALT = 4 };

/* A printable key has the code of its capital letter or digit on a US layout. The other keys have these codes. */
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
    OST_KEY_F1 = 300 /* the codes of F2 to F12 follow this code */
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
    bool software;        /* true if the processor executes OpenGL */
    bool robust;          /* set if the driver reports resets */
    int resets;           /* number of resets of the driver after which the window continued with a new context */
} ost_window_info;

/* Returns NULL if this build supports windows. Otherwise returns the reason why it does not, and a remedy. */
const char *ost_window_missing(void);

/*
 * Opens a window. Returns OST_ERR_UNAVAILABLE if this build has no windows, if there is no display, or if OpenGL 3.3 is
 * missing; err names the missing part. A context of version 4.4 is tried first. If the driver supports it, the context
 * reports resets of the driver.
 */
ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err);
void ost_window_close(ost_window *window); /* NULL is allowed */
ost_window_info ost_window_info_get(const ost_window *window);

/*
 * Returns the size in pixels that the next picture must have. This is the size of the framebuffer, limited to the
 * greatest size that can be shown; while the window is not visible, the size is 0 x 0. *scale is the ratio of the
 * display's resolution to 96 pixels per inch.
 */
enum { OST_WINDOW_SIDE = 8192 }; /* maximum width and height */
void ost_window_size(const ost_window *window, int *width, int *height, double *scale);
/* Returns true if the user requested to close the window, or if its display is gone. */
bool ost_window_closing(const ost_window *window);
/* Returns OST_ERR_UNAVAILABLE, with the reason in err, if the window or its display is gone. */
ost_status ost_window_check(const ost_window *window, ost_error *err);
/* Switches full screen on or off. Uses the screen that contains most of the window; does nothing if
   there is no screen. */
void ost_window_full_screen(ost_window *window, bool on);
bool ost_window_is_full_screen(const ost_window *window);
void ost_window_title(ost_window *window, const char *title);
/* Returns true if the system has lost the window's contents, so that the picture must be presented again. */
bool ost_window_damaged(const ost_window *window);

/*
 * ost_window_poll waits at most timeout_s seconds for an event; it does not wait if timeout_s is 0. Afterwards,
 * ost_window_next returns the events in the order of their arrival, and false when there are no more events.
 */
void ost_window_poll(ost_window *window, double timeout_s);
bool ost_window_next(ost_window *window, ost_window_event *out);

enum { OST_WINDOW_CELL_WIDTH = 16, OST_WINDOW_CELL_HEIGHT = 8 };
typedef struct ost_window_picture {
    /* pixels 0x..BBGGRR, with the top row first; a row has `stride` pixels */
    const uint32_t *pixels;
    int stride, width, height;
    /*
     * The cells that may differ from the last presented picture: one bit for each cell of 16 x 8 pixels, in rows of
     * changed_words words. The last picture must have had the same size. NULL means that any pixel may differ.
     */
    const uint64_t *changed;
    int changed_words;
} ost_window_picture;

/*
 * Shows a picture of the size that ost_window_size returned last. If sync is true and the screen
 * has vertical sync, waits for the vertical sync. After a reset of the driver, a new context is
 * created, and the picture appears with the next call. Returns OST_ERR_UNAVAILABLE if no new context
 * can be created, if resets happen repeatedly, or if the display is gone. The caller must then close
 * the window.
 */
ost_status ost_window_present(ost_window *window, const ost_window_picture *picture, bool sync, ost_error *err);

/*
 * Returns true if another module can draw a picture of the given size with the window's OpenGL context, into
 * framebuffer 0: the window exists, its framebuffer has this size, and a graphics card executes OpenGL. The context is
 * current on the main thread. After a reset of the driver (ost_window_info.resets has increased), all objects of the
 * other module have been destroyed together with the context.
 */
bool ost_window_can_be_drawn(const ost_window *window, int width, int height);
/* Shows what was drawn into framebuffer 0. Otherwise behaves like ost_window_present. */
ost_status ost_window_show_drawn(ost_window *window, bool sync, ost_error *err);

#endif
