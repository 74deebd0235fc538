"""Opens the frames of a Makadam run in ParaView: grains as spheres by diameter, walls half transparent, contacts hidden.

In a terminal:   paraview --script=open-in-paraview.py      or      pvpython open-in-paraview.py picture.png
Inside ParaView: Tools > Python Shell > Run Script
"""

import os
import sys

from paraview.simple import *  # noqa: F403

# A script that is run from the Python shell may not know where it lies: then the folder is the present one (os.chdir).
folder = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()


def series(kind):
    """The frames of one kind, or nothing where the run has written none."""
    collection = os.path.join(folder, kind + ".pvd")
    if not os.path.exists(collection):
        return None
    source = PVDReader(registrationName=kind, FileName=collection)
    source.UpdatePipeline()
    return source


view = GetActiveViewOrCreate("RenderView")
view.UseColorPaletteForBackground = 0
view.BackgroundColorMode = "Single Color"
view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]

grains = series("grains")
spheres = Glyph(registrationName="spheres", Input=grains, GlyphType="Sphere")
spheres.GlyphType.ThetaResolution = 16
spheres.GlyphType.PhiResolution = 16
spheres.GlyphMode = "All Points"
spheres.OrientationArray = ["POINTS", "No orientation array"]
spheres.ScaleArray = ["POINTS", "diameter"]
spheres.ScaleFactor = 1.0
shown = Show(spheres, view)
fields = [grains.PointData[number].Name for number in range(grains.PointData.GetNumberOfArrays())]
for field in ("speed", "pressure", "diameter"):
    if field in fields:
        ColorBy(shown, ("POINTS", field))
        scale = GetColorTransferFunction(field)
        scale.ApplyPreset("Viridis (matplotlib)", True)
        shown.SetScalarBarVisibility(view, True)
        bar = GetScalarBar(scale, view)
        bar.TitleColor = [0.0, 0.0, 0.0]
        bar.LabelColor = [0.0, 0.0, 0.0]
        break

walls = series("walls")
if walls is not None:
    shown = Show(walls, view)
    shown.ColorArrayName = ["POINTS", ""]
    shown.Representation = "Surface"
    shown.DiffuseColor = [0.55, 0.6, 0.65]
    shown.AmbientColor = [0.55, 0.6, 0.65]
    shown.Opacity = 0.25

contacts = series("contacts")
if contacts is not None:
    shown = Show(contacts, view)
    ColorBy(shown, ("CELLS", "normal_force"))
    Hide(contacts, view)

GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
GetAnimationScene().GoToLast()

# From the front, a little from above, along gravity as the scene has it.
gravity = [0.0, 0.0, -1.0]
fields = grains.FieldData
if fields.GetArray("gravity") is not None:
    ranges = [fields.GetArray("gravity").GetRange(axis)[0] for axis in range(3)]
    length = sum(component * component for component in ranges) ** 0.5
    if length > 0.0:
        gravity = [component / length for component in ranges]
up = [-component for component in gravity]
front = [0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0]
level = sum(front[axis] * up[axis] for axis in range(3))
front = [front[axis] - level * up[axis] for axis in range(3)]
camera = view.CameraFocalPoint
view.CameraViewUp = up
view.CameraPosition = [camera[axis] - front[axis] + 0.35 * up[axis] for axis in range(3)]
ResetCamera(view)
Render(view)
GetDisplayProperties(spheres, view).RescaleTransferFunctionToDataRange(False, True)
Render(view)

if len(sys.argv) > 1 and sys.argv[-1].endswith(".png"):
    SaveScreenshot(sys.argv[-1], view, ImageResolution=[1600, 1200])
