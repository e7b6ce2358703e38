/* SPDX-License-Identifier: Apache-2.0 */
/* Lists the series of a folder of DICOM files, with the attributes that distinguish them. */
#include "app/info/info.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"

static void put_series(json_t *list, const ost_dicom_series *s)
{
    json_t *o = json_object();
    put(o, "number", s->numbered ? json_integer(s->number) : json_null());
    put_text(o, "description", s->description);
    put_text(o, "uid", s->uid);
    put_text(o, "modality", s->modality);
    put_text(o, "kernel", s->kernel);
    put_integer(o, "images", s->images);
    put_integer(o, "localizers", s->localizers);
    put_bool(o, "volume", s->is_volume);
    if (s->is_volume) {
        put_dims(o, "dims", s->geometry.dims);
        put_mm3(o, "spacing_mm", s->geometry.spacing);
        put_text(o, "orientation", s->orientation);
        put_mm(o, "thickness_mm", s->thickness);
    }
    put_text(o, "fault", s->fault);
    append(list, o);
}

static void print_series(const app_state *app, const ost_dicom_series *s)
{
    char number[16] = "-", a[FORMAT_TEXT], b[FORMAT_TEXT], mm[OST_PM_TEXT];
    if (s->numbered)
        snprintf(number, sizeof number, "%" PRId32, s->number);
    print_line(app, "  series %s: %s%s%s%s%s, %s image%s%s", number, s->modality[0] ? s->modality : "no modality",
               s->description[0] ? ", " : "", s->description, s->kernel[0] ? ", kernel " : "", s->kernel,
               format_count(a, s->images), s->images == 1 ? "" : "s", s->localizers ? " and localizers" : "");
    if (s->is_volume)
        print_line(app, "    %s voxels of %s, axes to %s%s%s%s", format_dims(a, s->geometry.dims),
                   format_spacing(b, s->geometry.spacing), s->orientation, s->thickness ? ", thickness " : "",
                   s->thickness ? ost_pm_format(s->thickness, mm) : "", s->thickness ? " mm" : "");
    else if (s->fault[0])
        print_line(app, "    cannot be read: %s", s->fault);
    if (s->uid[0])
        print_line(app, "    UID %s", s->uid);
}

/*
 * Lists the series of a folder of DICOM files. If the options select one series that can be read, sets *found to true
 * and *geometry to its geometry. Returns OST_ERR_INPUT if no file is DICOM.
 */
static ost_status list_series(const app_state *app, const char *name, const ost_volume_options *options, bool *found,
                              ost_geometry *geometry, ost_error *err)
{
    ost_dicom_list list;
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    *found = false;
    ost_status status = ost_dicom_list_read(name, options, &list, err);
    if (status != OST_OK)
        return status;
    if (list.count == 0 && list.files == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: the folder contains no file; expected DICOM images", name);
    else if (list.count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: contains no DICOM image; %" PRId64 " file%s examined", name,
                          list.files, list.files == 1 ? " was" : "s were");
    json_t *items = json_array();
    for (size_t i = 0; i < list.count; i++) {
        put_series(items, &list.items[i]);
        if ((int64_t)i == list.selected && list.items[i].is_volume) {
            *found = true;
            *geometry = list.items[i].geometry;
        }
    }
    put(app->result, "series", items);
    put_integer(app->result, "files", list.files);
    put_integer(app->result, "other_files", list.other_files);
    if (list.count) {
        print_line(app, "%s: DICOM, %s series in %s file%s%s%s%s", name, format_count(a, (int64_t)list.count),
                   format_count(b, list.files), list.files == 1 ? "" : "s", list.other_files ? ", of which " : "",
                   list.other_files ? format_count(c, list.other_files) : "",
                   list.other_files ? " have no DICOM image" : "");
        for (size_t i = 0; i < list.count; i++)
            print_series(app, &list.items[i]);
    }
    ost_dicom_list_free(&list);
    return status;
}

ost_status info_folder(const app_state *app, const char *name, const dicom_options *dicom, bool digest, ost_error *err)
{
    ost_volume_options options = {.clamp = false};
    ost_geometry geometry;
    ost_volume volume = {0};
    ost_digest root;
    bool found;
    load_dicom_options(dicom, &options);
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "DICOM");
    ost_status status = list_series(app, name, &options, &found, &geometry, err);
    if (status != OST_OK)
        return status;
    if (found)
        info_put_geometry(app, &geometry);
    if (!digest)
        return OST_OK;
    status = ost_volume_read(name, &options, &volume, NULL, err);
    if (status == OST_OK)
        status = ost_digest_volume(OST_GRID_RECT, &volume, &root, err);
    ost_volume_free(&volume);
    if (status == OST_OK) {
        char hex[OST_DIGEST_HEX];
        put_digest(app->result, "sha256", &root);
        print_line(app, "  grid %s", ost_digest_hex(&root, hex));
    }
    return status;
}
