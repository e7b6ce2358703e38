/* SPDX-License-Identifier: Apache-2.0 */
/* The shaders of the window, which build-aux/source-strings embeds in the command. */
#ifndef OST_WINDOW_EMBEDDED_H
#define OST_WINDOW_EMBEDDED_H

#include <stddef.h>

extern const char *const ost_window_picture_vert[];
extern const char *const ost_window_picture_frag[];
extern const size_t ost_window_picture_vert_count;
extern const size_t ost_window_picture_frag_count;

#endif
