/* SPDX-License-Identifier: Apache-2.0 */
/* The larger sections of the page; each is a function only of the page. */
#ifndef OST_VALIDATION_REPORT_SECTIONS_H
#define OST_VALIDATION_REPORT_SECTIONS_H

#include "validation/report/page.h"

/* Writes when and where the campaign ran; nothing without environment.json. */
void section_machine(const page *p);
/* Writes the paths that each backend counted, and those that no case entered; nothing if no backend counted. */
void section_paths(const page *p);
/* Writes the changes since an older bundle; nothing without impact.json. */
void section_changes(const page *p);
/* Writes what was compared: backends by families of cases. */
void section_compared(const page *p);
/* Writes which of the user's own files are the cases from user/1 on; nothing without such cases. */
void section_own_files(const page *p);
/* Writes the results of the reference: stages and the number of their records. */
void section_reference(const page *p);
/* Writes each result that is not equal, with its pictures if there are any. */
void section_differences(const page *p);
/* Writes how close the differing decisions were, by backend and stage; nothing if no voxel differs. */
void section_margins(const page *p);
/* Writes the deliberate mistakes and whether they were noticed; nothing without sensitivity.json. */
void section_sensitivity(const page *p);
/* Writes the checks against results that are known without any program; nothing without common.json. */
void section_common(const page *p);
/* Writes build, program, devices and libraries; nothing without tools.json. */
void section_made_with(const page *p);
/* Writes the numbers of requirements that are tested, shown, or orphans; nothing without trace.csv. */
void section_requirements(const page *p);
/* Writes the tests that requirements name, with their results; nothing without suite.json. */
void section_suite(const page *p);

#endif
