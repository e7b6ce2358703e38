/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/help.h"

#include <stdio.h>
#include <string.h>

enum { COLUMN = 26, WIDTH = 80 };

/* Prints text from COLUMN on, wrapped at blanks; a newline counts as a blank. */
static void wrapped(const char *text)
{
    int at = COLUMN;
    while (*text) {
        size_t word = strcspn(text, " \n");
        if (at > COLUMN && at + 1 + (int)word > WIDTH - 1) {
            printf("\n%*s", COLUMN, "");
            at = COLUMN;
        } else if (at > COLUMN) {
            putchar(' ');
            at++;
        }
        printf("%.*s", (int)word, text);
        at += (int)word;
        text += word;
        text += *text != '\0';
    }
    putchar('\n');
}

static void print_option(const option *o)
{
    char head[80];
    int used = snprintf(head, sizeof head, "  --%s%s%s", o->name, o->kind == OPTION_FLAG ? "" : " ", o->kind == OPTION_FLAG ? "" : o->value);
    if (used >= COLUMN) {
        printf("%s\n", head);
        used = 0;
        head[0] = '\0';
    }
    printf("%s%*s", head, COLUMN - used, "");
    wrapped(o->help);
}

void help_print(const app_state *app, const usage_text *usage, const option *common)
{
    printf("usage: osteon %s %s\n\n%s\n\noptions\n", app->verb, usage->synopsis, usage->about);
    for (const option *o = usage->options; o->name; o++)
        print_option(o);
    for (const option *o = common; o->name; o++)
        print_option(o);
    if (usage->notes)
        printf("\n%s\n", usage->notes);
    printf("\nexample\n%s\n", usage->example);
}
