/* SPDX-License-Identifier: Apache-2.0 */
/* Where each number comes from is in docs/force.md. */
#include <osteon/force.h>

ost_force_params ost_force_defaults(void)
{
    return (ost_force_params){
        .mode = OST_FORCE_ENERGY,
        .scale = 0.08,
        .stiffness = 300,
        .damping = 0.5,
        .speed = 31.4,
        .cutting_ratio = 0.5,
        .energy = 30e6,
        .reference_density = 1.95,
        .density_at_0 = 0.131,
        .density_per_hu = 1.067e-3,
        .layer = 2e-3,
        .layer_stiffness = 5e7,
    };
}

double ost_force_energy(const ost_force_params *params, int hu)
{
    const double density = params->density_at_0 + params->density_per_hu * hu, share = density / params->reference_density;
    return density > 0 ? params->energy * share * share : 0;
}

ost_safety_params ost_safety_defaults(void)
{
    return (ost_safety_params){
        .max_n = 3.0,
        .max_nm = 0.1,
        .slew_n = 0.3,
        .ramp_s = 0.5,
        .stale_ticks = 2,
        .dead_man = 0,
        .stored_j = 0.015,
        .max_damping = 2,
    };
}
