/* SPDX-License-Identifier: Apache-2.0 */
/* The larger sections of the page. Each function takes only the page as its parameter. */
#ifndef OST_VALIDATION_REPORT_SECTIONS_H
#define OST_VALIDATION_REPORT_SECTIONS_H

#include "validation/report/page.h"

/* Writes when and where the campaign ran. Writes nothing if the bundle has no environment.json. */
void section_machine(const page *p);
/* Writes the paths that each backend counted, and those that no case entered. Writes nothing if no backend counted
   paths. */
void section_paths(const page *p);
/* Writes the changes since an older bundle. Writes nothing if the bundle has no impact.json. */
void section_changes(const page *p);
/* Writes what was compared: backends by families of cases. */
void section_compared(const page *p);
/* Writes a list of the user's own files for the cases from user/1 on. Writes nothing if there are no such cases. */
void section_own_files(const page *p);
/* Writes the results of the reference: stages and the number of their records. */
void section_reference(const page *p);
/* Writes each result that is not equal, with its pictures if there are any. */
void section_differences(const page *p);
/* Writes how close the differing decisions were, by backend and stage. Writes nothing if no voxel differs. */
void section_margins(const page *p);
/* Writes the deliberate mistakes and whether they were noticed. Writes nothing if the bundle has no
   sensitivity.json. */
void section_sensitivity(const page *p);
/* Writes the checks against results that are known without any program. Writes nothing if the bundle has no
   common.json. */
void section_common(const page *p);
/* Writes build, program, devices and libraries. Writes nothing if the bundle has no tools.json. */
void section_made_with(const page *p);
/* Writes how many requirements have tests, how many of these are supported by results, and how many orphans there are.
   Writes nothing if the bundle has no trace.csv. */
void section_requirements(const page *p);
/* Writes the tests that requirements name, with their results. Writes nothing if the bundle has no suite.json. */
void section_suite(const page *p);

#endif
