/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 06: records an operation, then replays it and compares every tick.
 *
 *   06_session record BONE.nrrd TOOL.nrrd SESSION
 *   06_session replay BONE.nrrd TOOL.nrrd SESSION
 *
 * A session contains the ticks and a digest of the result of each tick, but no voxels
 * (docs/spec/session.md).  The replay needs the same bone and the same tool.  It may use
 * any backend.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

/* Drills a peg's hole and records each tick. */
static ost_status record(ost_world *world, const ost_bone *bone, const ost_path *path, const char *file, ost_error *err)
{
    ost_session_header *header = NULL;
    ost_recorder *recorder = NULL;
    ost_step_result step;
    ost_world_totals totals;
    ost_record entry;
    ost_session_end end;
    const int classes = ost_world_classes(world)->count;
    ost_status status = ost_session_header_create(&header, err);

    if (!status)
        status = ost_session_header_set(header, "program", "06_session", err);
    if (!status)
        status = ost_recorder_open(file, header, NULL, &recorder, err);
    for (size_t i = 0; !status && i < path->count; i++) {
        status = ost_world_step(world, &path->ticks[i], &step, err);
        if (status)
            break;
        memset(&entry, 0, sizeof entry);
        entry.kind = OST_RECORD_TICK;
        entry.as.tick.number = i;
        entry.as.tick.tick = path->ticks[i];
        entry.as.tick.digest = ost_step_digest(&step, classes);
        entry.as.tick.poses = (uint16_t)step.pose_count;
        entry.as.tick.flags = (step.removal ? OST_TICK_REMOVAL : 0) | (step.boxes_meet ? OST_TICK_MET : 0);
        if (step.report) {
            entry.as.tick.removed = (uint32_t)step.report->total_voxels;
            entry.as.tick.touched = (uint32_t)step.report->touched_voxels;
        }
        /* This call waits for space in the buffer. A servo loop calls ost_recorder_put instead, which never waits. */
        if (!ost_recorder_put_waiting(recorder, &entry))
            status = ost_fail(err, OST_ERR_IO, "%s: tick %zu could not be recorded", file, i);
    }
    memset(&end, 0, sizeof end);
    ost_world_totals_get(world, &totals);
    end.ticks = totals.ticks;
    end.removals = totals.removals;
    end.removed_voxels = totals.removed_voxels;
    end.has_root = true;
    if (!status)
        status = ost_bone_digest(bone, NULL, &end.root, err);
    /* The recorder is closed even after an error. The session then has no end record, as if it had been interrupted. */
    if (recorder) {
        const ost_status closed = ost_recorder_close(recorder, status ? NULL : &end, status ? NULL : err);
        status = status ? status : closed;
    }
    if (!status)
        printf("%llu ticks recorded\n", (unsigned long long)totals.ticks);
    ost_session_header_free(header);
    return status;
}

/* Repeats the ticks of a session and compares the digest of each step with the recorded digest. */
static ost_status replay(ost_world *world, const ost_bone *bone, const char *file, ost_error *err)
{
    ost_session *session = NULL;
    ost_record entry;
    ost_step_result step;
    ost_digest root;
    unsigned long long ticks = 0;
    bool more = true, ended = false;
    const int classes = ost_world_classes(world)->count;
    ost_status status = ost_session_open(file, &session, err);

    while (!status && !(status = ost_session_next(session, &entry, &more, err)) && more) {
        if (entry.kind == OST_RECORD_TICK) {
            /*
             * If a tick number is missing, a tick was lost because the file is damaged. The ticks after it
             * cannot be replayed.
             */
            if (entry.as.tick.number != ticks)
                status = ost_fail(err, OST_ERR_INPUT, "%s: tick %llu is missing", file, ticks);
            if (!status)
                status = ost_world_step(world, &entry.as.tick.tick, &step, err);
            if (!status && ost_step_digest(&step, classes) != entry.as.tick.digest)
                status = ost_fail(err, OST_ERR_DIFFER, "%s: tick %llu has another result", file, ticks);
            ticks++;
        } else if (entry.kind == OST_RECORD_END && entry.as.end.has_root) {
            ended = true;
            status = ost_bone_digest(bone, NULL, &root, err);
            if (!status && !ost_digest_equal(&root, &entry.as.end.root))
                status = ost_fail(err, OST_ERR_DIFFER, "%s: the bone at the end is another one", file);
        }
    }
    if (!status)
        printf("%llu ticks replayed, %s\n", ticks,
               ended ? "the bone is bit-identical" : "the session was interrupted");
    ost_session_close(session);
    return status;
}

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_tool *tool = NULL;
    ost_world *world = NULL;
    ost_tool_volume volume;
    ost_path path;
    ost_motor motor;
    ost_import_result source;
    ost_glenoid glenoid;
    int index = 0;
    ost_status status;

    if (argc != 5 || (strcmp(argv[1], "record") != 0 && strcmp(argv[1], "replay") != 0)) {
        fprintf(stderr, "usage: 06_session record|replay BONE.nrrd TOOL.nrrd SESSION\n");
        return 2;
    }
    memset(&volume, 0, sizeof volume);
    memset(&path, 0, sizeof path);
    memset(&motor, 0, sizeof motor);

    status = ost_backend_open("cpu", &backend, &err);
    if (!status)
        status = ost_import(backend, argv[2], NULL, &bone, &source, &err);
    if (!status)
        status = ost_tool_volume_read(argv[3], &volume, &err);
    if (!status)
        status = ost_tool_upload(backend, &volume, &tool, &err);
    if (!status)
        status = ost_world_create(bone, NULL, &world, &err);
    if (!status)
        status = ost_world_add_tool(world, "peg", tool, &index, &err);
    if (!status && strcmp(argv[1], "replay") == 0)
        status = replay(world, bone, argv[4], &err);
    else if (!status) {
        status = ost_glenoid_from_meta(&source.meta, &glenoid, &err);
        if (!status)
            status = ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &volume.geometry, index, &path, &err);
        if (!status)
            status = ost_motor_path(&path, OST_RPM_REAMER, &motor, &err);
        if (!status)
            status = record(world, bone, &path, argv[4], &err);
    }
    if (status)
        fprintf(stderr, "06_session: %s\n", err.text);

    ost_path_free(&path);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_tool_volume_free(&volume);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return ost_status_exit(status);
}
