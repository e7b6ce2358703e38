/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the cases' inputs as files, for a program that runs them without being
 * linked to this one.  docs/spec/dumps.md describes the files for that program's author.
 *
 *   plan --export_cases--> DIR/cases.json, DIR/import-0/case.json, samples.txt, tool-0.obj, tool-0.stl, path.csv, ...
 */
#ifndef OST_VALIDATION_EXPORT_H
#define OST_VALIDATION_EXPORT_H

#include "validation/plan.h"

/* The folder must not exist. */
ost_status export_cases(const char *folder, const plan *p, ost_error *err);

#endif
