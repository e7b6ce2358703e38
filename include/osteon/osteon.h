/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon: a surgical simulation platform for glenoid reaming and other joints.
 * This header includes the complete library; each concept has its own header.
 *
 *   status.h    statuses, error messages, versions   backend.h    grids, bones and tools, and operations on them
 *   length.h    exact lengths in picometres          io.h         reading and writing files
 *   pose.h      position and rotation of a tool      phantom.h    generated bones and parametric tools
 *   grid.h      dense grids of densities             sim.h        the world and its step
 *   mesh.h      triangle meshes                      picture.h    pictures without a display
 *   tool.h      tool grids                           path.h       the motion of a tool over time
 *   digest.h    SHA-256 of grids                     event.h      sweeps, maps, events and their reports
 *   plugin.h    external backends, loaded from files session.h    recorded operations
 *   haptics.h   devices and the servo loop           operation.h  a world whose tools a device moves
 *   force.h     force feedback and safety layer      metrics.h    the outcome of an operation
 *   render.h    voxels drawn as points               live.h       the state of a running operation for viewers
 *   motor.h     the motor that turns a tool          segment.h    a CT divided into bones
 *   anatomy.h   spheres and landmarks of a scapula   difference.h the class of the difference between two grids
 *
 * Threads: the comment at the top of each header states on which threads its functions may be called.
 */
#ifndef OSTEON_H
#define OSTEON_H

#include <osteon/anatomy.h>
#include <osteon/backend.h>
#include <osteon/difference.h>
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
#include <osteon/segment.h>
#include <osteon/session.h>
#include <osteon/sim.h>
#include <osteon/status.h>
#include <osteon/tool.h>

#endif
