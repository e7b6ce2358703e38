/* SPDX-License-Identifier: Apache-2.0 */
/* Measures one case, that is, the selected methods on one scene. */
#ifndef OST_REPRODUCTION_METHODS_MEASURE_H
#define OST_REPRODUCTION_METHODS_MEASURE_H

#include "reproduction/methods/method.h"

/* Checks the options. Returns OST_ERR_USAGE if a method is unknown or the number of threads is less than 1. */
ost_status methods_check(const methods_options *options, ost_error *err);

/* Verifies and times the selected methods on a scene, and appends a row for each of them. */
ost_status methods_measure(const methods_options *options, const methods_scene *scene, int chunk_size,
                           methods_table *table, ost_error *err);
/*
 * Appends a row with the reason for each selected method that was not measured. `scene` provides the scene's columns.
 */
ost_status methods_not_measured(const methods_options *options, const methods_row *scene, const char *reason,
                                methods_table *table, ost_error *err);

#endif
