/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/show.h"

ost_status sim_film_begin(const sim_args *args, simulation *s, ost_error *err)
{
    if (!s->window && !args->video.target && !args->video.pipe)
        return OST_OK;
    ost_status status = film_open(&args->video, &s->film, err);
    if (status == OST_OK && s->show)
        s->show->film = s->film;
    return status;
}

ost_status sim_film_end(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    film_report r;
    film *f = s->film;
    if (!f)
        return OST_OK;
    s->film = NULL;
    const bool video = args->video.target || args->video.pipe;
    const ost_status status = film_close(f, s->show->end_ns, &r, err);
    if (status != OST_OK || !video)
        return status;
    film_print_report(app, &args->video, &r);
    return status;
}
