# SPDX-License-Identifier: Apache-2.0
"""A module of 3D Slicer that reams a glenoid with osteon: landmarks, a tool, and the result as a volume and segments.

The calculation is in OsteonReamingLib/reaming.py, which does not use Slicer.
"""
import logging

import ctk
import numpy as np
import qt
import slicer
import vtk
from slicer.ScriptedLoadableModule import (ScriptedLoadableModule, ScriptedLoadableModuleLogic,
                                           ScriptedLoadableModuleTest, ScriptedLoadableModuleWidget)


class OsteonReaming(ScriptedLoadableModule):
    """Describes the module."""

    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "Osteon Reaming"
        self.parent.categories = ["Surgical Planning"]
        self.parent.dependencies = []
        self.parent.contributors = ["the authors of osteon"]
        self.parent.helpText = ("Reams a glenoid in a CT. Place at least three points on the rim of the glenoid and one "
                                "point on its medial side, choose a tool, and press Ream. Not for clinical use.")
        self.parent.acknowledgementText = "osteon: bit-exact voxel reaming."


class OsteonReamingWidget(ScriptedLoadableModuleWidget):
    """The panel of the module."""

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        box = ctk.ctkCollapsibleButton()
        box.text = "Ream"
        self.layout.addWidget(box)
        form = qt.QFormLayout(box)

        self.volume = self._nodes("vtkMRMLScalarVolumeNode", none=False)
        form.addRow("CT:", self.volume)
        self.segment = slicer.qMRMLSegmentSelectorWidget()
        self.segment.setMRMLScene(slicer.mrmlScene)
        self.segment.noneEnabled = True
        self.segment.setToolTip("The scapula. Without a segment, the humerus is reamed too.")
        form.addRow("Scapula (optional):", self.segment)
        self.rim = self._points("Glenoid rim")
        form.addRow("Points on the rim:", self.rim)
        self.medial = self._points("Medial point")
        form.addRow("Medial point:", self.medial)
        self.model = self._nodes("vtkMRMLModelNode", none=True)
        self.model.setToolTip("A model whose working face points to -z. None: a reamer of the diameter below.")
        form.addRow("Tool (optional):", self.model)
        self.diameter = self._number(10, 60, 36)
        form.addRow("Diameter of the reamer (mm):", self.diameter)
        self.depth = self._number(0.5, 15, 3)
        form.addRow("Depth (mm):", self.depth)
        self.threshold = self._number(-1000, 3000, 120)
        form.addRow("Threshold (HU):", self.threshold)
        self.button = qt.QPushButton("Ream")
        self.button.connect("clicked(bool)", self.onReam)
        form.addRow(self.button)
        self.report = qt.QLabel()
        self.report.wordWrap = True
        form.addRow(self.report)
        self.layout.addStretch(1)

    def _nodes(self, kind, none):
        box = slicer.qMRMLNodeComboBox()
        box.nodeTypes = [kind]
        box.addEnabled = box.removeEnabled = False
        box.noneEnabled = none
        box.setMRMLScene(slicer.mrmlScene)
        if none:
            box.setCurrentNode(None)
        return box

    def _points(self, name):
        node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsFiducialNode", name)
        place = slicer.qSlicerMarkupsPlaceWidget()
        place.setMRMLScene(slicer.mrmlScene)
        place.setCurrentNode(node)
        return place

    def _number(self, least, most, value):
        box = qt.QDoubleSpinBox()
        box.minimum, box.maximum, box.value = least, most, value
        return box

    def onReam(self):
        try:
            slicer.app.setOverrideCursor(qt.Qt.WaitCursor)
            result = OsteonReamingLogic().ream(
                self.volume.currentNode(), self.rim.currentNode(), self.medial.currentNode(), self.model.currentNode(),
                self.diameter.value, self.depth.value, int(self.threshold.value),
                self.segment.currentNode(), self.segment.currentSegmentID())
            parts = ", ".join(f"{count} {name}" for name, count in result.by_class.items())
            self.report.text = f"{result.voxels} voxels removed, {result.volume_mm3:.1f} mm3 ({parts})"
        except Exception as error:  # pylint: disable=broad-except  # the text is for the user
            logging.error("Osteon Reaming: %s", error)
            slicer.util.errorDisplay(str(error))
        finally:
            slicer.app.restoreOverrideCursor()


class OsteonReamingLogic(ScriptedLoadableModuleLogic):
    """Reads nodes of the scene, calls the library, and makes nodes of the result."""

    def ream(self, volume, rim, medial, model=None, diameter_mm=36.0, depth_mm=3.0, threshold=120, segmentation=None,
             segment_id=""):
        """Reams the glenoid of a volume node, and shows the result. Returns a reaming.Reamed."""
        from OsteonReamingLib import reaming  # the package osteon is needed from here on
        if volume is None:
            raise ValueError("no CT is selected")
        if medial is None or medial.GetNumberOfControlPoints() != 1:
            raise ValueError("place exactly one medial point")
        matrix = vtk.vtkMatrix4x4()
        volume.GetIJKToRASMatrix(matrix)
        mask = None
        if segmentation is not None and segment_id:
            mask = slicer.util.arrayFromSegmentBinaryLabelmap(segmentation, segment_id, volume)
        tool = reaming.tool_mesh(diameter_mm=diameter_mm) if model is None else reaming.tool_mesh(
            slicer.util.arrayFromModelPoints(model),
            np.reshape(slicer.util.arrayFromModelPolyIds(model), (-1, 4))[:, 1:])  # triangles: 3, a, b, c
        result = reaming.ream(
            slicer.util.arrayFromVolume(volume), slicer.util.arrayFromVTKMatrix(matrix),
            slicer.util.arrayFromMarkupsControlPoints(rim, world=True),
            slicer.util.arrayFromMarkupsControlPoints(medial, world=True)[0], tool, depth_mm=depth_mm,
            threshold=threshold, mask=mask)
        self.show(volume, result)
        return result

    def show(self, volume, result):
        """Adds the remaining bone as a volume, and the removed bone as a segment."""
        bone = slicer.util.addVolumeFromArray(result.bone, result.ijk_to_ras, volume.GetName() + " reamed")
        labels = slicer.util.addVolumeFromArray(result.removed, result.ijk_to_ras, "removed",
                                                "vtkMRMLLabelMapVolumeNode")
        segments = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLSegmentationNode", volume.GetName() + " removed")
        slicer.modules.segmentations.logic().ImportLabelmapToSegmentationNode(labels, segments)
        slicer.mrmlScene.RemoveNode(labels)
        segments.CreateClosedSurfaceRepresentation()
        slicer.util.setSliceViewerLayers(background=bone)


class OsteonReamingTest(ScriptedLoadableModuleTest):
    """Reams a generated glenoid in Slicer."""

    def setUp(self):
        slicer.mrmlScene.Clear()

    def runTest(self):
        self.setUp()
        self.test_generated_glenoid()

    def test_generated_glenoid(self):
        import osteon
        ct = osteon.phantom.ct("glenoid")
        glenoid = osteon.Glenoid.of_meta(ct.meta)
        flip = np.diag([-1.0, -1.0, 1.0, 1.0])
        to_lps = np.diag(list(ct.geometry.spacing_mm) + [1.0])
        to_lps[:3, 3] = ct.geometry.origin_mm
        volume = slicer.util.addVolumeFromArray(ct.voxels, flip @ to_lps, "CT")
        centre = np.array([osteon.to_mm(v) for v in glenoid.at_pm])
        axis = np.array(glenoid.axis) / np.linalg.norm(glenoid.axis)
        across = np.cross(axis, [0, 0, 1])
        across /= np.linalg.norm(across)
        points = [centre + 12 * (np.cos(t) * across + np.sin(t) * np.cross(axis, across)) for t in np.arange(6)]
        rim, medial = (slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsFiducialNode") for _ in range(2))
        slicer.util.updateMarkupsControlPointsFromArray(rim, np.array(points) @ flip[:3, :3])
        slicer.util.updateMarkupsControlPointsFromArray(medial, (centre + 30 * axis)[None] @ flip[:3, :3])
        result = OsteonReamingLogic().ream(volume, rim, medial)
        self.assertGreater(result.voxels, 1000)
        self.assertEqual(result.voxels, int(result.removed.sum()))
        self.assertEqual(slicer.util.getNode("CT reamed").GetImageData().GetDimensions(), result.bone.shape[::-1])
        self.delayDisplay("Test passed")
