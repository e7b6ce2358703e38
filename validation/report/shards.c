/* SPDX-License-Identifier: Apache-2.0 */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/report/page.h"
#include "validation/bundle/reproduce.h"
#include "validation/report/pictures.h"

/* Copies a file from the shard that contains it, and sets *taken to true. If no shard contains it, sets *taken to
   false. At most one shard contains the file. */
static ost_status take(const char *folder, const char *name, bool *taken, evidence_sink *sink, void *user,
                       ost_error *err)
{
    DIR *dir = opendir(folder);
    ost_status status = dir ? OST_OK : ost_fail(err, OST_ERR_INPUT, "%s: %s", folder, strerror(errno));
    *taken = false;
    for (struct dirent *e;
         status == OST_OK && !*taken && (status = bundle_next_entry(dir, folder, &e, err)) == OST_OK && e;) {
        char path[BUNDLE_PATH], *bytes;
        size_t size;
        if (e->d_name[0] == '.' || snprintf(path, sizeof path, "%s/%s", folder, e->d_name) >= (int)sizeof path)
            continue;
        status = bundle_find(path, name, &bytes, &size, err);
        if (!bytes)
            continue;
        *taken = true;
        status = sink(user, name, bytes, size, err);
        free(bytes);
    }
    if (dir)
        closedir(dir);
    return status;
}

ost_status pictures_of_shards(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                              void *user, ost_error *err)
{
    static const char *const operation[] = {PICTURE_BEFORE, PICTURE_AFTER, PICTURE_SLICES_BEFORE, PICTURE_SLICES_AFTER};
    const json_t *backends = json_object_get(protocol, "backends");
    ost_status status = OST_OK;
    bool taken;
    for (size_t i = 0; i < sizeof operation / sizeof operation[0] && status == OST_OK; i++)
        status = take(folder, operation[i], &taken, sink, user, err);
    for (size_t s = 1; s < json_array_size(backends) && status == OST_OK; s++) {
        int count = 0;
        for (size_t i = 0; i < json_array_size(cases) && status == OST_OK; i++) {
            const json_t *one = json_array_get(cases, i);
            const json_t *r = json_object_get(json_object_get(one, "results"),
                                              evidence_text(json_array_get(backends, s), "name"));
            if (strcmp(evidence_text(r, "verdict"), case_verdict_name(CASE_DIFFERS)) != 0)
                continue;
            if (reproduce_name_ok(evidence_text(r, "reproduce")) && status == OST_OK)
                status = take(folder, evidence_text(r, "reproduce"), &taken, sink, user, err);
            if (count >= PICTURES_A_BACKEND)
                continue;
            for (int role = 0; role < PICTURE_ROLES && status == OST_OK; role++) {
                char name[PICTURE_NAME];
                picture_name(name, evidence_text(one, "id"), s, (picture_role)role);
                status = take(folder, name, &taken, sink, user, err);
            }
            count += taken;
        }
    }
    return status;
}
