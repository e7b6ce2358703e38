/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon: a surgical simulation platform for glenoid reaming, and any joint.
 * This header brings all of the library; each concept has its own.
 *
 *   status.h   what can go wrong               backend.h  who keeps the voxels
 *   length.h   picometres                      io.h       files in and out
 *   pose.h     where a tool is                 phantom.h  generated bones and tools
 *   grid.h     dense grids                     sim.h      the world and its step
 *   mesh.h     triangles                       picture.h  pictures without a display
 *   tool.h     tool grids                      path.h     a tool over time
 *   digest.h   SHA-256 of grids                event.h    sweep, map, report
 *   plugin.h   somebody else's backend         session.h  what happened, to be done again
 *   haptics.h  devices and their loop          operation.h  a world that a device moves
 *   force.h    what the hand feels             metrics.h  what an operation has come to
 *   render.h   voxels as points                live.h     what others see of a running operation
 */
#ifndef OSTEON_H
#define OSTEON_H

#include <osteon/backend.h>
#include <osteon/digest.h>
#include <osteon/event.h>
#include <osteon/force.h>
#include <osteon/grid.h>
#include <osteon/haptics.h>
#include <osteon/io.h>
#include <osteon/length.h>
#include <osteon/live.h>
#include <osteon/mesh.h>
#include <osteon/metrics.h>
#include <osteon/motor.h>
#include <osteon/operation.h>
#include <osteon/path.h>
#include <osteon/phantom.h>
#include <osteon/picture.h>
#include <osteon/plugin.h>
#include <osteon/pose.h>
#include <osteon/render.h>
#include <osteon/session.h>
#include <osteon/sim.h>
#include <osteon/status.h>
#include <osteon/tool.h>

#endif
