/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include <osteon/io.h>

#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "io/outfile.h"

#define SCHEMA                                                                                                         \
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"               \
    "markups-schema-v1.0.3.json#"

/*
 * A coordinate is written with 17 digits, which identify a double. ost_landmarks_read converts the double to its
 * shortest decimal, so positions are read back exactly.
 */
static json_t *point_json(const ost_landmark *l, int number)
{
    char id[16];
    (void)snprintf(id, sizeof id, "%d", number);
    return json_pack("{s:s, s:s, s:[f,f,f], s:s}", "id", id, "label", l->label, "position", ost_pm_to_mm(l->at.x),
                     ost_pm_to_mm(l->at.y), ost_pm_to_mm(l->at.z), "positionStatus", "defined");
}

ost_status ost_landmarks_write(const char *path, const ost_landmarks *landmarks, ost_error *err)
{
    json_t *points = json_array();
    bool complete = points != NULL;
    for (int i = 0; i < landmarks->count && complete; i++)
        complete = json_array_append_new(points, point_json(&landmarks->items[i], i + 1)) == 0;
    json_t *root = complete ? json_pack("{s:s, s:[{s:s, s:s, s:s, s:O}]}", "@schema", SCHEMA, "markups", "type",
                                        "Fiducial", "coordinateSystem", "LPS", "coordinateUnits", "mm",
                                        "controlPoints", points)
                            : NULL;
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_PRESERVE_ORDER) : NULL;
    json_decref(root);
    json_decref(points);
    if (!text)
        return ost_fail(err, OST_ERR_INPUT, "%s: the labels are not UTF-8, or memory is exhausted", path);
    ost_outfile *file;
    ost_status status = ost_outfile_open(path, &file, err);
    if (status == OST_OK) {
        status = ost_outfile_write(file, text, strlen(text), err);
        if (status == OST_OK)
            status = ost_outfile_write(file, "\n", 1, err);
        if (status == OST_OK)
            status = ost_outfile_commit(file, err);
        else
            ost_outfile_discard(file);
    }
    free(text);
    return status;
}
