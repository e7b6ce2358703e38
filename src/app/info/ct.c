/* SPDX-License-Identifier: Apache-2.0 */
#include "app/info/info.h"

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/result.h"
#include "io/stack/read.h"

ost_status info_text(const app_state *app, const char *name, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result r = {0};
    const ct_options ct = CT_OPTIONS_DEFAULT;
    char text[FORMAT_TEXT];
    ost_status status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, name, &ct, false, &bone, &r, err);
    ost_bone_free(bone);
    ost_backend_close(backend);
    if (status != OST_OK)
        return status;
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "text");
    put_integer(app->result, "samples", (int64_t)r.scatter.samples);
    print_line(app, "%s: a CT as text, %s lines of x y z density", name,
               format_count(text, (int64_t)r.scatter.samples));
    info_put_geometry(app, &r.rect);
    info_print_meta(app, &r.meta);
    return OST_OK;
}

ost_status info_stack(const app_state *app, const char *name, ost_error *err)
{
    ost_stack_facts facts;
    char text[FORMAT_TEXT];
    const ost_status status = ost_stack_describe(name, &facts, err);
    if (status != OST_OK)
        return status;
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "stack");
    put_text(app->result, "element_type", facts.type);
    put_text(app->result, "encoding", facts.encoding);
    put_dims(app->result, "dims", facts.dims);
    put(app->result, "pixel_mm", json_pack("[f,f]", facts.pixel_mm[0], facts.pixel_mm[1]));
    print_line(app, "%s: a stack of %d slices, %s, %s", name, facts.dims.z, facts.type, facts.encoding);
    print_line(app, "  %s voxels; osteon import --spacing states their size", format_dims(text, facts.dims));
    if (facts.pixel_mm[0] > 0 && facts.pixel_mm[1] > 0)
        print_line(app, "  its first slice states %.6g x %.6g mm per pixel, which may be wrong", facts.pixel_mm[0],
                   facts.pixel_mm[1]);
    return OST_OK;
}
