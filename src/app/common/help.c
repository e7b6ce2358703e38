/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/help.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { COLUMN = 26, WIDTH = 80 };

/* Prints text, wrapped at blanks and indented to column COLUMN. */
static void wrapped(const char *text)
{
    int at = COLUMN;
    while (*text) {
        size_t word = strcspn(text, " ");
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

/* Prints one option. If the list of choices does not fit on the first line, it follows the help text. */
static void print_option(const option *o)
{
    if (o->kind == OPTION_HEADING) {
        printf("\n%s\n", o->name);
        return;
    }
    const bool flag = o->kind == OPTION_FLAG, listed = o->kind == OPTION_CHOICE && strlen(o->value) > WIDTH / 2;
    char head[WIDTH + COLUMN], choices[OPTION_SPOKEN], text[1024];
    int used = snprintf(head, sizeof head, "  --%s%s%s", o->name, flag ? "" : " ",
                        flag     ? ""
                        : listed ? "NAME"
                                 : o->value);
    if (used >= COLUMN) {
        printf("%s\n", head);
        used = 0;
        head[0] = '\0';
    }
    printf("%s%*s", head, COLUMN - used, "");
    snprintf(text, sizeof text, "%s%s%s", o->help, listed ? ": " : "",
             listed ? spoken_list(choices, o->value, "") : "");
    wrapped(text);
}

void help_print(const app_state *app, const usage_text *usage, const option *common)
{
    printf("usage: osteon %s %s\n\n%s\n\noptions\n", app->verb, usage->synopsis, usage->about);
    bool grouped = false;
    for (const option *o = usage->options; o->name; o++) {
        grouped = grouped || o->kind == OPTION_HEADING;
        print_option(o);
    }
    if (grouped)
        puts("\nevery verb");
    for (const option *o = common; o->name; o++)
        print_option(o);
    if (usage->notes)
        printf("\n%s\n", usage->notes);
    printf("\nexample\n%s\n", usage->example);
}

/* Returns the kind of an option's value, for shell completion: "flag", "file", "value", or the choices as "a|b|c". */
static const char *kind_of(const option *o)
{
    if (o->kind == OPTION_FLAG)
        return "flag";
    if (o->kind == OPTION_CHOICE)
        return o->value;
    return o->kind == OPTION_TEXT || o->kind == OPTION_OUTPUT || o->kind == OPTION_LIST ? "file" : "value";
}

static void print_candidates(const option *table)
{
    for (const option *o = table; o->name; o++)
        if (o->kind != OPTION_HEADING)
            printf("--%s\t%s\t%s\n", o->name, kind_of(o), o->help);
}

void help_print_candidates(const usage_text *usage, const option *common)
{
    print_candidates(usage->options);
    print_candidates(common);
}
