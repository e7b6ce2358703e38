/* SPDX-License-Identifier: Apache-2.0 */
/* Rows of the option tables of verbs that remove bone along a path. */
#ifndef OST_APP_INPUT_REMOVAL_OPTIONS_H
#define OST_APP_INPUT_REMOVAL_OPTIONS_H

#include <osteon/motor.h>

#include "app/common/options.h"

/* *given_out is set to true if the option was given; given_out may be NULL */
#define RPM_OPTION(rpm, given_out)                                                                                     \
    {.name = "rpm", .kind = OPTION_INTEGER, .out = &(rpm), .given = (given_out), .min = 0, .max = OST_RPM_MAX,         \
     .value = "N",                                                                                                     \
     .help = "speed of the tool's motor in revolutions per minute, clockwise seen from behind; 0: off, and "           \
             "nothing is removed (default: 200)"}

#define RATE_OPTION(rate)                                                                                              \
    {.name = "rate", .kind = OPTION_DECIMAL, .out = &(rate), .value = "HZ",                                            \
     .help = "removals per second (default: at every tick)"}

#define SWEEP_OPTION(sweep)                                                                                            \
    {.name = "sweep", .kind = OPTION_CHOICE, .out = &(sweep), .value = "off|on",                                       \
     .help = "also remove bone along the motion between two ticks (default: on)"}

#define CLASSES_OPTION(text)                                                                                           \
    {.name = "classes", .kind = OPTION_TEXT, .out = &(text), .value = "NAME:HU,...",                                   \
     .help = "density classes of the counts, each from its HU upwards (default: "                                      \
             "cartilage:120,cancellous:150,cortical:650)"}

#endif
