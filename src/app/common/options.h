/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parses options and prints --help and error messages. A table describes the options.
 *
 *   --name VALUE   --name=VALUE   -n VALUE   --flag   --   operands anywhere
 *
 * Names must not be abbreviated, because an abbreviation could change its meaning when an option is added. A value may
 * begin with one '-', as in -57.34. If a value begins with two '-', it must be written after '='. Every verb also has
 * --backend, --threads, --json, --quiet and --help.
 */
#ifndef OST_APP_COMMON_OPTIONS_H
#define OST_APP_COMMON_OPTIONS_H

#include "app/common/app.h"
#include "app/common/names.h"

typedef enum option_kind {
    OPTION_FLAG,     /* bool */
    OPTION_TEXT,     /* const char * */
    OPTION_OUTPUT,   /* const char *: the path of a file to write, which no other argument may name */
    OPTION_LIST,     /* an option_list, to which each occurrence of the option adds its value */
    OPTION_INTEGER,  /* an int64_t in min..max */
    OPTION_DECIMAL,  /* option_decimal */
    OPTION_LENGTH,   /* an ost_pm greater than zero */
    OPTION_LENGTHS,  /* an ost_pm3 of positive lengths: one number for all axes, or x,y,z */
    OPTION_POINT,    /* an ost_pm3 x,y,z whose components may be negative */
    OPTION_VECTOR,   /* double[3] */
    OPTION_CHOICE,   /* an int: the index of the value in a list such as "a|b|c" */
    OPTION_HEADING   /* no option; the name is a heading in --help */
} option_kind;

enum { OPTION_LIST_MAX = 16 };
typedef struct option_list {
    int count;
    const char *value[OPTION_LIST_MAX];
} option_list;

typedef struct option_decimal {
    ost_decimal value;
    const char *text;
} option_decimal;

typedef struct option {
    const char *name;
    option_kind kind;
    void *out;         /* where the value is stored; must contain the default before parsing */
    bool *given;       /* may be NULL */
    const char *value; /* placeholder of the value in --help; for OPTION_CHOICE, the list of choices */
    int64_t min, max;  /* allowed range of an OPTION_INTEGER */
    const char *help;
    bool required;
} option;

/* A row of an option table that starts a group of options in --help. */
#define HEADING(text) {.name = (text), .kind = OPTION_HEADING}

/* The row of --compress in the option table of a verb that writes volumes. */
#define COMPRESS_OPTION(flag)                                                                                          \
    {.name = "compress", .kind = OPTION_FLAG, .out = &(flag), .help = "compress a .nrrd with gzip"}

typedef struct operand {
    const char *name;
    const char **out;
    /* the message if the operand is missing, such as "no CT given"; NULL if the operand is optional; only the last
       operand may be optional */
    const char *missing;
} operand;

typedef struct usage_text {
    const char *synopsis; /* the operands in the usage line, after "osteon VERB " */
    const char *about;
    const operand *operands; /* ends with an element whose name is NULL; may be NULL */
    const option *options;   /* ends with an element whose name is NULL */
    /* true if an operand may be "-" or a pipe; the data of such an operand are copied to a temporary file
       (core/file.h) */
    bool streams;
    const char *notes;       /* text at the end of --help, about units and coordinate systems; may be NULL */
    const char *example;
} usage_text;

/*
 * Parses the arguments. Returns true if the verb must continue. If the function returns false, the verb must return
 * *status; after --help, *status is OST_OK.
 */
bool options_parse(app_state *app, const usage_text *usage, int argc, char **argv, ost_status *status, ost_error *err);

/* Returns true if `spec`, such as "cpu:threads=2" or "udp:port=0", names the backend or device `name`. */
bool spec_is(const char *spec, const char *name);

/* Reports an incorrect use of the verb in one line that ends with a reference to the verb's help. */
ost_status usage_error(const app_state *app, ost_error *err, const char *format, ...) OST_PRINTF(3, 4);

#endif
