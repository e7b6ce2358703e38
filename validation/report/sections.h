/* SPDX-License-Identifier: Apache-2.0 */
/* Declares the larger sections of the report. The only parameter of each function is the page. */
#ifndef OST_VALIDATION_REPORT_SECTIONS_H
#define OST_VALIDATION_REPORT_SECTIONS_H

#include "validation/report/page.h"

/* Writes the time and the machine of the campaign's run. Writes nothing if the bundle has no environment.json. */
void section_machine(const page *p);
/* Writes the code paths that each backend counted, and the code paths that no case entered. Writes nothing if no
   backend counted paths. */
void section_paths(const page *p);
/* Writes the changes since an older bundle. Writes nothing if the bundle has no impact.json. */
void section_changes(const page *p);
/* Writes the table of results, by backend and family of cases. */
void section_compared(const page *p);
/* Writes a list of the user's own files, which belong to the cases from user/1 on. Writes nothing if there are no
   such cases. */
void section_own_files(const page *p);
/* Writes, for each stage, the number of the reference's records. */
void section_reference(const page *p);
/* Writes every result that is not equal, with its pictures. */
void section_differences(const page *p);
/* Writes the margins of differing voxels, by backend and stage. Writes nothing if no voxel differs. */
void section_margins(const page *p);
/* Writes the kinds of deliberate mistakes and whether each was detected. Writes nothing if the bundle has no
   sensitivity.json. */
void section_sensitivity(const page *p);
/* Writes the checks against results that do not depend on any program. Writes nothing if the bundle has no
   common.json. */
void section_common(const page *p);
/* Writes the build, the program, the devices and the libraries. Writes nothing if the bundle has no tools.json. */
void section_made_with(const page *p);
/* Writes how many requirements have tests, how many are also supported by results, and how many orphans there are.
   Writes nothing if the bundle has no trace.csv. */
void section_requirements(const page *p);
/* Writes the tests that requirements name, with their results. Writes nothing if the bundle has no suite.json. */
void section_suite(const page *p);

#endif
