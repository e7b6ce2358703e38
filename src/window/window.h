/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A window that shows pixels and says what people do in it.
 *
 *   GLFW: the window, keys, mouse        OpenGL 3.3: a texture on a triangle that covers it
 *
 * What is drawn comes from the processor; OpenGL brings it to the screen, be
 * it a graphics card's or software.
 *
 * One window at a time, by the thread that opened it, the program's main one.
 */
#ifndef OST_WINDOW_WINDOW_H
#define OST_WINDOW_WINDOW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

typedef struct ost_window ost_window;

typedef enum ost_window_event_kind {
    OST_WINDOW_KEY,    /* key, pressed, mods */
    OST_WINDOW_BUTTON, /* button 0 left, 1 right, 2 middle; pressed, mods */
    OST_WINDOW_MOVE,   /* x, y: of the pointer, in pixels of the picture */
    OST_WINDOW_WHEEL,  /* y: steps, away from who turns it is up; mods */
    OST_WINDOW_RELEASE /* some were lost: all keys and buttons are up */
} ost_window_event_kind;

enum { OST_WINDOW_SHIFT = 1, OST_WINDOW_CONTROL = 2, OST_WINDOW_ALT = 4 };

/* Printable keys are their capital letter or digit on a US layout; others: */
enum {
    OST_KEY_ESCAPE = 256, OST_KEY_ENTER, OST_KEY_TAB, OST_KEY_LEFT, OST_KEY_RIGHT, OST_KEY_UP, OST_KEY_DOWN, OST_KEY_HOME,
    OST_KEY_PAGE_UP, OST_KEY_PAGE_DOWN, OST_KEY_PLUS, OST_KEY_MINUS, OST_KEY_F1 = 300 /* and on to F12 */
};

typedef struct ost_window_event {
    ost_window_event_kind kind;
    int key, button;
    bool pressed;
    unsigned mods;
    double x, y;
} ost_window_event;

typedef struct ost_window_info {
    const char *renderer; /* of OpenGL, for people: "llvmpipe (LLVM 15.0.6, 256 bits)" */
    const char *version;
    bool software;        /* it is drawn by the processor too */
    bool robust;          /* a driver that has to start anew says so */
    int resets;           /* how often one did; the window went on with a new context */
} ost_window_info;

/* Null when this build has windows; else why not, and what to do about it. */
const char *ost_window_missing(void);

/*
 * OST_ERR_UNAVAILABLE, with what is missing: this build's window, a display, OpenGL 3.3.  A context of 4.4 is asked for
 * first, and one that tells of a driver's reset where there is one.
 */
ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err);
void ost_window_close(ost_window *window); /* NULL is allowed */
ost_window_info ost_window_info_get(const ost_window *window);

/*
 * Of the picture that it wants, in pixels: of its frame, or as large as can be shown; 0 x 0 while nobody sees it.
 * scale: pixels to what 96 to the inch would be.
 */
enum { OST_WINDOW_SIDE = 8192 }; /* at most */
void ost_window_size(const ost_window *window, int *width, int *height, double *scale);
/* Asked to close by its frame, or gone with its display. */
bool ost_window_closing(const ost_window *window);
/* OST_ERR_UNAVAILABLE when it is gone, and how. */
ost_status ost_window_check(const ost_window *window, ost_error *err);
/* On the screen that most of it is on; nothing happens where there is none. */
void ost_window_full_screen(ost_window *window, bool on);
bool ost_window_is_full_screen(const ost_window *window);
void ost_window_title(ost_window *window, const char *title);
/* The system has lost what was shown: it is to be presented again. */
bool ost_window_damaged(const ost_window *window);

/* Waits at most timeout_s for something to happen, 0: not at all; then the events, in their order, until none is left. */
void ost_window_poll(ost_window *window, double timeout_s);
bool ost_window_next(ost_window *window, ost_window_event *out);

enum { OST_WINDOW_CELL_WIDTH = 16, OST_WINDOW_CELL_HEIGHT = 8 };
typedef struct ost_window_picture {
    const uint32_t *pixels; /* 0x..BBGGRR, rows of stride from the top */
    int stride, width, height;
    /*
     * What may differ from the picture that was presented last, which had this size: cells of 16 x 8 pixels, a bit each, in
     * rows of changed_words.  NULL: anything.
     */
    const uint64_t *changed;
    int changed_words;
} ost_window_picture;

/*
 * In the size that was asked for last. sync: with the screen, where it has a clock.  A driver that was reset gets a new
 * context, and the picture the next time.  OST_ERR_UNAVAILABLE when that fails or happens again and again, or when the
 * display is gone: there is nothing to do then but to close.
 */
ost_status ost_window_present(ost_window *window, const ost_window_picture *picture, bool sync, ost_error *err);

#endif
