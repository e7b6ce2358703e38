/* SPDX-License-Identifier: Apache-2.0 */
/* Calls the parts of an operation in order: devices and windows, inputs, the servo loop, the output files. */
#include "app/sim/appearance.h"
#include "app/sim/headset.h"
#include "app/sim/window.h"

ost_status sim_operate(app_state *app, sim_args *args, ost_error *err)
{
    simulation s = {0};
    ost_status status = OST_OK;
    sim_pin(args, &s);
    if (args->headset)
        status = sim_headset_open(args, &s, err);
    else if (!args->headless)
        status = sim_window_open(app, args, &s, err);
    if (status == OST_OK && args->resume)
        status = sim_resume_open(app, args, &s, err);
    if (status == OST_OK)
        status = sim_load(app, args, &s, err);
    if (status == OST_OK)
        status = sim_force_make(app, args, &s, err);
    if (status == OST_OK)
        status = sim_check_start(app, args, &s, err);
    if (status == OST_OK)
        status = sim_record_begin(args, &s, err);
    if (status == OST_OK)
        status = sim_appearance_store_uncut(args, &s, err);
    if (status == OST_OK && s.resumed)
        status = sim_resume_run(args, &s, err);
    if (status == OST_OK)
        status = sim_show_make(app, args, &s, err);
    if (status == OST_OK)
        status = sim_film_begin(args, &s, err);
    if (status == OST_OK)
        status = sim_run(app, args, &s, err);
    if (status == OST_OK) {
        sim_report_loop(app, args, &s);
        if (s.headset)
            sim_headset_report(app, &s);
        if (s.show)
            sim_show_report(app, s.show);
        status = sim_finish(app, args, &s, err);
    }
    /* At this point, the output files are complete. Failures in other parts are reported only now. */
    if (status == OST_OK)
        status = sim_film_end(app, args, &s, err);
    if (status == OST_OK)
        status = sim_window_end(&s, err);
    if (status == OST_OK)
        status = sim_headset_end(&s, err);
    if (status == OST_OK)
        status = sim_device_end(app, args, &s, err);
    simulation_free(&s);
    return status;
}
