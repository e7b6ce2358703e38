/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stand-in for Force Dimension's library. It has only the functions that the driver calls. If FAKE_SHORT
 * is defined, one of these functions is missing.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/fake/fake.h"

#define EXPORT __attribute__((visibility("default")))

EXPORT fake_note fake_dhd = {.column = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .type = 33};

EXPORT int dhdOpen(void);
EXPORT int dhdClose(char id);
EXPORT int dhdGetSystemType(char id);
EXPORT int dhdGetPositionAndOrientationFrame(double *x, double *y, double *z, double matrix[3][3], char id);
EXPORT int dhdGetButtonMask(char id);
EXPORT int dhdEnableForce(unsigned char on, char id);
EXPORT int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz,
                                               double gripper, char id);
EXPORT const char *dhdErrorGetLastStr(void);

/* Reads settings from the environment, for tests of the osteon command. */
__attribute__((constructor)) static void read_environment(void)
{
    const char *type = getenv("FAKE_DHD_TYPE");
    if (type)
        fake_dhd.type = atoi(type);
}

int dhdGetSystemType(char id)
{
    return id == -1 ? fake_dhd.type : -1;
}

int dhdOpen(void)
{
    fake_call(&fake_dhd, 'o');
    return fake_dhd.fail_open ? -1 : 0;
}

int dhdClose(char id)
{
    fake_call(&fake_dhd, id == -1 ? 'c' : '!');
    return 0;
}

int dhdGetPositionAndOrientationFrame(double *x, double *y, double *z, double matrix[3][3], char id)
{
    const int frame = atomic_fetch_add(&fake_dhd.frames, 1) + 1;
    fake_call(&fake_dhd, id == -1 ? 'p' : '!');
    if (frame == fake_dhd.fail_read_at)
        return -1;
    *x = frame == fake_dhd.no_number_at ? NAN : fake_dhd.position[0];
    *y = fake_dhd.position[1];
    *z = fake_dhd.position[2];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            matrix[i][j] = fake_dhd.column[j][i];
    return frame % 2; /* The result 1 means that the pose has not changed since the last call. */
}

int dhdGetButtonMask(char id)
{
    return id == -1 ? fake_dhd.buttons : -1;
}

int dhdEnableForce(unsigned char on, char id)
{
    fake_call(&fake_dhd, id == -1 ? (on ? 'e' : 'd') : '!');
    fake_dhd.forces_on = on;
    return 0;
}

#ifndef FAKE_SHORT
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz,
                                        double gripper, char id)
{
    fake_call(&fake_dhd, id == -1 && gripper == 0 ? 'f' : '!');
    memcpy(fake_dhd.force, (double[3]){fx, fy, fz}, sizeof fake_dhd.force);
    memcpy(fake_dhd.torque, (double[3]){tx, ty, tz}, sizeof fake_dhd.torque);
    if (fake_dhd.fail_write_at && fake_dhd.frames >= fake_dhd.fail_write_at)
        return -1;
    return 2; /* The result 2 means that a motor is at its limit. */
}
#endif

const char *dhdErrorGetLastStr(void)
{
    return "no device found";
}
