/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes impact.json, which lists the changes between an older bundle and this bundle, and possible causes
 * of the changes.
 *
 *   old/, new folder --bundle_difference--> results of the reference by case, stage and chunk
 *                    --cases.jsonl--------> verdicts of the backends in both bundles
 *                    --tools, devices-----> commit, compiler, flags, program, libraries, drivers
 *                    --requirements.csv---> added, removed, changed
 *
 * The older bundle is read but not checked; `osteon verify` can check it. Its root is recorded, so that
 * impact.json identifies the older bundle.
 */
#ifndef OST_VALIDATION_IMPACT_H
#define OST_VALIDATION_IMPACT_H

#include <jansson.h>
#include <osteon/status.h>

#define IMPACT_FILE "impact.json"

/* Returns OST_ERR_INPUT if the folder is not a bundle. Called before the first case runs. */
ost_status impact_check(const char *old, ost_error *err);

/*
 * Makes the content of impact.json, owned by the caller:
 * {against {root, results_root, version}, results (bundle_difference), verdicts[] {case, backend, old, new},
 *  causes[] {what, old, new}, libraries[], devices[], requirements[], explained, conclusion}.
 */
ost_status impact_of(const char *old, const char *now, json_t **out, ost_error *err);

#endif
