# SPDX-License-Identifier: Apache-2.0
"""Tests osteon.check: a correct implementation is equal; wrong implementations are detected, located and minimised."""
import numpy as np
import pytest
from removal import half_up, removal

import osteon


def small(voxels, tool, pose=osteon.Pose(), **options):
    """Returns a case of one pose with voxels of 1 mm. The corner of the tool's grid is at 0."""
    voxels, tool = np.asarray(voxels, np.int16), np.asarray(tool, np.uint8)
    return osteon.Case.of(osteon.Volume(voxels, osteon.Geometry.of(voxels.shape, 1, (0.5, 0.5, 0.5))),
                          [osteon.ToolVolume(tool, osteon.ToolGeometry(tool.shape[::-1], 10**9, (0, 0, 0)))],
                          osteon.Path.of_poses([pose]), **options)


def test_correct_implementation_is_equal():
    result = osteon.check(removal(), list(osteon.campaign_cases("poses")) + list(osteon.campaign_cases("reach/3"))
                          + list(osteon.tie_cases()))
    assert result and result.verdict == "EQUAL" and result.touched_compared
    assert sum(case.events for case in result.cases) >= 100 and len(result.cases) == 5 + 1 + 9
    result.raise_if_different()


def test_wrong_tie_is_located():
    result = osteon.check(removal(rhe=half_up), "ties")
    assert [f.case for f in result.findings] == [f"ties/{name}-{a}" for a in "xyz" for name in ("base", "step")]
    for finding, at in zip(result.findings, [a for a in range(3) for _ in range(2)]):
        assert finding.kind == "missed" and finding.voxel == (1, 1, 1) and finding.different == 1
        assert finding.operands[0].u[at] == 4 * 2**20 - 1 and finding.operands[0].tool_voxel == (3, 3, 3)
        assert finding.margin == 1  # a coordinate that is one unit greater lies outside the cutting voxels
        assert np.count_nonzero(finding.minimised.bone.voxels) == 1 == len(finding.minimised.maps)
    border = osteon.check(removal(lower_border=True), "ties")
    assert [f.case for f in border.findings] == [f"ties/border-{a}" for a in "xyz"]
    assert {f.margin for f in border.findings} == {1}


def test_lost_layer_is_located_and_minimised(tmp_path):
    lost = removal(lost_layers=1)
    tool = np.ones((3, 4, 5), np.uint8)
    case = small(np.full((40, 40, 40), 500), tool, osteon.Pose.of((20, 17, 30)), name="mine")
    result = osteon.check(lost, case)
    finding, = result.findings
    # the tool covers the voxels 20 to 24, 17 to 20 and 30 to 32 along x, y and z, so its last layer is at z = 32
    assert finding.kind == "missed" and finding.voxel == (20, 17, 32) and finding.different == 20
    assert finding.box == ((20, 17, 32), (25, 21, 33)) and finding.chunk == (0, 0, 1)
    assert (finding.before, finding.expected, finding.got) == (500, 0, 500)
    assert finding.operands[0].tool_voxel == (0, 0, 2) and finding.operands[0].u == (2**19, 2**19, 2 * 2**20 + 2**19)
    assert finding.margin == 2**19 + 0  # the voxel is 2^20 units wide, and its lower neighbours are outside
    small_case = finding.minimised
    assert len(small_case.maps) == 1 and np.count_nonzero(small_case.bone.voxels) == 1
    assert np.count_nonzero(small_case.tool.voxels) == 1
    assert small_case.bone.geometry.dims == (20 - 16 + 1, 17 - 16 + 1, 1)  # the case is cropped at borders of blocks
    assert small_case.tool.geometry.dims == (1, 1, 1)
    # the small case can be stored; it shows the difference again, but none with a correct implementation
    small_case.save(tmp_path / "case.json")
    again = osteon.EventCase.load(tmp_path / "case.json")
    repeated = osteon.check(lost, again)
    assert repeated.findings[0].kind == "missed" and repeated.findings[0].voxel == (4, 1, 0)
    assert osteon.check(removal(), again)
    for part in ("NOT EQUAL: 1 case, 1 event compared", "mine: tick 0: missed: voxel (20, 17, 32)",
                 "1 pose, 1 bone voxel in 5 x 2 x 1, 1 tool voxel in 1 x 1 x 1"):
        assert part in str(result)
    with pytest.raises(osteon.DifferError, match="NOT EQUAL"):
        result.raise_if_different()


def test_campaign_cases_detect_lost_layer():
    findings = osteon.check(removal(lost_layers=1), "poses").findings
    assert [f.case for f in findings] == ["poses/4"]
    assert findings[0].minimised is not None and findings[0].minimised.bone.voxels.size <= 16 * 16 * 16


def test_position_equals_command(tmp_path, command):
    """For a dump of a wrong function's grids, `osteon compare` must report the same voxel, operand and margin."""
    wrong = removal(lost_layers=1)
    case, = osteon.campaign_cases("poses/4")
    folder = tmp_path / "dump" / "poses-4"
    folder.mkdir(parents=True)
    (tmp_path / "dump" / "dump.json").write_text('{"osteon_dump": 1, "only": "poses/4"}')
    with osteon.FunctionBackend(wrong, "ref") as backend:
        bone = backend.bone(case.bone, threshold=case.threshold, chunk_size=case.chunk_size)
        bone.voxels().tofile(folder / "chunks.raw")
        world = osteon.World(bone, [backend.tool(tool) for tool in case.tools], sweep=case.sweep,
                             removal_period_ns=case.removal_period_ns)
        for number, _ in enumerate(world.steps(case.path)):
            bone.voxels().tofile(folder / f"tick-{number}.raw")
    reported, = command.json("compare", tmp_path / "dump", status=1)["cases"]
    found, = osteon.check(wrong, case).findings
    assert (reported["stage"], reported["item"]) == ("tick", found.tick)
    assert reported["different_voxels"] == found.different
    assert (reported["voxel"], reported["chunk"]) == (list(found.voxel), list(found.chunk))
    assert (reported["reference"], reported["got"]) == (found.expected, found.got)
    operand = next(o["value"] for o in reported["operands"] if o["name"] == "pose 1 of 1")
    assert f"point {found.operands[0].u} / 2^20" in operand
    assert f"tool voxel {found.operands[0].tool_voxel}, cutting; {found.margin} / 2^20" in operand


def test_too_much_removed():
    tool = np.ones((2, 2, 2), np.uint8)
    tool[0] = 2
    finding, = osteon.check(removal(removes_touched=True), small(np.full((8, 8, 8), 500), tool)).findings
    assert finding.kind == "extra" and finding.voxel == (0, 0, 0) and finding.different == 4
    assert (finding.expected, finding.got) == (500, 0) and finding.operands[0].tool_class == 2
    assert finding.margin == 2**19  # distance from the centre of the voxel to the cutting layer above it


def test_other_differences():
    bone, tool = np.full((8, 8, 8), 500), np.array([[[1, 2]]], np.uint8)

    def halves(voxels, cutter, event):
        voxels //= 2

    finding, = osteon.check(halves, small(bone, tool)).findings
    assert finding.kind == "changed" and (finding.expected, finding.got) == (0, 250)

    def counts_wrong(voxels, cutter, event):
        return removal()(voxels, cutter, event) + 1

    finding, = osteon.check(counts_wrong, small(bone, tool)).findings
    assert (finding.kind, finding.expected, finding.got) == ("report", 1, 2)

    def does_not_count(voxels, cutter, event):
        removal()(voxels, cutter, event)

    result = osteon.check(does_not_count, small(bone, tool))
    assert result and not result.touched_compared and "not compared" in str(result)

    def fails(voxels, cutter, event):
        if voxels[0, 0, 0]:
            raise IndexError("a mistake")

    finding, = osteon.check(fails, small(bone, tool)).findings
    assert finding.kind == "error" and isinstance(finding.error, IndexError) and "a mistake" in str(finding)
    assert np.count_nonzero(finding.minimised.bone.voxels) == 1

    def returns_text(voxels, cutter, event):
        return "5"

    finding, = osteon.check(returns_text, small(bone, tool)).findings
    assert finding.kind == "error" and isinstance(finding.error, osteon.UsageError)


def test_function_with_state_is_not_minimised():
    calls = []

    def every_second(voxels, cutter, event):
        calls.append(1)
        return removal()(voxels, cutter, event) if len(calls) != 1 else None

    result = osteon.check(every_second, small(np.full((8, 8, 8), 500), np.ones((1, 1, 1))))
    assert result.findings[0].kind == "missed" and result.findings[0].minimised is None


def test_nothing_compared_is_not_equal():
    case = small(np.full((8, 8, 8), 500), np.ones((1, 1, 1)), osteon.Pose.of((100, 0, 0)))
    result = osteon.check(removal(), case)
    assert not result and result.verdict == "NOT COMPARED"
    assert osteon.check(removal(), []).verdict == "NOT COMPARED"


def test_stop_progress_and_minimise():
    cases = [small(np.full((8, 8, 8), 500), np.ones((1, 1, 1)), name=str(i)) for i in range(3)]

    def nothing(voxels, cutter, event):
        return 0

    seen = []
    result = osteon.check(nothing, cases, stop=True, minimise=False, progress=lambda *at: seen.append(at))
    assert len(result.cases) == 1 and seen == [("0", 0, 1)] and result.findings[0].minimised is None
    assert len(osteon.check(nothing, cases).findings) == 3


def test_missing_command(monkeypatch, tmp_path):
    with pytest.raises(osteon.UsageError, match="nocase"):
        list(osteon.campaign_cases("nocase"))
    monkeypatch.setattr("osteon.cases.text", lambda _: "")
    monkeypatch.setenv("OSTEON", str(tmp_path / "none"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(osteon.UnavailableError, match="OSTEON"):
        list(osteon.campaign_cases())
    assert len(list(osteon.cases.default_cases("ties"))) == 9


def test_damaged_case_files(tmp_path):
    for text in ("", "{}", '{"bone": 3}', '{"bone": {"dims": [0, 0, 0]}}'):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(osteon.InputError):
            osteon.EventCase.load(tmp_path / "bad.json")


def test_function_backend(inputs, tmp_path):
    """A session that is recorded with a function as the backend must replay on cpu with equal grids."""
    volume = osteon.phantom.ct("glenoid", spacing_mm="1")
    digests = []
    with osteon.FunctionBackend(removal()) as mine, osteon.Backend() as cpu:
        for backend in (mine, cpu):
            bone = backend.bone(volume)
            tool = backend.voxelize(osteon.phantom.tool("peg"), "1")
            path = osteon.Path.builtin("peg-hole", osteon.Glenoid.of_meta(volume.meta), tool).turned()[:1500]
            world = osteon.World(bone, [tool])
            if backend is mine:
                osteon.session.record(world, path, tmp_path / "f.session", sync=False)
            else:
                assert osteon.session.replay(tmp_path / "f.session", world).equal
            digests.append((bone.digest(), tool.digest(), world.totals, bone.info.active_voxels))
        assert digests[0] == digests[1] and digests[0][2].removed_voxels > 0 and mine.calls > 0
        assert mine.read_bone(inputs / "ct.nrrd").digest() == cpu.read_bone(inputs / "ct.nrrd").digest()
    with pytest.raises(osteon.UsageError):
        osteon.FunctionBackend(3)


def test_exceptions_of_function_are_chained():
    def fails(voxels, cutter, event):
        raise KeyError("here")

    def interrupted(voxels, cutter, event):
        raise KeyboardInterrupt

    for function in (fails, interrupted):
        with osteon.FunctionBackend(function) as backend:
            bone = backend.bone(osteon.Volume(np.full((4, 4, 4), 500), osteon.Geometry.of((4, 4, 4), 1)))
            tool = backend.tool(osteon.ToolVolume(np.ones((2, 2, 2), np.uint8),
                                                  osteon.ToolGeometry((2, 2, 2), 10**9, (0, 0, 0))))
            if function is fails:
                with pytest.raises(osteon.OsteonError, match="here") as caught:
                    bone.remove(tool, osteon.Pose())
                assert isinstance(caught.value.__cause__, KeyError)
            else:
                with pytest.raises(KeyboardInterrupt):
                    bone.remove(tool, osteon.Pose())
