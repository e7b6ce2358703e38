/* SPDX-License-Identifier: Apache-2.0 */
/* Formats lists of names for messages, and finds the name that the user probably meant. */
#ifndef OST_APP_COMMON_NAMES_H
#define OST_APP_COMMON_NAMES_H

/* Writes the list "a|b|c" to `text` in the form "a, b or c", with `before` in front of each name. Returns `text`. */
enum { OPTION_SPOKEN = 160 };
const char *spoken_list(char text[OPTION_SPOKEN], const char *names, const char *before);

/* Returns the name that is most similar to the misspelt name `text`, or NULL if no name is similar. */
const char *nearest_name(const char *text, const char *const *names, int count);

#endif
